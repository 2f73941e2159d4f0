// SPDX-License-Identifier: MIT
// The robust fit and its search on masks of rendered hands, as images of white on black.
#include <iostream>
#include <random>

#include "engine/hand/robust_tracker.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/hand_scene.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

constexpr OutlineStage kCatch[] = {{2, false, 40, 20}, {2, false, 20, 8}, {2, false, 10, 4}, {3, true, 0, 0}};

/// Masks as images, and what fits a hand to them.
struct OutlineFit {
  explicit OutlineFit(const GpuRig& r)
      : rig(r),
        fitter(testGpu(), r, outlineModel(builtInHand(false))),
        frame(fitter.frame()),
        masks_(testGpu(), r.maskWords(), Memory::kHost),
        mask_images_(testGpu(), r),
        evidence_(testGpu(), r),
        recorder_(testGpu()) {}

  const GpuOutlineFit& fit(const std::vector<Silhouette>& masks, const GpuOutlinePose& start,
                           const ScalePrior& scale = {}) {
    rig.pack(masks, masks_.host());
    std::vector<GpuTileRegion> regions;
    for (std::size_t c = 0; c < masks.size(); ++c) regions.push_back(evidence_.wholeImage(c));
    recorder_.begin();
    mask_images_.record(recorder_, masks_);
    evidence_.recordBackground(recorder_, mask_images_.background());
    evidence_.record(recorder_, mask_images_.images(), mask_images_.background(), regions);
    fitter.record(recorder_, frame, start, kCatch, evidence_, mask_images_.images(),
                  mask_images_.background(), scale);
    recorder_.submitAndWait();
    EXPECT_TRUE(hazards(recorder_.commands()).empty());
    return fitter.result();
  }
  /// A pose some distance and angle from the true one.
  GpuOutlinePose startNear(const Pose& truth, double shift_m, double degrees) const {
    return outlinePose(
        rotationFromVector(degrees * M_PI / 180 * Vec3(0.36, 0.48, -0.8)) * truth.linear(),
        truth * fitter.model().center_of_mass - rig.rig().workspace.center + shift_m * Vec3(-0.64, 0.6, 0.48),
        1);
  }
  PoseError error(const GpuOutlinePose& found, const Pose& truth) const {
    const Vec3 position = rig.rig().workspace.center + found.position.cast<double>();
    return {(position - truth * fitter.model().center_of_mass).norm(),
            angleBetween(rotationOf(found), truth.linear()) * 180 / M_PI};
  }

  const GpuRig& rig;
  OutlineFitter fitter;
  GpuOutlineFrame frame;

 private:
  Buffer<std::uint32_t> masks_;
  MaskImages mask_images_;
  Evidence evidence_;
  Recorder recorder_;
};

void expectFitted(const PoseError& error) {
  EXPECT_LT(error.shift_m, 0.0007);
  EXPECT_LT(error.turn_degrees, 0.5);
}

TEST(Outline, ConvergesFromAnInaccurateStart) {
  HandCameras cameras;
  OutlineFit outline(cameras.rig());
  for (const double time_s : {1.5, 2.1, 3.4}) {
    SCOPED_TRACE(time_s);
    const Pose truth = *demoScript().at(time_s);
    const GpuOutlinePose start = outline.startNear(truth, 0.010, 8);
    ASSERT_NEAR(outline.error(start, truth).shift_m, 0.010, 1e-6);
    const GpuOutlineFit& found = outline.fit(cameras.masks(truth), start);
    expectFitted(outline.error(found.pose, truth));
    EXPECT_TRUE(judgeReference(found, cameras.rig().cameraCount()));
    EXPECT_EQ(found.pose.scale, 1);  // fixed
  }
}

TEST(Outline, EstimatesTheHandsSize) {
  constexpr double kScale = 1.07;
  std::vector<TriangleMesh> meshes = demoArm();
  const Vec3 center = outlineModel(builtInHand(false)).center_of_mass;
  for (TriangleMesh& mesh : meshes)
    for (Vec3& vertex : mesh.vertices) vertex = center + kScale * (vertex - center);
  HandCameras cameras(demoRig(), meshes);
  OutlineFit outline(cameras.rig());
  const Pose truth = *demoScript().at(3.4);
  constexpr double kDeviation = 0.05;
  const GpuOutlinePose start = outline.startNear(truth, 0.005, 4);
  const std::vector<Silhouette> masks = cameras.masks(truth);
  GpuOutlineFit found = outline.fit(masks, start, {0, 1 / (kDeviation * kDeviation)});
  EXPECT_NEAR(found.pose.scale, kScale, 0.01 * kScale);
  expectFitted(outline.error(found.pose, truth));
  // a strong prior keeps the model's size
  found = outline.fit(masks, start, {0, 1e12});
  EXPECT_NEAR(found.pose.scale, 1, 1e-3);
}

// Each camera sees the hand at a time of its own; the fit finds the pose at the frame's.
TEST(Outline, CamerasWithTimesOfTheirOwnAgreeOnOnePose) {
  HandCameras cameras;
  OutlineFit outline(cameras.rig());
  const Pose truth = *demoScript().at(2.1);
  const Vec3 velocity(1.2, -0.9, 0.5), spin(3, -2, 4);      // m/s, rad/s
  const double seconds[] = {-0.012, 0.009, 0.006, -0.003};  // mean 0
  const Vec3 center = truth * outline.fitter.model().center_of_mass;
  std::vector<Silhouette> masks;
  for (std::size_t c = 0; c < 4; ++c) {
    Pose seen = truth;
    seen.linear() = rotationFromVector(seconds[c] * spin) * truth.linear();
    seen.translation() =
        center + seconds[c] * velocity - seen.linear() * outline.fitter.model().center_of_mass;
    masks.push_back(cameras.masks(seen)[c]);
  }
  const GpuOutlinePose start = outline.startNear(truth, 0.004, 3);
  const PoseError ignored = outline.error(outline.fit(masks, start).pose, truth);
  EXPECT_GT(ignored.shift_m, 0.002);  // as if all were taken at once

  for (std::size_t c = 0; c < 4; ++c) outline.frame.seconds[c] = float(seconds[c]);
  outline.frame.velocity = velocity.cast<float>();
  outline.frame.spin = spin.cast<float>();
  expectFitted(outline.error(outline.fit(masks, start).pose, truth));
}

