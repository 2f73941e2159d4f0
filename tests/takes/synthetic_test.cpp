// SPDX-License-Identifier: MIT
#include "capture/takes/synthetic.h"

#include "engine/hand/hand_model.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

/// One buffer per camera.
struct Images {
  std::vector<std::vector<std::uint8_t>> bytes;
  std::vector<std::span<std::uint8_t>> spans;

  explicit Images(const Rig& rig) {
    for (const Camera& camera : rig.cameras)
      bytes.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
    for (std::vector<std::uint8_t>& image : bytes) spans.emplace_back(image);
  }
};

TEST(Synthetic, EveryDemoCameraSeesTheWholeWorkspace) {
  const Rig rig = demoRig();
  EXPECT_NO_THROW(checkRig(rig, "demo"));
  const double half = rig.workspace.edge_m / 2;
  for (const Camera& camera : rig.cameras)
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 p(corner & 1 ? half : -half, corner & 2 ? half : -half, corner & 4 ? half : -half);
      EXPECT_TRUE(project(camera, p)) << camera.name << " does not see corner " << p.transpose();
    }
}

TEST(Synthetic, HasTimesTruthAndBackgroundFrames) {
  const Synthetic recording(testGpu());
  EXPECT_EQ(recording.backgroundFrames(), 10);
  EXPECT_GT(recording.frameCount(), 140);
  ASSERT_TRUE(recording.truth());
  EXPECT_EQ(int(recording.truth()->size()), recording.frameCount() - recording.backgroundFrames());
  EXPECT_DOUBLE_EQ(recording.timeOf(30), 1);
  EXPECT_DOUBLE_EQ(recording.truth()->front().time_s, recording.timeOf(10));
}

TEST(Synthetic, FramesDoNotDependOnReadOrder) {
  Synthetic recording(testGpu());
  Images first(recording.rig()), again(recording.rig());
  ASSERT_TRUE(recording.readImages(40, first.spans));
  ASSERT_TRUE(recording.readImages(3, again.spans));
  EXPECT_NE(first.bytes, again.bytes);
  ASSERT_TRUE(recording.readImages(40, again.spans));
  EXPECT_EQ(first.bytes, again.bytes);
  EXPECT_FALSE(recording.readImages(recording.frameCount(), again.spans));
}

TEST(Synthetic, HandAppearsAtTheTruePose) {
  SyntheticOptions options;
  options.meshes = {builtInHand(false).skin};  // without the forearm, whose end has no truth
  options.noise_sigma = options.drift = 0;     // then only the hand increases red; shadow decreases it
  Synthetic recording(testGpu(), options);
  Images empty(recording.rig()), other(recording.rig()), full(recording.rig());
  recording.readImages(0, empty.spans);
  recording.readImages(9, other.spans);
  const int frame = 45;
  recording.readImages(frame, full.spans);
  const Pose world_from_hand =
      recording.truth()->at(std::size_t(frame - recording.backgroundFrames())).world_from_hand;
  for (std::size_t c = 0; c < recording.rig().cameras.size(); ++c) {
    const Camera& camera = recording.rig().cameras[c];
    SCOPED_TRACE(camera.name);
    Eigen::AlignedBox2d seen, expected;
    for (std::size_t i = 0; i < empty.bytes[c].size() / 3; ++i) {
      const std::size_t w = std::size_t(camera.width);
      if (full.bytes[c][3 * i + 2] > empty.bytes[c][3 * i + 2] + 4)
        seen.extend(Vec2(double(i % w), double(i / w)));
    }
    EXPECT_EQ(other.bytes[c], empty.bytes[c]);
    for (const Vec3& vertex : options.meshes[0].vertices)
      expected.extend(*project(camera, world_from_hand * vertex));
    EXPECT_LT((seen.min() - expected.min()).cwiseAbs().maxCoeff(), 1);
    EXPECT_LT((seen.max() - expected.max()).cwiseAbs().maxCoeff(), 1);
  }
}

}  // namespace
}  // namespace airclay
