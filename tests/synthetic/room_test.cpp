// SPDX-License-Identifier: MIT
#include "engine/synthetic/room.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "engine/core/error.h"
#include "engine/synthetic/texture.h"
#include "tests/support/coverage.h"

namespace airclay {
namespace {

using Bytes = std::vector<std::uint8_t>;

const HandModel& rightHand() {
  static const HandModel hand = builtInHand(false);
  return hand;
}

/// The room's cameras with images of 320 x 240 pixels.
Rig smallRig(int count, const Pose& world_from_room = Pose::Identity()) {
  Rig rig = roomRig(count, world_from_room);
  for (Camera& camera : rig.cameras) {
    camera.width /= 2;
    camera.height /= 2;
    for (double* length : {&camera.lens.fx, &camera.lens.fy}) *length /= 2;
    for (double* center : {&camera.lens.cx, &camera.lens.cy}) *center = (*center + 0.5) / 2 - 0.5;
  }
  return rig;
}

Pose turnedWorld() {
  Pose pose = Pose::Identity();
  pose.linear() = rotationFromVector(Vec3(0.9, -1.4, 0.6));
  pose.translation() = Vec3(0.3, -0.2, 0.5);
  return pose;
}

/// Only what the pose decides: no noise, no drift, no shadows, no blur.
RoomOptions plainOptions(int cameras = 2) {
  RoomOptions options;
  options.rig = smallRig(cameras);
  options.has_shadows = false;
  options.exposure_s = 0;
  options.noise_dark = options.noise_bright = 0;
  options.exposure_drift = options.white_balance_drift = 0;
  return options;
}

Bytes imageOf(Room& room, const RoomOptions& options, std::size_t camera, int frame) {
  Bytes bgr(std::size_t(3) * std::size_t(options.rig.cameras[camera].width) *
            std::size_t(options.rig.cameras[camera].height));
  room.render(camera, frame, bgr);
  return bgr;
}

std::vector<double> coverageOf(const Room& room, std::size_t camera) {
  const std::vector<float> coverage = room.handCoverage(camera);
  return {coverage.begin(), coverage.end()};
}

TriangleMesh scaledSkin(double scale) {
  TriangleMesh skin = withCaps(rightHand().skin);
  for (Vec3& vertex : skin.vertices) vertex *= scale;
  return skin;
}

TEST(Room, HandIsAtItsProjection) {
  RoomOptions options = plainOptions();
  options.arm = Arm::kNone;
  options.world_from_room = turnedWorld();
  options.rig = smallRig(2, options.world_from_room);
  for (const double scale : {1.0, 1.07}) {
    options.hand_scale = scale;
    Room room(rightHand(), options);
    const int frame = 40;
    for (std::size_t c = 0; c < 2; ++c) {
      SCOPED_TRACE(c);
      imageOf(room, options, c, frame);
      const Camera& camera = options.rig.cameras[c];
      const std::vector<double> seen = coverageOf(room, c);
      const std::vector<double> expected =
          projectedCoverage(camera, scaledSkin(scale), *room.handAt(room.cameraTimesOf(frame)[c]));
      const Shape shape = shapeOf(seen, camera.width), target = shapeOf(expected, camera.width);
      EXPECT_GT(target.area, 350);
      EXPECT_NEAR(shape.area / target.area, 1, 0.004);
      EXPECT_LT((shape.center - target.center).norm(), 0.02);
      double different = 0, edge = 0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        different += std::abs(seen[i] - expected[i]);
        edge += expected[i] > 0 && expected[i] < 1;
      }
      EXPECT_LT(different / edge, 0.08);  // 16 samples resolve an edge pixel's coverage to about a sixteenth
    }
  }
}

TEST(Room, EqualOptionsGiveEqualBytesInAnyOrder) {
  RoomOptions options;
  options.rig = smallRig(2);
  Room first(rightHand(), options), second(rightHand(), options);
  const Bytes a = imageOf(first, options, 1, 30);
  imageOf(second, options, 1, 55);
  imageOf(second, options, 0, 30);
  EXPECT_EQ(imageOf(second, options, 1, 30), a);
  EXPECT_NE(imageOf(second, options, 1, 31), a);
  options.seed = 2;
  Room other(rightHand(), options);
  EXPECT_NE(imageOf(other, options, 1, 30), a);
}

TEST(Room, ShadowsDarkenTheDeskAndKeepItsColour) {
  RoomOptions options = plainOptions();
  Room bright(rightHand(), options);
  options.has_shadows = true;
  Room dark(rightHand(), options);
  double darkest = 1, tinted = 0;
  int in_shadow = 0;
  for (std::size_t c = 0; c < 2; ++c) {
    const Bytes empty = imageOf(bright, options, c, 0);
    const Bytes before = imageOf(bright, options, c, 45), after = imageOf(dark, options, c, 45);
    // blocks of 16 pixels in a row, because single bytes are too coarse
    for (std::size_t first = 0; first + 48 <= before.size(); first += 48) {
      const auto block = static_cast<std::ptrdiff_t>(first);
      if (!std::equal(before.begin() + block, before.begin() + block + 48, empty.begin() + block))
        continue;  // the person
      double sum_before[3] = {}, sum_after[3] = {};
      for (std::size_t i = first; i < first + 48; ++i) {
        sum_before[i % 3] += before[i];
        sum_after[i % 3] += after[i];
      }
      if (std::min({sum_before[0], sum_before[1], sum_before[2]}) < 16 * 30) continue;
      const double ratio = sum_after[1] / sum_before[1];
      EXPECT_LE(ratio, 1.002);
      darkest = std::min(darkest, ratio);
      in_shadow += ratio < 0.95;
      for (int k = 0; k < 3; ++k)
        tinted = std::max(tinted, std::abs(sum_after[k] / sum_before[k] / ratio - 1));
    }
  }
  EXPECT_LT(darkest, 0.75);
  EXPECT_GT(darkest, 0.3);
  EXPECT_GT(in_shadow, 200);
  EXPECT_LT(tinted, 0.02);
}

/// The sum of each channel, blue first.
Vec3 channelSums(const Bytes& bgr) {
  Vec3 sums = Vec3::Zero();
  for (std::size_t i = 0; i < bgr.size(); ++i) sums[static_cast<int>(i % 3)] += bgr[i];
  return sums;
}

TEST(Room, DriftScalesTheImage) {
  RoomOptions options = plainOptions();
  options.background_frames = 100;  // nobody is there
  Room steady(rightHand(), options);
  options.exposure_drift = 0.08;
  options.white_balance_drift = 0.03;
  Room drifting(rightHand(), options);
  double largest = 0;
  for (const int frame : {0, 20, 40, 60})
    for (std::size_t c = 0; c < 2; ++c) {
      const Vec3 gain = drifting.gainAt(c, frame / 30.0);
      const Vec3 ratio = channelSums(imageOf(drifting, options, c, frame))
                             .cwiseQuotient(channelSums(imageOf(steady, options, c, frame)));
      EXPECT_LT((ratio.reverse() - gain).cwiseAbs().maxCoeff(), 0.004);
      largest = std::max(largest, (gain - Vec3::Ones()).cwiseAbs().maxCoeff());
      if (frame == 0) {
        EXPECT_EQ(gain, Vec3::Ones());
      }
    }
  EXPECT_GT(largest, 0.06);
  EXPECT_LT(largest, 0.115);
}

TEST(Room, NoiseGrowsWithBrightness) {
  RoomOptions options = plainOptions();
  Room clean(rightHand(), options);
  options.noise_dark = 1.2;
  options.noise_bright = 3.2;
  Room noisy(rightHand(), options);
  const Bytes a = imageOf(clean, options, 0, 0), b = imageOf(noisy, options, 0, 0),
              c = imageOf(noisy, options, 0, 1);
  for (const int value : {70, 150}) {  // the walls, the desk
    double squares = 0, count = 0, between = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(a[i] - value) < 12) {
        squares += std::pow(double(b[i]) - a[i], 2);
        between += (double(b[i]) - a[i]) * (double(c[i]) - a[i]);
        ++count;
      }
    ASSERT_GT(count, 2000);
    const double expected = std::sqrt(1.2 * 1.2 + (3.2 * 3.2 - 1.2 * 1.2) * value / 255.0 + 2.0 / 12);
    EXPECT_NEAR(std::sqrt(squares / count) / expected, 1, 0.05) << value;
    EXPECT_LT(std::abs(between / squares), 0.1) << "two frames have different noise";
  }
}

