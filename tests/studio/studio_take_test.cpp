// SPDX-License-Identifier: MIT
// The studio with cameras: playing takes, recording them again, and live cameras.
#include "engine/camera/rig.h"
#include "tests/studio/studio_fixture.h"
#include "tests/support/small_take.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;

TEST_F(Studio, PlayingATakeReproducesTheClay) {
  const int frames = writeSmallTake(folder / "take");
  // Twice in the window, where the timing of images and frames varies.
  for (const char* name : {"a.clay", "b.clay"}) {
    startWithoutHint({at("take"), "--background", "10", "--save", at(name)});
    const auto ended = [](const json& line) { return line["ended"] == true; };
    ASSERT_TRUE(sees(ended, 3 * kDeadlineS)) << log() << errors();  // every frame is processed
    EXPECT_EQ(log()["frame"], frames - 1);
    const Screenshot before = desktop->screenshot();
    desktop->key("F1");  // the window still responds
    EXPECT_TRUE(waitUntil([&] { return differingFraction(before, desktop->screenshot(), 0.4) > 0.5; }));
    close();
  }
  const ClayState once = Document::open(at("a.clay")).state();
  EXPECT_EQ(namesOf(Document::open(at("a.clay"))), (Strings{"New tube", ">Push"}));
  EXPECT_GT(farthestMove(once, tubeState()), 0.005);
  EXPECT_TRUE(sameClay(once, Document::open(at("b.clay")).state()));

  for (const char* name : {"c.clay", "d.clay"}) {
    const RunResult result = runAirclay(
        {"sculpt", at("take"), "--background", "10", "--headless", "--save", at(name), "--out", at("out")},
        {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
    ASSERT_EQ(result.status, 0) << result.errors;
    EXPECT_EQ(result.errors, "");
  }
  const ClayState headless = Document::open(at("c.clay")).state();
  EXPECT_GT(farthestMove(headless, tubeState()), 0.005);
  EXPECT_TRUE(sameClay(headless, Document::open(at("d.clay")).state()));
  EXPECT_TRUE(sameClay(headless, once));  // with the window
}

TEST_F(Studio, ReplayReproducesTakeSession) {
  writeSmallTake(folder / "take");
  folder.write("config/airclay/studio.toml",
               "first_run = false\nsteady_hand = false\nfolder = '" + folder.path().string() + "'\n");
  start({at("take"), "--save", at("a.clay")});
  // from the middle of the take, after the background is learned
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
  const RunResult result =
      runAirclay({"sculpt", recording, "--headless", "--save", at("b.clay"), "--out", at("out")},
                 {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_TRUE(sameClay(Document::open(at("b.clay")).state(), once));
  EXPECT_GT(farthestMove(once, tubeState()), 0.005);
}

TEST_F(Studio, LowWindowShowsEveryCamera) {
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

TEST_F(Studio, LiveBackgroundIsRelearned) {
  writeSmallTake(folder / "take", {.empty_frames = 300});
  Strings arguments = {"--rig",    at("take/rig.toml"), "--save", at("a.clay"),
                       "--record", at("mine"),          "--loop"};
  for (const Camera& camera : readRig(at("take/rig.toml")).cameras)
    arguments.insert(arguments.end(), {"--camera", camera.name + "=" + at("take/" + camera.name)});
  startWithoutHint(arguments);
  const auto learning = [](bool expected) {
    return [expected](const json& line) { return line["frame"] > 10 && line["learning"] == expected; };
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
  // and it replays
  const RunResult result = runAirclay({"sculpt", at("mine"), "--headless", "--out", at("out")},
                                      {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
}

}  // namespace
}  // namespace airclay
