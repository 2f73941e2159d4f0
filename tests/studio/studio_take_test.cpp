// SPDX-License-Identifier: MIT
// The studio with cameras: takes that are played, recorded anew, and cameras that run.
#include "engine/camera/rig.h"
#include "tests/studio/studio_fixture.h"
#include "tests/support/small_take.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;

TEST_F(Studio, ATakeIsPlayedToItsEndAndAlwaysMakesTheSameClay) {
  const int frames = writeSmallTake(folder / "take");
  // Twice in the window, where images and frames come as they come.
  for (const char* name : {"a.clay", "b.clay"}) {
    startWithoutHint({at("take"), "--background", "10", "--save", at(name)});
    const auto ended = [](const json& line) { return line["ended"] == true; };
    ASSERT_TRUE(sees(ended, 3 * kDeadlineS)) << log() << errors();  // every frame is worked on
    EXPECT_EQ(log()["frame"], frames - 1);
    const Screenshot before = desktop->screenshot();
    desktop->key("F1");  // the window is there, and listens
    EXPECT_TRUE(waitUntil([&] { return differingFraction(before, desktop->screenshot(), 0.4) > 0.5; }));
    close();
  }
  const ClayState once = Document::open(at("a.clay")).state();
  EXPECT_EQ(namesOf(Document::open(at("a.clay"))), (Words{"New tube", ">Push"}));
  EXPECT_GT(farthestMove(once, tubeState()), 0.005);
  EXPECT_TRUE(sameClay(once, Document::open(at("b.clay")).state()));

  for (const char* name : {"c.clay", "d.clay"}) {
    const Ran ran = runAirclay(
        {"sculpt", at("take"), "--background", "10", "--headless", "--save", at(name), "--out", at("out")},
        {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
    ASSERT_EQ(ran.status, 0) << ran.errors;
    EXPECT_EQ(ran.errors, "");
  }
  const ClayState headless = Document::open(at("c.clay")).state();
  EXPECT_GT(farthestMove(headless, tubeState()), 0.005);
  EXPECT_TRUE(sameClay(headless, Document::open(at("d.clay")).state()));
  EXPECT_TRUE(sameClay(headless, once));  // the window's own way
}

TEST_F(Studio, WhatWasRecordedOfATakeIsDoneAgain) {
  writeSmallTake(folder / "take");
  folder.write("config/airclay/studio.toml",
               "first_run = false\nsteady_hand = false\nfolder = '" + folder.path().string() + "'\n");
  start({at("take"), "--save", at("a.clay")});
  // from the midst of it, when the empty workspace has long been learned
  ASSERT_TRUE(sees([](const json& line) { return line["ended"] == true; }, 3 * kDeadlineS)) << log();
  desktop->key("ctrl+r");
  ASSERT_TRUE(sees([](const json& line) { return line["recording"] == true; })) << log();
  desktop->key("y");
  desktop->key("BackSpace");
  ASSERT_TRUE(sees([](const json& line) { return line["ended"] == false; })) << log();
  ASSERT_TRUE(sees([](const json& line) { return line["ended"] == true; }, 3 * kDeadlineS)) << log();
  desktop->key("ctrl+r");
  ASSERT_TRUE(seesNote("recorded ")) << log();
  close();
  const ClayState once = Document::open(at("a.clay")).state();
  const fs::path recording = recorded();
  const Ran ran = runAirclay({"sculpt", recording, "--headless", "--save", at("b.clay"), "--out", at("out")},
                             {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  ASSERT_EQ(ran.status, 0) << ran.errors;
  EXPECT_EQ(ran.errors, "");
  EXPECT_TRUE(sameClay(Document::open(at("b.clay")).state(), once));
  EXPECT_GT(farthestMove(once, tubeState()), 0.005);
}

TEST_F(Studio, EveryCameraIsSeenInALowWindow) {
  writeSmallTake(folder / "take");
  folder.write("config/airclay/studio.toml", "first_run = false\nwindow_width = 1280\nwindow_height = 720\n");
  start({at("take"), "--save", at("a.clay")});
  ASSERT_TRUE(sees([](const json& line) { return line["ended"] == true; }, 3 * kDeadlineS)) << log();
  EXPECT_EQ(log()["cameras_shown"], 4) << log();
  desktop->resize(1280, 1000);
  EXPECT_TRUE(sees([](const json& line) { return line["height"] == 1000 && line["cameras_shown"] == 4; }));
  desktop->resize(900, 500);
  EXPECT_TRUE(sees([](const json& line) { return line["height"] == 500; }));
  close();
}

TEST_F(Studio, TheEmptyWorkspaceOfCamerasThatRunIsLearnedAgain) {
  writeSmallTake(folder / "take", {.empty_frames = 300});
  Words words = {"--rig", at("take/rig.toml"), "--save", at("a.clay"), "--record", at("mine"), "--loop"};
  for (const Camera& camera : readRig(at("take/rig.toml")).cameras)
    words.insert(words.end(), {"--camera", camera.name + "=" + at("take/" + camera.name)});
  startWithoutHint(words);
  const auto learning = [](bool wanted) {
    return [wanted](const json& line) { return line["frame"] > 10 && line["learning"] == wanted; };
  };
  ASSERT_TRUE(sees(learning(false))) << log();
  const int before = log()["recorded_frames"];
  desktop->key("e");
  ASSERT_TRUE(sees([&](const json& line) { return line["recorded_frames"] > before + 30; })) << log();
  close();
  const std::string done = contentOf(folder / "mine/actions.txt");
  const std::size_t at_empty = done.find("\nempty\n");
  ASSERT_NE(at_empty, std::string::npos) << done;
  std::string taught;
  for (int i = 0; i < 10; ++i) taught += "learn\n";
  EXPECT_EQ(done.substr(at_empty + 7, taught.size() + 5), taught + "frame");
  // and it can be played
  const Ran ran = runAirclay({"sculpt", at("mine"), "--headless", "--out", at("out")},
                             {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  EXPECT_EQ(ran.status, 0) << ran.errors;
  EXPECT_EQ(ran.errors, "");
}

}  // namespace
}  // namespace airclay