TEST(Outline, IgnoresACameraWithoutAnImage) {
  HandCameras cameras;
  OutlineFit outline(cameras.rig());
  const Pose truth = *demoScript().at(3.4);
  std::vector<Silhouette> masks = cameras.masks(truth);
  masks[1] = cameras.masks(*demoScript().at(1.5))[1];  // of another time
  outline.frame.cameras &= ~2u;
  const GpuOutlineFit& found = outline.fit(masks, outline.startNear(truth, 0.005, 4));
  EXPECT_EQ(found.camera_length[1], 0);
  EXPECT_GT(found.camera_length[0], 100);
  const PoseError error = outline.error(found.pose, truth);
  EXPECT_LT(error.shift_m, 0.001);
  EXPECT_LT(error.turn_degrees, 1);
}

/// The tracker from masks, as in the pipeline.
struct MaskTracking {
  explicit MaskTracking(const GpuRig& r)
      : rig(r),
        tracker(testGpu(), r, builtInHand(false)),
        masks(testGpu(), r.maskWords(), Memory::kHost),
        mask_images(testGpu(), r),
        recorder(testGpu()) {
    recorder.begin();
    tracker.recordBackground(recorder, mask_images.background(), {});
    recorder.submitAndWait();
  }
  RobustTracker::Frame frame() const { return {mask_images.images(), mask_images.background()}; }
  /// One frame without a last pose; empty if nothing could be a hand.
  std::optional<HandFit> find(const std::vector<Silhouette>& silhouettes) {
    rig.pack(silhouettes, masks.host());
    tracker.beginSearch();
    recorder.begin();
    mask_images.record(recorder, masks);
    tracker.recordWholeEvidence(recorder, frame());
    recorder.submitAndWait();
    if (!tracker.search(recorder, frame(), stage_ms)) return std::nullopt;
    recorder.begin();
    tracker.recordEvidence(recorder, frame());
    tracker.recordTracking(recorder, frame());
    recorder.submitAndWait();
    return tracker.finish();
  }

  const GpuRig& rig;
  RobustTracker tracker;
  Buffer<std::uint32_t> masks;
  MaskImages mask_images;
  Recorder recorder;
  StageTimes stage_ms;
};

/// The hand with an arm that leaves the workspace in any direction, as a person's does.
std::vector<TriangleMesh> longArm() {
  TriangleMesh forearm = builtInForearm(false);
  for (Vec3& vertex : forearm.vertices) vertex.x() *= 2;  // from the wrist joint
  return {builtInHand(false).skin, forearm};
}

TEST(HandSearch, FindsTheHandInAnyOrientation) {
  HandCameras cameras(demoRig(), longArm());
  MaskTracking tracking(cameras.rig());
  const Vec3 center_of_mass = tracking.tracker.fitter().model().center_of_mass;
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-0.06, 0.06);
  constexpr int kPoses = 20, kAttempts = 3;
  int found = 0, attempts = 0;
  for (int i = 0; i < kPoses; ++i) {
    Pose truth = Pose::Identity();
    truth.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                         .normalized()
                         .toRotationMatrix();
    truth.translation() = Vec3(place(random), place(random), place(random)) - truth.linear() * center_of_mass;
    const std::vector<Silhouette> masks = cameras.masks(truth);
    tracking.tracker.forget();
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      ++attempts;
      const std::optional<HandFit> fit = tracking.find(masks);
      if (!fit || !fit->tracked || fit->uncertain) continue;
      const PoseError error = poseError(fit->pose.world_from_hand, truth, center_of_mass);
      const bool is_right = error.shift_m < 0.010 && error.turn_degrees < 10;
      EXPECT_TRUE(is_right) << "pose " << i << ": " << 1000 * error.shift_m << " mm, " << error.turn_degrees
                            << " degrees, agreement " << fit->agreement;
      found += is_right;
      break;
    }
  }
  std::cout << found << " of " << kPoses << " poses found in " << attempts << " attempts\n";
  EXPECT_GE(found, 18);
}

TEST(HandSearch, EmptyImagesContainNoHand) {
  const GpuRig rig(testGpu(), demoRig());
  MaskTracking tracking(rig);
  std::vector<Silhouette> masks;
  for (const Camera& camera : rig.rig().cameras) masks.push_back(emptySilhouette(camera));
  for (int attempt = 0; attempt < 3; ++attempt) EXPECT_FALSE(tracking.find(masks).has_value());
}

TEST(HandSearch, ABallIsNotAHand) {
  const GpuRig rig(testGpu(), demoRig());
  MaskTracking tracking(rig);
  const std::vector<Silhouette> masks = sphereMasks(rig.rig(), Vec3(0.02, -0.03, 0.01), 0.08);
  for (int attempt = 0; attempt < 3; ++attempt) {
    const std::optional<HandFit> fit = tracking.find(masks);
    EXPECT_FALSE(fit && fit->tracked && !fit->uncertain) << "agreement " << (fit ? fit->agreement : 0);
  }
}

}  // namespace
}  // namespace airclay
