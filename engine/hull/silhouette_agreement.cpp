// SPDX-License-Identifier: MIT
// Carves on the CPU (carve_reference.cpp), then marches along the rays of the silhouettes' pixels.
#include "engine/hull/silhouette_agreement.h"

#include <algorithm>
#include <cmath>

#include "engine/core/task.h"
#include "engine/hull/carve.h"

namespace airclay {
namespace {

// 64 voxels along 60 cm are 9 mm each, half a finger's width. Alternative rigs are first tried with 32, which
// is 8 times as fast.
constexpr int kVoxels = 64, kCoarseVoxels = 32;
// Sampled pixels per silhouette: enough for a fraction accurate to 1 %.
constexpr std::size_t kPixels = 3000;
// A correct rig explains nearly all pixels. Parts outside the cube (a forearm) whose rays cross it stay
// unexplained.
constexpr double kGoodFraction = 0.85, kContradictionFraction = 0.3;
// An alternative rig must explain this much to be suggested.
constexpr double kConvincingFraction = 0.8;

/// The hull dilated by one voxel: carving tests voxel centres, and a thin finger may be between them.
class DilatedHull {
 public:
  DilatedHull(const Rig& rig, const SilhouetteSet& masks, int voxels)
      : workspace_(rig.workspace), voxels_(voxels), dilated_(carveReference(rig, masks, voxels).occupied) {
    for (int axis = 0; axis < 3; ++axis) dilate(axis);
  }

  enum class Hit { kMissesCube, kMissesHull, kHull };
  Hit castRay(const Vec3& eye, const Vec3& direction) const {
    const double voxel_m = workspace_.edge_m / voxels_;
    const Vec3 low = workspace_.center - Vec3::Constant(workspace_.edge_m / 2);
    double from = 0, to = 1e9;
    for (int axis = 0; axis < 3; ++axis) {  // the slabs of the cube
      if (direction(axis) == 0) {
        const double offset_m = eye(axis) - low(axis);
        if (offset_m < 0 || offset_m > workspace_.edge_m) return Hit::kMissesCube;
        continue;
      }
      const double a = (low(axis) - eye(axis)) / direction(axis);
      const double b = a + workspace_.edge_m / direction(axis);
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    if (from >= to) return Hit::kMissesCube;
    for (double at = from; at < to; at += voxel_m / 2)
      if (occupiedAt((eye + at * direction - low) / voxel_m)) return Hit::kHull;
    return Hit::kMissesHull;
  }

 private:
  bool occupiedAt(const Vec3& in_voxels) const {
    const Eigen::Vector3i voxel = in_voxels.array().floor().cast<int>();
    if (voxel.minCoeff() < 0 || voxel.maxCoeff() >= voxels_) return false;
    return dilated_[std::size_t(voxel.x() + voxels_ * (voxel.y() + voxels_ * voxel.z()))] != 0;
  }

  void dilate(int axis) {
    const std::vector<std::uint8_t> before = dilated_;
    const std::size_t edge = std::size_t(voxels_), step = axis == 0 ? 1 : axis == 1 ? edge : edge * edge;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (!before[i]) continue;
      const std::size_t at = i / step % edge;
      if (at > 0) dilated_[i - step] = 1;
      if (at + 1 < edge) dilated_[i + step] = 1;
    }
  }

  Workspace workspace_;
  int voxels_;
  std::vector<std::uint8_t> dilated_;
};

void addAgreement(const Camera& camera, const Silhouette& mask, const DilatedHull& hull,
                  SilhouetteAgreement& agreement) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < mask.pixels.size(); ++i)
    if (mask.pixels[i] >= Silhouette::kThreshold) pixels.push_back(i);
  const Pose world_from_camera = camera.camera_from_world.inverse();
  const std::size_t stride = pixels.size() / kPixels + 1;
  for (std::size_t i = 0; i < pixels.size(); i += stride) {
    const std::size_t width = std::size_t(mask.width);
    const Vec2 pixel(double(pixels[i] % width), double(pixels[i] / width));
    const std::optional<Vec3> ray = rayThroughPixel(camera.lens, pixel);
    if (!ray) continue;
    ++agreement.pixels;
    const DilatedHull::Hit hit =
        hull.castRay(world_from_camera.translation(), world_from_camera.linear() * *ray);
    agreement.in_cube += hit != DilatedHull::Hit::kMissesCube;
    agreement.explained += hit == DilatedHull::Hit::kHull;
  }
}

