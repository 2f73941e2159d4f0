// SPDX-License-Identifier: MIT
// The reference implementation of fit.comp: one hypothesis, serial, in double precision. Equations: section 2
// of the paper.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/hand/fit.h"

namespace airclay {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

struct Forces {
  Vec6 force_and_moment = Vec6::Zero();
  Mat6 stiffness = Mat6::Zero();
  double outside_area_m3 = 0;  // Σ a s over the patches outside
  int outside = 0;
};

Forces forcesAt(const FitModel& model, const std::vector<double>& field, const FieldGrid& grid,
                const Eigen::Quaterniond& rotation, const Vec3& position) {
  Forces forces;
  const double margin_m = kFitMargin * grid.cell_m;
  const Mat3 turn = rotation.toRotationMatrix();
  for (const GpuPatch& patch : model.patches) {
    const Vec3 r = turn * patch.center.cast<double>(), n = turn * patch.normal.cast<double>();
    const double s = patch.cut ? 0 : fieldDistance(field, grid, position + r);
    if (!patch.cut && s > 0) {
      forces.outside_area_m3 += patch.area * s;
      ++forces.outside;
    }
    if (s + margin_m <= 0) continue;
    Vec6 j;
    j << n, r.cross(n);
    forces.force_and_moment -= patch.area * (s + margin_m) * j;
    if (!patch.cut) forces.stiffness += patch.area * j * j.transpose();
  }
  return forces;
}

}  // namespace

GpuFit fitReference(const FitModel& model, const std::vector<double>& field, const FieldGrid& grid,
                    const GpuFit& start, const FitLimits& limits) {
  // explained in fit.comp
  constexpr double inertia_weight = 0.01, max_turn = 0.25, max_shift = 0.03, stall_shift = 2e-5,
                   stall_turn = 2e-4;
  Eigen::Quaterniond rotation(Eigen::Vector4d(start.pose.rotation.cast<double>()));
  Vec3 position = start.pose.position.cast<double>();
  GpuFit result = start;
  result.outcome = kFitOutOfIterations;
  for (result.iterations = 0;; ++result.iterations) {
    const Forces forces = forcesAt(model, field, grid, rotation, position);
    result.outside_m = static_cast<float>(forces.outside_area_m3 / model.patch_area_m2);
    result.outside_count = static_cast<std::uint32_t>(forces.outside);
    result.outside_fraction = static_cast<float>(double(forces.outside) / double(model.patches.size()));
    if (forces.outside == 0) {
      result.outcome = kFitIncluded;
      break;
    }
    if (result.iterations == static_cast<std::uint32_t>(limits.iterations)) break;
    const Mat3 turn = rotation.toRotationMatrix();
    const double mass = inertia_weight * model.patch_area_m2;
    Mat6 matrix = forces.stiffness;
    matrix.topLeftCorner<3, 3>() += mass * Mat3::Identity();
    matrix.bottomRightCorner<3, 3>() += mass * turn * model.inertia_m2 * turn.transpose();
    Vec6 delta = matrix.llt().solve(forces.force_and_moment);
    const double shift = delta.head<3>().norm(), angle = delta.tail<3>().norm();
    delta *= std::min({1.0, max_shift / std::max(shift, 1e-9), max_turn / std::max(angle, 1e-9)});
    if (delta.tail<3>().norm() < stall_turn && delta.head<3>().norm() < stall_shift) {
      result.outcome = kFitStalled;
      break;
    }
    position += delta.head<3>();
    rotation = (Eigen::Quaterniond(rotationFromVector(delta.tail<3>())) * rotation).normalized();
  }
  result.pose.rotation = rotation.coeffs().cast<float>();
  result.pose.position = position.cast<float>();
  return result;
}

}  // namespace airclay
