// SPDX-License-Identifier: MIT
// The complete pipeline, from the pixels of synthetic cameras to an OBJ.
#include "engine/pipeline.h"

#include <algorithm>
#include <iostream>
#include <random>

#include "capture/takes/synthetic.h"
#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/mesh/distance_grid.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/hand_scene.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

ClayState tube() {
  ClayState options;
  options.cage = presetCage("tube");
  return options;
}

/// Runs a recording through a pipeline, frame by frame.
struct Session {
  Synthetic recording;
  HandModel hand;
  bool monochrome;
  Pipeline pipeline;
  std::vector<std::span<std::uint8_t>> images;

  explicit Session(HandModel model = builtInHand(false), bool grey = false)
      : recording(testGpu()),
        hand(std::move(model)),
        monochrome(grey),
        pipeline(testGpu(), recording.rig(), hand, {.time_every = 1}, tube()) {
    for (std::size_t c = 0; c < recording.rig().cameras.size(); ++c) images.push_back(pipeline.image(c));
    for (int frame = 0; frame < recording.backgroundFrames(); ++frame) {
      read(frame);
      pipeline.learnBackground();
    }
  }

  void read(int frame) {
    recording.readImages(frame, images);
    if (!monochrome) return;
    for (const std::span<std::uint8_t> bgr : images)
      for (std::size_t i = 0; i < bgr.size(); i += 3)
        bgr[i] = bgr[i + 1] = bgr[i + 2] =
            static_cast<std::uint8_t>(0.114 * bgr[i] + 0.587 * bgr[i + 1] + 0.299 * bgr[i + 2] + 0.5);
  }

  FrameResult process(int frame, bool held = true) {
    read(frame);
    return pipeline.processImages({.held = held});
  }
  Pose truth(int frame) const {
    return recording.truth()->at(std::size_t(frame - recording.backgroundFrames())).world_from_hand;
  }
  std::vector<Vec3> surface() const { return pipeline.clay().surface().points; }
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Depth of the deepest point inside the hand, metres.
double deepest(const DistanceGrid& hand, const Pose& world_from_hand, const std::vector<Vec3>& points) {
  double depth = 0;
  for (const Vec3& point : points) depth = std::max(depth, -sample(hand, world_from_hand.inverse() * point));
  return depth;
}

TEST(Pipeline, SculptsTheTubeFromPixelsToAnObj) {
  Session session;
  const DistanceGrid hand = signedDistanceGrid(session.hand.skin, 0.002, 0.01);
  const std::vector<Vec3> before = session.surface();
  std::vector<double> shifts_m, turns_degrees;
  double left_inside = 0, would_be_inside = 0;
  for (int frame = session.recording.backgroundFrames(); frame < session.recording.frameCount(); ++frame) {
    const FrameResult result = session.process(frame);
    SCOPED_TRACE("frame " + std::to_string(frame));
    ASSERT_EQ(result.state(), HandState::kTracked);
    EXPECT_EQ(result.searched, frame == session.recording.backgroundFrames());
    const Pose& found = result.trackedHand()->pose.world_from_hand;
    const PoseError error = poseError(found, session.truth(frame), Vec3::Zero());
    shifts_m.push_back(error.shift_m);
    turns_degrees.push_back(error.turn_degrees);
    const double depth = deepest(hand, found, session.surface());
    EXPECT_LE(depth, std::max(0.001, result.clay.penetration_m) + 0.0005);
    left_inside = std::max(left_inside, depth);
    would_be_inside = std::max(would_be_inside, deepest(hand, session.truth(frame), before));
  }
  std::cout << "pose error " << 1000 * median(shifts_m) << " mm, " << median(turns_degrees)
            << " degrees, worst " << 1000 * *std::max_element(shifts_m.begin(), shifts_m.end()) << " mm, "
            << *std::max_element(turns_degrees.begin(), turns_degrees.end()) << " degrees\n"
            << "clay in the hand: " << 1000 * left_inside << " mm deep at most, of " << 1000 * would_be_inside
            << " mm had it not given way\n";
  EXPECT_LE(median(shifts_m), 0.002);
  EXPECT_LE(median(turns_degrees), 1);

  // the hand pressed the side in from +x, then the rim down from above; the back stays untouched
  const PolygonMesh surface = session.pipeline.clay().surface(), cage = session.pipeline.clay().cage();
  double side = 0, rim = 0, back = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3 moved = surface.points[i] - before[i];
    if (before[i].x() > 0.04 && std::abs(before[i].z()) < 0.07) side = std::max(side, -moved.x());
    if (before[i].z() > 0.08) rim = std::max(rim, -moved.z());
    if (before[i].x() < -0.05 && before[i].z() < 0) back = std::max(back, moved.norm());
  }
  std::cout << "dents: " << 1000 * side << " mm in the side, " << 1000 * rim << " mm in the rim\n";
  EXPECT_GT(side, 0.02);
  EXPECT_LT(side, 0.04);
  EXPECT_GT(rim, 0.02);
  EXPECT_LT(rim, 0.04);
  EXPECT_LT(back, 0.01);

