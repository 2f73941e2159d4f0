// SPDX-License-Identifier: MIT
#include "capture/takes/room_recording.h"

#include <gtest/gtest.h>

#include <set>

#include "capture/takes/room_set.h"
#include "capture/takes/take.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// Three unsynchronised cameras of 160 x 120 pixels.
RoomOptions smallOptions() {
  RoomOptions options;
  options.rig = roomRig(3);
  for (Camera& camera : options.rig.cameras) {
    camera.width /= 4;
    camera.height /= 4;
    camera.lens.fx /= 4;
    camera.lens.fy /= 4;
    camera.lens.cx = (camera.lens.cx + 0.5) / 4 - 0.5;
    camera.lens.cy = (camera.lens.cy + 0.5) / 4 - 0.5;
  }
  options.clock_spread_s = 0.03;
  options.hand_frames = 40;
  return options;
}

std::vector<std::vector<std::uint8_t>> imagesOf(Recording& recording, int frame) {
  std::vector<std::vector<std::uint8_t>> images;
  std::vector<std::span<std::uint8_t>> buffers;
  for (const Camera& camera : recording.rig().cameras)
    images.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
  for (std::vector<std::uint8_t>& image : images) buffers.emplace_back(image);
  EXPECT_TRUE(recording.readImages(frame, buffers));
  return images;
}

TEST(RoomRecording, TruthIsTheHandsPoseAtTheMeanTime) {
  RoomOptions options = smallOptions();
  options.hand_frames = 90;
  const HandModel hand = builtInHand(false);
  const RoomRecording recording(hand, options);
  const Room room(hand, options);
  const Truth truth = recording.fullTruth();
  ASSERT_GT(truth.frames.size(), 50u);
  EXPECT_LE(truth.frames.size(), 90u);
  ASSERT_EQ(recording.truth()->size(), truth.frames.size());
  for (int frame = 0; frame < recording.frameCount(); ++frame) {
    const std::vector<double> times = recording.cameraTimesOf(frame);
    const double mean_s = (times[0] + times[1] + times[2]) / 3;
    EXPECT_NEAR(recording.timeOf(frame), mean_s, 1e-12);
    const std::optional<Pose> pose = truth.at(mean_s, 1 / 30.0);
    ASSERT_EQ(pose.has_value(), frame >= 10 && room.isHandInCube(mean_s)) << frame;
    if (!pose) continue;
    // between the dense poses
    EXPECT_LT((pose->translation() - room.handAt(mean_s)->translation()).norm(), 5e-5);
    EXPECT_LT(angleBetween(pose->linear(), room.handAt(mean_s)->linear()), 1e-3);
  }
}

TEST(RoomRecording, WrittenTakeEqualsTheRecording) {
  RoomOptions options = smallOptions();
  options.hand_frames = 25;
  RoomRecording recording(builtInHand(false), options);
  const TemporaryFolder folder;
  int written = 0;
  writeTake(recording, folder / "room", [&] { ++written; });
  EXPECT_EQ(written, 35);
  Take take(folder / "room");
  ASSERT_EQ(take.frameCount(), 35);
  const Truth truth = readTruth(folder / "room");
  EXPECT_EQ(truth.frames.size(), recording.truth()->size());
  EXPECT_GT(truth.dense.size(), 100u);
  for (const int frame : {0, 20, 34}) {
    EXPECT_EQ(imagesOf(take, frame), imagesOf(recording, frame)) << frame;
    EXPECT_NEAR(take.timeOf(frame), recording.timeOf(frame), 1e-5);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(take.cameraTimesOf(frame)[c], recording.cameraTimesOf(frame)[c], 1e-5);
  }
}

TEST(RoomSet, TakesHaveTheirOwnNamesAndPaths) {
  std::set<std::string> names;
  std::set<std::uint32_t> seeds;
  std::set<std::size_t> cameras;
  for (const RoomTake& take : standardRooms()) {
    EXPECT_TRUE(names.insert(take.name).second) << take.name;
    EXPECT_TRUE(seeds.insert(take.options.seed).second) << take.name;
    cameras.insert(take.options.rig.cameras.size());
    EXPECT_NO_THROW(checkRig(take.options.rig, take.name));
  }
  EXPECT_GE(names.size(), 16u);
  EXPECT_EQ(cameras, (std::set<std::size_t>{2, 4, 8}));
}

}  // namespace
}  // namespace airclay