/// Over all cameras' pixels; 0 if most of them miss the cube, because nothing is explained then.
double explainedFraction(std::span<const SilhouetteAgreement> agreement) {
  SilhouetteAgreement sum;
  for (const SilhouetteAgreement& one : agreement) {
    sum.pixels += one.pixels;
    sum.in_cube += one.in_cube;
    sum.explained += one.explained;
  }
  return 2 * sum.in_cube < sum.pixels ? 0 : sum.explainedFraction();
}

/// The mirrored rig: the world about the cube's centre in x, the images in `image_axis` (0: left to right).
/// This undoes a left-handed world whose poses were made rotations by also flipping an axis of the cameras.
Rig mirrored(const Rig& rig, int image_axis) {
  Rig result = rig;
  Vec3 in_world(-1, 1, 1), in_camera = Vec3::Ones();
  in_camera(image_axis) = -1;
  const Vec3& center = rig.workspace.center;
  for (Camera& camera : result.cameras) {
    const Mat3 rotation = camera.camera_from_world.linear();
    const Vec3 shift =
        rotation * (center - in_world.cwiseProduct(center)) + camera.camera_from_world.translation();
    camera.camera_from_world.linear() = in_camera.asDiagonal() * rotation * in_world.asDiagonal();
    camera.camera_from_world.translation() = in_camera.cwiseProduct(shift);
  }
  return result;
}

std::vector<SilhouetteAgreement> agreementAt(int voxels, const Rig& rig,
                                             std::span<const SilhouetteSet> instants) {
  std::vector<SilhouetteAgreement> agreement(rig.cameras.size());
  for (const SilhouetteSet& masks : instants) {
    const DilatedHull hull(rig, masks, voxels);
    for (std::size_t i = 0; i < rig.cameras.size(); ++i)
      addAgreement(rig.cameras[i], masks[i], hull, agreement[i]);
  }
  return agreement;
}

/// An alternative to the given rig.
struct Hypothesis {
  double explained_fraction = 0;
  std::string camera;  ///< the camera that is left out; empty: the change in `what`
  std::string what;
};

/// Tries common mistakes in rigs and finds the one that explains most.
class HypothesisSearch {
 public:
  HypothesisSearch(const Rig& rig, std::span<const SilhouetteSet> instants)
      : rig_(rig), instants_(instants.begin(), instants.begin() + std::min<long>(2, std::ssize(instants))) {}

  Hypothesis best() {
    for (const PoseConvention poses : kPoseConventions)
      evaluate(withPoseConvention(rig_, poses), {0, "", "poses that are " + describe(poses)});
    const std::string mirror = "a mirrored rig (a left-handed world, or images flipped ";
    evaluate(mirrored(rig_, 0), {0, "", mirror + "left to right)"});
    evaluate(mirrored(rig_, 1), {0, "", mirror + "top to bottom)"});
    for (const auto& [factor, unit] : {std::pair{1e-3, "millimetres"}, std::pair{1e-2, "centimetres"},
                                       std::pair{1e3, "metres, not millimetres"}}) {
      Rig scaled = rig_;
      for (Camera& camera : scaled.cameras) camera.camera_from_world.translation() *= factor;
      evaluate(scaled, {0, "", std::string("translations in ") + unit});
    }
    if (rig_.cameras.size() <= 8) trySwaps();  // 28 pairs
    tryWithoutOneCamera();
    return best_;
  }