  // (5): the files satisfy d = A p
  const TemporaryFolder folder;
  writeObj(folder / "surface.obj", surface);
  writeObj(folder / "cage.obj", cage);
  const PolygonMesh read_surface = readObj(folder / "surface.obj"), read_cage = readObj(folder / "cage.obj");
  ASSERT_EQ(read_cage.points.size(), 28u);
  ASSERT_EQ(read_surface.points.size(), 364u);
  const Subdivision subdivision = subdivide(read_cage, 2, SubdivisionRule::kCatmullClark);
  const std::vector<Vec3> expected = dataPoints(subdivision.matrix, read_cage.points);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT((read_surface.points[i] - expected[i]).norm(), 1e-6);
}

TEST(Pipeline, TwoRunsGiveTheSameBits) {
  std::vector<Vec3> surfaces[2];
  std::vector<Pose> poses[2];
  for (int run = 0; run < 2; ++run) {
    Session session;
    for (int frame = 10; frame < 70; frame += 3)
      poses[run].push_back(session.process(frame).trackedHand()->pose.world_from_hand);
    surfaces[run] = session.surface();
  }
  EXPECT_NE(surfaces[0], dataPoints(subdivide(presetCage("tube"), 2, SubdivisionRule::kCatmullClark).matrix,
                                    presetCage("tube").points));
  EXPECT_EQ(surfaces[0], surfaces[1]);
  for (std::size_t i = 0; i < poses[0].size(); ++i)
    EXPECT_EQ(poses[0][i].matrix(), poses[1][i].matrix()) << "frame " << 10 + 3 * i;
}

TEST(Pipeline, ClayStaysWithoutHandOrClutch) {
  Session session;
  constexpr int pressing = 48, pressed = 58;  // the fingers press from 1.3 s on and rest at 1.9 s
  for (int frame = 36; frame <= pressing; frame += 2) session.process(frame);
  const std::vector<Vec3> dented = session.surface();

  // no hand
  EXPECT_EQ(session.process(0).state(), HandState::kEmpty);
  EXPECT_EQ(session.surface(), dented);
  // a ball is visible, but not a hand
  EXPECT_EQ(
      session.pipeline.processSilhouettes(sphereMasks(session.recording.rig(), Vec3(0.02, 0.03, 0), 0.06))
          .state(),
      HandState::kLost);
  EXPECT_EQ(session.surface(), dented);
  // the hand returns deep inside the clay: what is inside it does not move
  const FrameResult back = session.process(pressed);
  EXPECT_EQ(back.state(), HandState::kTracked);
  EXPECT_TRUE(back.searched);
  EXPECT_EQ(session.surface(), dented);

  // with an open clutch, the hand is tracked and passes through the clay
  session.pipeline.resetTracking();
  for (int frame = 36; frame <= pressed; frame += 2) {
    EXPECT_EQ(session.process(frame, false).state(), HandState::kTracked);
    EXPECT_EQ(session.surface(), dented);
  }
}

TEST(Pipeline, TimesStagesAndTheWholeFrame) {
  Session session;
  session.pipeline.keepHull(true);
  session.process(36);
  const FrameResult result = session.process(37);
  std::vector<std::string> names;
  double sum_ms = 0;
  for (const auto& [name, ms] : result.stage_ms) {
    names.push_back(name);
    sum_ms += ms;
    EXPECT_GT(ms, 0) << name;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"silhouette", "carve", "fit", "clay"}));
  EXPECT_LT(sum_ms, result.frame_ms);
}

TEST(Pipeline, MasksReplaceSegmentation) {
  HandCameras cameras;
  const Rig rig = cameras.rig().rig();
  const HandScript script = demoScript();
  Pipeline pipeline(testGpu(), rig, builtInHand(false));
  std::vector<double> shifts_m, turns_degrees;
  for (int frame = 10; frame < 40; frame += 2) {
    const Pose truth = *script.at(frame / 30.0);
    const FrameResult result = pipeline.processSilhouettes(cameras.masks(truth));
    ASSERT_EQ(result.state(), HandState::kTracked) << "frame " << frame;
    EXPECT_EQ(result.searched, frame == 10);
    const PoseError error = poseError(result.trackedHand()->pose.world_from_hand, truth, Vec3::Zero());
    shifts_m.push_back(error.shift_m);
    turns_degrees.push_back(error.turn_degrees);
  }
  EXPECT_LE(median(shifts_m), 0.002);
  EXPECT_LE(median(turns_degrees), 1);
}