TEST(Room, WindowsLightFallsSuddenlyOrSlowly) {
  RoomOptions options = plainOptions();
  options.background_frames = 100;
  options.hand_frames = 90;  // the light changes in the middle of them, at 145 / 30 s
  for (const Daylight daylight : {Daylight::kSudden, Daylight::kSlow}) {
    options.daylight = daylight;
    Room room(rightHand(), options);
    const double middle_s = 145 / 30.0;
    EXPECT_NEAR(room.daylightAt(0), 1, 1e-6);
    EXPECT_NEAR(room.daylightAt(middle_s + 3), daylight == Daylight::kSudden ? 0.6 : 1, 1e-3);
    EXPECT_NEAR(room.daylightAt(middle_s), daylight == Daylight::kSudden ? 0.8 : 0.6, 1e-6);
    double fastest = 0;
    for (double t = 0; t < 8; t += 0.01)
      fastest = std::max(fastest, std::abs(room.daylightAt(t + 0.01) - room.daylightAt(t)) / 0.01);
    EXPECT_NEAR(fastest, daylight == Daylight::kSudden ? 4 : 0.43, 0.1) << "per second";
  }
  options.background_frames = 10;
  options.hand_frames = 0;
  options.daylight = Daylight::kSudden;  // at frame 10
  Room room(rightHand(), options);
  const double before = channelSums(imageOf(room, options, 0, 5)).sum();
  options.background_frames = 5;
  Room darker(rightHand(), options);
  EXPECT_LT(channelSums(imageOf(darker, options, 0, 9)).sum(), 0.96 * before);
}

