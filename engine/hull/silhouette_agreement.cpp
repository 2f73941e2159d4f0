// SPDX-License-Identifier: MIT
// Carves with the reference (carve_reference.cpp), then walks along the rays of the silhouettes' pixels.
#include "engine/hull/silhouette_agreement.h"

#include <algorithm>
#include <cmath>

#include "engine/core/task.h"
#include "engine/hull/carve.h"

namespace airclay {
namespace {

// 64 voxels of 60 cm are 9 mm each, half a finger's width. Many rigs are tried at 32 first, 8 times as fast.
constexpr int kVoxels = 64, kFewVoxels = 32;
// A silhouette's pixels that are looked at: enough for a share to a percent.
constexpr std::size_t kPixels = 3000;
// A true rig explains nearly all; what sticks out of the cube (a forearm) but is seen through it stays
// unexplained.
constexpr double kGoodShare = 0.85, kContradiction = 0.3;
// Another reading of the rig counts as the better one when it explains so much.
constexpr double kConvincingShare = 0.8;

/// The hull, one voxel thicker all around: the carve asks for voxels' centres, and a finger may lie between
/// them.
class ThickHull {
 public:
  ThickHull(const Rig& rig, const MaskSet& masks, int voxels)
      : workspace_(rig.workspace), voxels_(voxels), thick_(carveReference(rig, masks, voxels).occupied) {
    for (int axis = 0; axis < 3; ++axis) thicken(axis);
  }

  /// Whether the ray from `eye` crosses the cube; and whether it meets the hull there.
  enum class Meets { kNotTheCube, kNothing, kHull };
  Meets alongRay(const Vec3& eye, const Vec3& direction) const {
    const double voxel_m = workspace_.edge_m / voxels_;
    const Vec3 low = workspace_.center - Vec3::Constant(workspace_.edge_m / 2);
    double from = 0, to = 1e9;
    for (int axis = 0; axis < 3; ++axis) {  // the slabs of the cube
      if (direction(axis) == 0) {
        const double place = eye(axis) - low(axis);
        if (place < 0 || place > workspace_.edge_m) return Meets::kNotTheCube;
        continue;
      }
      const double a = (low(axis) - eye(axis)) / direction(axis);
      const double b = a + workspace_.edge_m / direction(axis);
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    if (from >= to) return Meets::kNotTheCube;
    for (double at = from; at < to; at += voxel_m / 2)
      if (occupiedAt((eye + at * direction - low) / voxel_m)) return Meets::kHull;
    return Meets::kNothing;
  }

 private:
  bool occupiedAt(const Vec3& in_voxels) const {
    const Eigen::Vector3i voxel = in_voxels.array().floor().cast<int>();
    if (voxel.minCoeff() < 0 || voxel.maxCoeff() >= voxels_) return false;
    return thick_[std::size_t(voxel.x() + voxels_ * (voxel.y() + voxels_ * voxel.z()))] != 0;
  }

  void thicken(int axis) {
    const std::vector<std::uint8_t> before = thick_;
    const std::size_t edge = std::size_t(voxels_), step = axis == 0 ? 1 : axis == 1 ? edge : edge * edge;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (!before[i]) continue;
      const std::size_t place = i / step % edge;
      if (place > 0) thick_[i - step] = 1;
      if (place + 1 < edge) thick_[i + step] = 1;
    }
  }

  Workspace workspace_;
  int voxels_;
  std::vector<std::uint8_t> thick_;
};

void addAgreement(const Camera& camera, const Mask& mask, const ThickHull& hull,
                  SilhouetteAgreement& agreement) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < mask.pixels.size(); ++i)
    if (mask.pixels[i]) pixels.push_back(i);
  const Pose world_from_camera = camera.camera_from_world.inverse();
  const std::size_t stride = pixels.size() / kPixels + 1;
  for (std::size_t i = 0; i < pixels.size(); i += stride) {
    const std::size_t width = std::size_t(mask.width);
    const Vec2 pixel(double(pixels[i] % width), double(pixels[i] / width));
    const std::optional<Vec3> ray = rayThroughPixel(camera.lens, pixel);
    if (!ray) continue;
    ++agreement.pixels;
    const ThickHull::Meets meets =
        hull.alongRay(world_from_camera.translation(), world_from_camera.linear() * *ray);
    agreement.in_cube += meets != ThickHull::Meets::kNotTheCube;
    agreement.explained += meets == ThickHull::Meets::kHull;
  }
}

/// Of all cameras' pixels together; 0 where most of them miss the cube, as nothing is explained then.
double explainedShare(std::span<const SilhouetteAgreement> agreement) {
  SilhouetteAgreement sum;
  for (const SilhouetteAgreement& one : agreement) {
    sum.pixels += one.pixels;
    sum.in_cube += one.in_cube;
    sum.explained += one.explained;
  }
  return 2 * sum.in_cube < sum.pixels ? 0 : sum.explainedShare();
}

/// The rig seen in a mirror: the cube's world in its x, the cameras' images in `image_axis` (0: left to
/// right). That is a left-handed world whose poses were made rotations by turning an axis of the cameras as
/// well.
Rig mirrored(const Rig& rig, int image_axis) {
  Rig result = rig;
  Vec3 in_world(-1, 1, 1), in_camera = Vec3::Ones();
  in_camera(image_axis) = -1;
  const Vec3& center = rig.workspace.center;
  for (Camera& camera : result.cameras) {
    const Mat3 turned = camera.camera_from_world.linear();
    const Vec3 shift =
        turned * (center - in_world.cwiseProduct(center)) + camera.camera_from_world.translation();
    camera.camera_from_world.linear() = in_camera.asDiagonal() * turned * in_world.asDiagonal();
    camera.camera_from_world.translation() = in_camera.cwiseProduct(shift);
  }
  return result;
}

