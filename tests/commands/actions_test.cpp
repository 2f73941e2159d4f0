// SPDX-License-Identifier: MIT
#include "app/session/actions.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

const ActionsHeader kMouseHeader{.background_frames = 0, .voxels = 64, .hand = "right", .by_mouse = true};

ReplayFrame mouseFrame(double time_s) {
  ReplayFrame frame;
  frame.time_s = time_s;
  frame.step_s = 1.0 / 30;
  frame.tool = *findTool("pull");
  frame.tool.setValue(0, 12.5);
  frame.symmetry.y = true;
  return frame;
}

HandPose handAt(double x, int joints) {
  HandPose hand;
  hand.world_from_hand.translation() = Vec3(x, 0.1, -0.2 / 3);
  hand.world_from_hand.linear() = rotationFromVector(Vec3(0.1, x, 0.3));
  for (int j = 0; j < joints; ++j) hand.joint_angles.push_back(Vec3(j / 7.0, -1.0 / (j + 3), 0));
  return hand;
}

TEST(ActionsFile, HandsAreReadAsWritten) {
  TemporaryFolder folder;
  std::vector<ReplayFrame> frames;
  for (const std::vector<HandPose>& hands : {std::vector<HandPose>{},
                                             {handAt(0.1, 0)},
                                             {handAt(0.2, 25)},
                                             {handAt(0.3, 0), handAt(0.4, 0)},
                                             {handAt(0.5, 25), handAt(0.6, 3)}}) {
    frames.push_back(mouseFrame(0.1 * double(frames.size())));
    frames.back().given_hands = hands;
  }
  std::string text = linesOf(kMouseHeader);
  for (const ReplayFrame& frame : frames) text += lineOf(frame, true);
  const Actions actions = readActions(folder.write("actions.txt", text + kActionsEnd));
  EXPECT_TRUE(actions.ended);
  ASSERT_EQ(actions.steps.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    SCOPED_TRACE(i);
    const ReplayFrame& read = actions.steps[i].frame;
    EXPECT_EQ(read.time_s, frames[i].time_s);
    EXPECT_EQ(read.tool, frames[i].tool);
    EXPECT_EQ(read.symmetry, frames[i].symmetry);
    ASSERT_EQ(read.given_hands.size(), frames[i].given_hands.size());
    for (std::size_t k = 0; k < read.given_hands.size(); ++k) {
      const HandPose &hand = read.given_hands[k], &expected = frames[i].given_hands[k];
      EXPECT_EQ(hand.world_from_hand.matrix(), expected.world_from_hand.matrix());
      EXPECT_EQ(hand.joint_angles, expected.joint_angles);
    }
  }
}

TEST(ActionsFile, RemeshKeepsItsFaces) {
  TemporaryFolder folder;
  Action remesh{.kind = Action::Kind::kRemesh};
  remesh.faces = 2345;
  const auto file = folder.write("actions.txt", linesOf(kMouseHeader) + lineOf(remesh) + kActionsEnd);
  const Actions actions = readActions(file);
  ASSERT_EQ(actions.after.size(), 1u);
  EXPECT_EQ(actions.after[0].kind, Action::Kind::kRemesh);
  EXPECT_EQ(actions.after[0].faces, 2345);
  folder.write("actions.txt", linesOf(kMouseHeader) + "remesh\n");
  EXPECT_NE(messageOf([&] { readActions(file); }).find("how many faces"), std::string::npos);
}

TEST(ActionsFile, ErrorsNameFileLineAndWhatIsExpected) {
  TemporaryFolder folder;
  const auto message = [&](const std::string& hands) {
    const std::string frame = "frame 0 0.03 push - 1 1 " + hands + "\n";
    const auto file = folder.write("actions.txt", linesOf(kMouseHeader) + frame + kActionsEnd);
    return messageOf([&] { readActions(file); });
  };
  const std::string pose = "1 0 0 0 0 1 0 0 0 0 1 0";
  EXPECT_EQ(message(pose), "");
  EXPECT_EQ(message("nobody"), "");
  for (const char* wrong : {"", "1 2 3", "1 0 0 0 0 1 0 0 0 0 1 x"})
    EXPECT_NE(message(wrong).find("12 numbers"), std::string::npos) << message(wrong);
  EXPECT_NE(message(pose + " joints 26 0 0 0").find("joints"), std::string::npos);
  EXPECT_NE(message(pose + " joints 2 0 0 0").find("joint angle"), std::string::npos);
  EXPECT_NE(message(pose + " and").find("12 numbers"), std::string::npos);
  EXPECT_NE(message(pose + " and " + pose + " and " + pose).find("second hand"), std::string::npos);
  EXPECT_NE(message(pose + " more").find("actions.txt"), std::string::npos);
  // the header's lines come first
  const std::string line =
      "actions.txt:" + std::to_string(1 + std::ranges::count(linesOf(kMouseHeader), '\n')) + ":";
  EXPECT_NE(message("1 2 3").find(line), std::string::npos) << message("1 2 3");
}

}  // namespace
}  // namespace airclay