TEST(Room, CamerasSeeTheHandAtTheirOwnTimes) {
  RoomOptions options = plainOptions(3);
  options.arm = Arm::kNone;
  options.clock_spread_s = 0.033;
  options.peak_speed_m_s = 0.8;
  Room room(rightHand(), options);
  const std::vector<double> times = room.cameraTimesOf(30);
  ASSERT_EQ(times.size(), 3u);
  const auto [low, high] = std::minmax_element(times.begin(), times.end());
  EXPECT_NEAR(*high - *low, 0.033, 1e-9);
  const double mean_s = std::accumulate(times.begin(), times.end(), 0.0) / 3;
  double farthest = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(room.cameraTimesOf(31)[c] - times[c], 1 / 30.0, 1e-9);
    // the fastest frame
    int frame = 15;
    const auto shift = [&](int k) {
      return (room.handAt(k / 30.0 + 0.01)->translation() - room.handAt(k / 30.0)->translation()).norm();
    };
    for (int k = 15; k < 90; ++k)
      if (shift(k) > shift(frame) && room.isHandInCube(k / 30.0)) frame = k;
    imageOf(room, options, c, frame);
    const Camera& camera = options.rig.cameras[c];
    const Shape seen = shapeOf(coverageOf(room, c), camera.width);
    const auto distance = [&](double time_s) {
      return (seen.center -
              shapeOf(projectedCoverage(camera, scaledSkin(1), *room.handAt(time_s)), camera.width).center)
          .norm();
    };
    EXPECT_LT(distance(room.cameraTimesOf(frame)[c]), 0.03);
    farthest = std::max(farthest, distance(mean_s + (frame - 30) / 30.0));
  }
  EXPECT_GT(farthest, 0.5);
}

TEST(Room, MotionBlurIsCenteredAtTheFramesTime) {
  RoomOptions options = plainOptions();
  options.arm = Arm::kNone;
  Room sharp(rightHand(), options);
  options.exposure_s = 1.0 / 30;
  Room blurred(rightHand(), options);
  const int frame = 14;  // on its way in
  const int width = options.rig.cameras[0].width;
  const auto partial = [](const std::vector<double>& coverage) {
    return std::ranges::count_if(coverage, [](double value) { return value > 0 && value < 1; });
  };
  imageOf(sharp, options, 0, frame);
  imageOf(blurred, options, 0, frame);
  const std::vector<double> a = coverageOf(sharp, 0), b = coverageOf(blurred, 0);
  EXPECT_GT(partial(b), 1.5 * static_cast<double>(partial(a)));
  EXPECT_NEAR(shapeOf(b, width).area / shapeOf(a, width).area, 1, 0.03);
  EXPECT_LT((shapeOf(b, width).center - shapeOf(a, width).center).norm(), 0.4);
}