std::vector<SilhouetteAgreement> agreementAt(int voxels, const Rig& rig, std::span<const MaskSet> instants) {
  std::vector<SilhouetteAgreement> agreement(rig.cameras.size());
  for (const MaskSet& masks : instants) {
    const ThickHull hull(rig, masks, voxels);
    for (std::size_t i = 0; i < rig.cameras.size(); ++i)
      addAgreement(rig.cameras[i], masks[i], hull, agreement[i]);
  }
  return agreement;
}

struct Explanation {
  double share = 0;
  std::string camera;  ///< without which it is so; empty: as `what` says
  std::string what;
};

/// Tries what rigs are mistaken for; keeps what explains most.
class Explanations {
 public:
  Explanations(const Rig& rig, std::span<const MaskSet> instants)
      : rig_(rig), instants_(instants.begin(), instants.begin() + std::min<long>(2, std::ssize(instants))) {}

  Explanation best() {
    for (const PoseReading poses : kPoseReadings)
      consider(reread(rig_, poses), {0, "", "poses that are " + wordsOf(poses)});
    const std::string mirror = "a mirrored rig (a left-handed world, or images flipped ";
    consider(mirrored(rig_, 0), {0, "", mirror + "left to right)"});
    consider(mirrored(rig_, 1), {0, "", mirror + "top to bottom)"});
    for (const auto& [factor, words] : {std::pair{1e-3, "millimetres"}, std::pair{1e-2, "centimetres"},
                                        std::pair{1e3, "metres, not millimetres"}}) {
      Rig scaled = rig_;
      for (Camera& camera : scaled.cameras) camera.camera_from_world.translation() *= factor;
      consider(scaled, {0, "", std::string("translations in ") + words});
    }
    if (rig_.cameras.size() <= 8) considerExchanges();  // 28 pairs
    considerLeavingOneOut();
    return best_;
  }

 private:
  void consider(const Rig& rig, const Explanation& explanation) { consider(rig, instants_, explanation); }

  void consider(const Rig& rig, std::span<const MaskSet> instants, Explanation explanation) {
    reportProgress(0.5);
    if (explainedShare(agreementAt(kFewVoxels, rig, instants)) < kConvincingShare) return;
    explanation.share = explainedShare(agreementAt(kVoxels, rig, instants));
    if (explanation.share > best_.share) best_ = explanation;
  }

  void considerExchanges() {
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Rig exchanged = rig_;
        Camera &a = exchanged.cameras[i], &b = exchanged.cameras[j];
        if (a.width != b.width || a.height != b.height) continue;
        std::swap(a, b);
        consider(exchanged, {0, "", "cameras \"" + a.name + "\" and \"" + b.name + "\" exchanged"});
      }
  }

  /// With three cameras, two are left: these agree too easily.
  void considerLeavingOneOut() {
    for (std::size_t i = 0; rig_.cameras.size() >= 4 && i < rig_.cameras.size(); ++i) {
      Rig rest = rig_;
      rest.cameras.erase(rest.cameras.begin() + static_cast<long>(i));
      std::vector<MaskSet> instants = instants_;
      for (MaskSet& masks : instants) masks.erase(masks.begin() + static_cast<long>(i));
      consider(rest, instants, {0, rig_.cameras[i].name, ""});
    }
  }

  const Rig& rig_;
  const std::vector<MaskSet> instants_;
  Explanation best_;
};

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100 * share))) + " %";
}

}  // namespace

std::vector<SilhouetteAgreement> silhouetteAgreement(const Rig& rig, std::span<const MaskSet> instants) {
  return agreementAt(kVoxels, rig, instants);
}

std::vector<RigDiagnostic> silhouetteDiagnostics(const Rig& rig, std::span<const MaskSet> instants,
                                                 std::span<const SilhouetteAgreement> agreement,
                                                 SilhouetteSource trust) {
  double pixels = 0, in_cube = 0;
  for (std::size_t i = 0; i < agreement.size(); ++i) {
    pixels += double(agreement[i].pixels);
    in_cube += double(agreement[i].in_cube);
  }
  if (pixels == 0) return {};
  const double share = explainedShare(agreement);
  if (share >= kGoodShare) return {};
  const Explanation other = Explanations(rig, instants).best();
  const bool is_explained = other.share >= kConvincingShare && other.share > share + 0.1;
  const std::string said = "the hull explains " + percent(share) + " of the silhouettes";
  RigDiagnostic finding;
  if (is_explained && other.camera.empty()) {
    finding.what = said + ", and " + percent(other.share) + " with " + other.what + ": that would be right";
  } else if (is_explained) {
    finding = {Severity::kWarning, other.camera,
               said + ", and " + percent(other.share) +
                   " without it: was it moved after the calibration, or is its recording out of step?"};
  } else {
    const bool may_be_meant = share >= kContradiction || trust == SilhouetteSource::kAssumed;
    finding.severity = may_be_meant ? Severity::kWarning : Severity::kFault;
    finding.what =
        in_cube < 0.5 * pixels
            ? "only " + percent(in_cube / pixels) +
                  " of the silhouettes' pixels look into the cube; a [workspace] around what moves "
                  "there, and the units of the translations, would be right"
            : said +
                  ": cameras and recordings contradict each other; the calibration of this recording, "
                  "cameras in step, and clean silhouettes would be right";
    if (trust == SilhouetteSource::kAssumed) finding.what += " (and first frames that show nobody)";
  }
  return {finding};
}

}  // namespace airclay