/// Flips pixels chosen at random.
void flip(std::vector<Silhouette>& masks, double fraction, std::mt19937& random) {
  std::bernoulli_distribution flips(fraction);
  for (Silhouette& mask : masks)
    for (std::uint8_t& pixel : mask.pixels)
      if (flips(random)) pixel = static_cast<std::uint8_t>(255 - pixel);
}

TEST(Pipeline, TracksMasksWithFlippedPixels) {
  HandCameras cameras;
  const HandScript script = demoScript();
  Pipeline pipeline(testGpu(), cameras.rig().rig(), builtInHand(false));
  std::mt19937 random(7);
  std::vector<double> shifts_m, turns_degrees;
  for (int frame = 10; frame < 40; frame += 2) {
    const Pose truth = *script.at(frame / 30.0);
    std::vector<Silhouette> masks = cameras.masks(truth);
    flip(masks, 0.02, random);
    const FrameResult result = pipeline.trackSilhouettes(masks);
    ASSERT_EQ(result.state(), HandState::kTracked) << "frame " << frame;
    const PoseError error = poseError(result.trackedHand()->pose.world_from_hand, truth, Vec3::Zero());
    shifts_m.push_back(error.shift_m);
    turns_degrees.push_back(error.turn_degrees);
  }
  EXPECT_LE(median(shifts_m), 0.002);
  EXPECT_LE(median(turns_degrees), 1);
}

TEST(Pipeline, FindsAHandThatReturns) {
  HandCameras cameras;
  const HandScript script = demoScript();
  Pipeline pipeline(testGpu(), cameras.rig().rig(), builtInHand(false));
  const auto stateAt = [&](int frame, bool there) {
    std::vector<Silhouette> masks = cameras.masks(*script.at(frame / 30.0));
    for (Silhouette& mask : masks)
      if (!there) std::ranges::fill(mask.pixels, std::uint8_t{0});
    const FrameResult result = pipeline.trackSilhouettes(masks);
    if (result.state() != HandState::kTracked) return result.state();
    const PoseError error =
        poseError(result.trackedHand()->pose.world_from_hand, *script.at(frame / 30.0), Vec3::Zero());
    EXPECT_LT(error.shift_m, 0.01) << "frame " << frame;
    return result.state();
  };
  for (int frame = 10; frame < 14; ++frame) EXPECT_EQ(stateAt(frame, true), HandState::kTracked);
  for (int frame = 14; frame < 20; ++frame) EXPECT_EQ(stateAt(frame, false), HandState::kEmpty);
  // within three frames
  HandState state = HandState::kEmpty;
  for (int frame = 30; frame < 33; ++frame) state = stateAt(frame, true);
  EXPECT_EQ(state, HandState::kTracked);
}

TEST(Pipeline, HullOfTheRobustFitIsComputedOnDemand) {
  HandCameras cameras;
  Pipeline pipeline(testGpu(), cameras.rig().rig(), builtInHand(false), {.voxels = 64});
  const HandScript script = demoScript();
  const auto hullAt = [&](int frame) {
    const std::vector<Silhouette> masks = cameras.masks(*script.at(frame / 30.0));
    pipeline.trackSilhouettes(masks);
    return carveReference(cameras.rig().rig(), masks, 64).occupied;
  };
  const auto expected = hullAt(10);
  pipeline.updateHull();
  EXPECT_EQ(pipeline.carver().download().occupied, expected);
  hullAt(20);
  EXPECT_EQ(pipeline.carver().download().occupied, expected);  // not of this frame
  pipeline.keepHull(true);
  const auto later = hullAt(30);
  EXPECT_NE(later, expected);
  EXPECT_EQ(pipeline.carver().download().occupied, later);
}