TEST(Room, BackgroundFramesShowNobodyOrAPersonWithTheHandOutsideTheCube) {
  RoomOptions options = plainOptions();
  Room nobody(rightHand(), options);
  options.background = BackgroundFrames::kSeated;
  Room seated(rightHand(), options);
  for (int frame = 0; frame < 10; ++frame) {
    EXPECT_FALSE(nobody.handAt(frame / 30.0));
    EXPECT_TRUE(seated.handAt(frame / 30.0));
    EXPECT_FALSE(seated.isHandInCube(frame / 30.0));
  }
  EXPECT_TRUE(nobody.handAt(10 / 30.0));
  EXPECT_TRUE(seated.isHandInCube(1.6));
  EXPECT_NE(imageOf(nobody, options, 0, 3), imageOf(seated, options, 0, 3));
  EXPECT_EQ(imageOf(nobody, options, 0, 3), imageOf(nobody, options, 0, 4));
}

TEST(Room, SkinIsTexturedAndEveryToneDiffers) {
  Vec3 previous = Vec3::Zero();
  for (const Vec3& tone : {kLightSkin, kMediumSkin, kDarkSkin}) {
    RoomOptions options = plainOptions();
    options.skin = tone;
    Room room(rightHand(), options);
    const Bytes image = imageOf(room, options, 0, 45);
    const std::vector<double> coverage = coverageOf(room, 0);
    Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
    double count = 0;
    for (std::size_t i = 0; i < coverage.size(); ++i)
      if (coverage[i] == 1) {
        const Vec3 bgr(image[3 * i], image[3 * i + 1], image[3 * i + 2]);
        sum += bgr;
        squares += bgr.cwiseAbs2();
        ++count;
      }
    ASSERT_GT(count, 400);
    const Vec3 mean = sum / count, deviation = (squares / count - mean.cwiseAbs2()).cwiseSqrt();
    EXPECT_GT(deviation.minCoeff(), 4) << "shading and texture";
    EXPECT_GT(mean.z(), mean.x()) << "red is above blue";
    EXPECT_GT((mean - previous).norm(), 30);
    previous = mean;
  }
}

TEST(Room, ArmAndPersonAreVisibleOnlyIfTheyArePresent) {
  const auto differs = [](const RoomOptions& options, const RoomOptions& other) {
    Room a(rightHand(), options), b(rightHand(), other);
    const Bytes x = imageOf(a, options, 1, 45), y = imageOf(b, other, 1, 45);
    int count = 0;
    for (std::size_t i = 0; i < x.size(); i += 3) count += std::abs(x[i] - y[i]) > 6;
    return count;
  };
  RoomOptions sleeve = plainOptions(), bare = sleeve, none = sleeve, alone = sleeve, two = sleeve;
  bare.arm = Arm::kBare;
  none.arm = Arm::kNone;
  alone.has_person = false;
  two.has_second_person = true;
  EXPECT_GT(differs(sleeve, bare), 200);
  EXPECT_GT(differs(alone, none), 400);
  EXPECT_GT(differs(sleeve, alone), 3000);
  EXPECT_GT(differs(sleeve, two), 500);
}

TEST(Room, RigHasTwoToEightCamerasThatSeeTheCube) {
  for (int count = 2; count <= 8; ++count) {
    const Rig rig = roomRig(count, turnedWorld());
    ASSERT_EQ(rig.cameras.size(), static_cast<std::size_t>(count));
    EXPECT_NO_THROW(checkRig(rig, "room"));
    for (const Camera& camera : rig.cameras)
      for (int k = 0; k < 6; ++k) {
        const Vec3 on_sphere = 0.25 * (k & 1 ? -1 : 1) * Vec3::Unit(k / 2);
        EXPECT_TRUE(project(camera, rig.workspace.center + on_sphere)) << camera.name << " " << k;
      }
  }
  EXPECT_THROW(roomRig(1), Error);
  EXPECT_THROW(roomRig(9), Error);
}

}  // namespace
}  // namespace airclay