 private:
  void evaluate(const Rig& rig, const Hypothesis& hypothesis) { evaluate(rig, instants_, hypothesis); }

  void evaluate(const Rig& rig, std::span<const SilhouetteSet> instants, Hypothesis hypothesis) {
    reportProgress(0.5);
    if (explainedFraction(agreementAt(kCoarseVoxels, rig, instants)) < kConvincingFraction) return;
    hypothesis.explained_fraction = explainedFraction(agreementAt(kVoxels, rig, instants));
    if (hypothesis.explained_fraction > best_.explained_fraction) best_ = hypothesis;
  }

  void trySwaps() {
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Rig swapped = rig_;
        Camera &a = swapped.cameras[i], &b = swapped.cameras[j];
        if (a.width != b.width || a.height != b.height) continue;
        std::swap(a, b);
        evaluate(swapped, {0, "", "cameras \"" + a.name + "\" and \"" + b.name + "\" swapped"});
      }
  }

  /// Not with three cameras: the remaining two would agree too easily.
  void tryWithoutOneCamera() {
    for (std::size_t i = 0; rig_.cameras.size() >= 4 && i < rig_.cameras.size(); ++i) {
      Rig rest = rig_;
      rest.cameras.erase(rest.cameras.begin() + static_cast<long>(i));
      std::vector<SilhouetteSet> instants = instants_;
      for (SilhouetteSet& masks : instants) masks.erase(masks.begin() + static_cast<long>(i));
      evaluate(rest, instants, {0, rig_.cameras[i].name, ""});
    }
  }

  const Rig& rig_;
  const std::vector<SilhouetteSet> instants_;
  Hypothesis best_;
};

std::string percent(double fraction) {
  return std::to_string(static_cast<int>(std::lround(100 * fraction))) + " %";
}

}  // namespace

std::vector<SilhouetteAgreement> silhouetteAgreement(const Rig& rig,
                                                     std::span<const SilhouetteSet> instants) {
  return agreementAt(kVoxels, rig, instants);
}

std::vector<RigDiagnostic> silhouetteDiagnostics(const Rig& rig, std::span<const SilhouetteSet> instants,
                                                 std::span<const SilhouetteAgreement> agreement,
                                                 SilhouetteSource source) {
  double pixels = 0, in_cube = 0;
  for (std::size_t i = 0; i < agreement.size(); ++i) {
    pixels += double(agreement[i].pixels);
    in_cube += double(agreement[i].in_cube);
  }
  if (pixels == 0) return {};
  const double explained = explainedFraction(agreement);
  if (explained >= kGoodFraction) return {};
  const Hypothesis other = HypothesisSearch(rig, instants).best();
  const bool is_better =
      other.explained_fraction >= kConvincingFraction && other.explained_fraction > explained + 0.1;
  const std::string result = "the hull explains " + percent(explained) + " of the silhouettes";
  RigDiagnostic diagnostic;
  if (is_better && other.camera.empty()) {
    diagnostic.message =
        result + ", but " + percent(other.explained_fraction) + " with " + other.what + "; correct the rig";
  } else if (is_better) {
    diagnostic = {Severity::kWarning, other.camera,
                  result + ", but " + percent(other.explained_fraction) +
                      " without it: was it moved after the calibration, or is its recording not in sync?"};
  } else {
    const bool is_possible = explained >= kContradictionFraction || source == SilhouetteSource::kAssumed;
    diagnostic.severity = is_possible ? Severity::kWarning : Severity::kError;
    diagnostic.message =
        in_cube < 0.5 * pixels
            ? "only " + percent(in_cube / pixels) +
                  " of the silhouettes' pixels look into the cube; check that [workspace] surrounds the "
                  "motion, and the units of the translations"
            : result +
                  ": cameras and recordings contradict each other; expected the calibration of this "
                  "recording, synchronized cameras, and clean silhouettes";
    if (source == SilhouetteSource::kAssumed) diagnostic.message += " (and first frames without a person)";
  }
  return {diagnostic};
}

}  // namespace airclay