TEST(Pipeline, GivenHandSculptsWithoutCameras) {
  const Rig rig = ringRig(4);
  const HandModel hand = builtInHand(false);
  const DistanceGrid distances = signedDistanceGrid(hand.skin, 0.002, 0.01);
  Pipeline pipeline(testGpu(), rig, hand, {.time_every = 1}, tube());
  // the fingers come from +x and point along -x
  const auto handAt = [](double x) {
    return Pose(Eigen::Translation3d(x, 0, 0) * Eigen::AngleAxisd(M_PI, Vec3::UnitZ()));
  };
  const auto press = [&] {
    FrameResult result;
    for (double x = 0.28; x > 0.235; x -= 0.005) {
      result = pipeline.sculptWith(std::array{HandPose{handAt(x), {}}});
      EXPECT_EQ(result.state(), HandState::kTracked);
      EXPECT_EQ(result.trackedHand()->pose.world_from_hand.matrix(), handAt(x).matrix());
      ASSERT_EQ(result.stage_ms.size(), 1u);
      EXPECT_EQ(result.stage_ms[0].first, "clay");
      EXPECT_LE(deepest(distances, handAt(x), pipeline.clay().surface().points), 0.0015);
    }
    EXPECT_GT(result.clay.touched, 0);
  };
  const std::vector<Vec3> before = pipeline.clay().surface().points;
  press();
  const std::vector<Vec3> pressed = pipeline.clay().surface().points;
  EXPECT_NE(pressed, before);

  // camera frames in between: the given hand's path to its new position is unknown
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3::Zero(), 0.002);
  EXPECT_EQ(pipeline.processSilhouettes(masks).state(), HandState::kEmpty);
  pipeline.sculptWith(std::array{HandPose{handAt(0.2), {}}});
  EXPECT_EQ(pipeline.clay().surface().points, pressed);
  EXPECT_EQ(pipeline.sculptWith(std::array{HandPose{handAt(0.1), {}}}, {.held = false}).clay.touched, 0);
  EXPECT_EQ(pipeline.clay().surface().points, pressed);

  // a new copy of the same clay, and the same strokes
  pipeline.setClay(tube());
  EXPECT_EQ(pipeline.clay().surface().points, before);
  press();
  EXPECT_EQ(pipeline.clay().surface().points, pressed);
  ClayState ball;
  ball.cage = presetCage("ball");
  ball.solve = &kSolveTouched;
  pipeline.setClay(ball);
  EXPECT_EQ(pipeline.clay().cage().faces, ball.cage.faces);
  press();
  ball.cage.faces.clear();
  EXPECT_THROW(pipeline.setClay(ball), Error);
  EXPECT_EQ(pipeline.clay().controlPointCount(), int(presetCage("ball").points.size()));
  pipeline.setClay(std::nullopt);
  EXPECT_EQ(pipeline.sculptWith(std::array{HandPose{handAt(0.2), {}}}).clay.touched, 0);
}

TEST(Pipeline, TracksTheHandWithMonochromeCameras) {
  Session session(builtInHand(false), true);
  const Vec3 center = massProperties(session.hand.skin).centroid;
  std::vector<double> shifts_m;
  constexpr int kFrames = 20;
  for (int i = 0; i < kFrames; ++i) {
    const int frame = session.recording.backgroundFrames() + i;
    const FrameResult result = session.process(frame);
    if (result.state() != HandState::kTracked) continue;
    const Pose& found = result.trackedHand()->pose.world_from_hand;
    shifts_m.push_back((found * center - session.truth(frame) * center).norm());
  }
  ASSERT_GE(shifts_m.size(), std::size_t(kFrames - 2));
  EXPECT_LT(median(shifts_m), 0.002);
}

TEST(Pipeline, DoesNotTrustAPoseOfTheOtherHand) {
  Session session(builtInHand(true));
  for (int i = 0; i < 6; ++i) {
    const FrameResult result = session.process(session.recording.backgroundFrames() + i);
    EXPECT_NE(result.state(), HandState::kTracked) << i;
    EXPECT_EQ(result.clay.touched, 0) << i;
  }
}

TEST(Pipeline, RejectsInvalidInput) {
  const Rig rig = ringRig(4);
  Pipeline pipeline(testGpu(), rig, builtInHand(false));
  EXPECT_NE(messageOf([&] { pipeline.processImages(); }).find("empty"), std::string::npos);
  std::vector<Silhouette> masks = sphereMasks(rig, Vec3::Zero(), 0.05);
  masks.pop_back();
  EXPECT_NE(messageOf([&] { pipeline.processSilhouettes(masks); }).find("one mask per camera"),
            std::string::npos);
  masks = sphereMasks(rig, Vec3::Zero(), 0.05);
  masks[2].width /= 2;
  EXPECT_NE(messageOf([&] { pipeline.processSilhouettes(masks); }).find("cam2"), std::string::npos);
  // the pipeline still works
  masks = sphereMasks(rig, Vec3::Zero(), 0.002);
  EXPECT_EQ(pipeline.processSilhouettes(masks).state(), HandState::kEmpty);
  EXPECT_THROW(Pipeline(testGpu(), rig, builtInHand(false), {0}), Error);
  EXPECT_THROW(Pipeline(testGpu(), rig, builtInHand(false), {1'000'000'000}), Error);
}

}  // namespace
}  // namespace airclay
