// SPDX-License-Identifier: MIT
#include "engine/clay/clay.h"

#include "engine/core/error.h"

namespace airclay {

Clay::Clay(Gpu& gpu, const ClayState& state, const Vec3& workspace_center)
    : gpu_(gpu),
      workspace_center_(workspace_center),
      workspace_from_clay_(state.workspace_from_clay),
      cage_faces_(state.cage.faces),
      solve_method_(state.solve),
      levels_(state.levels),
      subdivision_(subdivide(state.cage, state.levels, state.rule)),
      evaluator_(gpu, subdivision_),
      exact_points_(gpu, 3 * state.cage.points.size()),
      control_points_(gpu, state.cage.points.size()) {
  setControlPoints(state.cage.points);
}

PolygonMesh Clay::cage() const {
  PolygonMesh mesh{downloadControlPoints(), cage_faces_};
  for (Vec3& point : mesh.points) point = workspace_from_clay_ * point + workspace_center_;
  return mesh;
}

PolygonMesh Clay::surface() const {
  PolygonMesh mesh;
  for (const vec3& point : dataPoints().download())
    mesh.points.push_back(workspace_from_clay_ * point.cast<double>() + workspace_center_);
  for (const std::array<int, 4>& quad : subdivision_.quads) mesh.faces.emplace_back(quad.begin(), quad.end());
  return mesh;
}

void Clay::setControlPoints(const std::vector<Vec3>& points) {
  if (static_cast<int>(points.size()) != controlPointCount())
    throw Error("got " + std::to_string(points.size()) + " control points; expected " +
                std::to_string(controlPointCount()) + ", the number in the cage");
  std::vector<Vec3> in_clay = points;
  for (Vec3& point : in_clay) point = workspace_from_clay_.conjugate() * (point - workspace_center_);
  uploadControlPoints(in_clay);
  Recorder recorder(gpu_);
  recorder.begin(Timing::kNone);
  evaluator_.record(recorder, control_points_);
  recorder.submitAndWait();
  ++edits_;
}

void Clay::setControlPoints(const std::vector<Vec3>& points, const Eigen::Quaterniond& workspace_from_clay) {
  workspace_from_clay_ = workspace_from_clay;
  setControlPoints(points);
}

void Clay::rotate(const Eigen::Quaterniond& rotation) {
  workspace_from_clay_ = (rotation * workspace_from_clay_).normalized();
  ++edits_;
}

std::vector<Vec3> Clay::downloadControlPoints() const {
  const std::vector<double> exact = exact_points_.download();
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < exact.size(); i += 3) points.emplace_back(exact[i], exact[i + 1], exact[i + 2]);
  return points;
}

void Clay::uploadControlPoints(const std::vector<Vec3>& points) {
  std::vector<double> exact;
  std::vector<vec3> rounded;
  for (const Vec3& point : points) {
    exact.insert(exact.end(), point.data(), point.data() + 3);
    rounded.push_back(point.cast<float>());
  }
  exact_points_.upload(exact);
  control_points_.upload(rounded);
}

}  // namespace airclay
