// SPDX-License-Identifier: MIT
// `airclay board`, as it is run.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/calibration/board_detector.h"
#include "engine/camera/rig.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

Words boardWords(const std::filesystem::path& out, const Words& more = {}) {
  Words words{"board", "--out", out.string()};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

json jsonOf(Words words) {
  words.push_back("--json");
  const Ran ran = runAirclay(words);
  EXPECT_EQ(ran.status, 0) << ran.errors;
  EXPECT_EQ(ran.errors, "");
  return json::parse(ran.output);
}

TEST(BoardApp, MakesWhatTheDetectorFinds) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "board.png";
  const json said = jsonOf(boardWords(file, {"--dpi", "100"}));
  EXPECT_EQ(said["squares"], json({5, 3}));
  EXPECT_EQ(said["square_mm"], 54);
  EXPECT_EQ(said["marker_mm"], 40);
  EXPECT_EQ(said["page"], "a4");
  EXPECT_FALSE(said.contains("cell_px"));
  const ImageSize size = imageSize(file);
  std::vector<std::uint8_t> grey(std::size_t(size.width) * std::size_t(size.height));
  readImage(file, size, PixelFormat::kGrey8, grey);
  const auto view = BoardDetector(Board()).find(size, PixelFormat::kGrey8, grey);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->ids.size(), 8u);
}

TEST(BoardApp, SaysHowToPrintAndWhetherItWillBeRead) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "board.pdf";
  const Ran ran = runAirclay(boardWords(file, {"--resolution", "640x480", "--distance", "1.1"}));
  EXPECT_EQ(ran.status, 0) << ran.errors;
  EXPECT_TRUE(contentOf(file).starts_with("%PDF-"));
  for (const char* words : {"5 x 3 squares of 54 mm", "100 %", "100 mm", "3.4 pixels: it will be read"})
    EXPECT_NE(ran.output.find(words), std::string::npos) << words << "\n" << ran.output;
  EXPECT_EQ(runAirclay(boardWords(file, {"--quiet"})).output, "");
}

TEST(BoardApp, ProposesAReadableBoardThatCanBeMade) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "board.pdf";
  const json said = jsonOf(boardWords(file, {"--resolution", "640x480", "--distance", "1.8"}));
  EXPECT_FALSE(said["readable"]);
  ASSERT_TRUE(said.contains("proposal"));
  const json& proposal = said["proposal"];
  const std::string squares = std::to_string(proposal["squares"][0].get<int>()) + "x" +
                              std::to_string(proposal["squares"][1].get<int>());
  const json again = jsonOf(
      boardWords(file, {"--squares", squares, "--square-mm", proposal["square_mm"].dump(), "--marker-mm",
                        proposal["marker_mm"].dump(), "--dictionary", proposal["dictionary"], "--page",
                        proposal["page"], "--resolution", "640x480", "--distance", "1.8"}));
  EXPECT_TRUE(again["readable"]);
  EXPECT_NEAR(again["cell_px"].get<double>(), proposal["cell_px"].get<double>(), 1e-6);
}

TEST(BoardApp, ARigSaysTheCamerasItself) {
  const TemporaryFolder folder;
  const Rig rig = ringRig(3, 640, 480);
  writeRig(folder / "rig.toml", rig);
  const json said = jsonOf(boardWords(folder / "board.pdf", {"--rig", (folder / "rig.toml").string()}));
  double smallest = 1e9;
  for (const Camera& camera : rig.cameras) {
    const double distance_m = (camera.camera_from_world * rig.workspace.center).norm();
    smallest = std::min(smallest, 0.040 / 6 * (camera.lens.fx + camera.lens.fy) / 2 / distance_m);
  }
  EXPECT_NEAR(said["cell_px"].get<double>(), smallest, 1e-6);
}

TEST(BoardApp, WhatIsWrongIsSaidInOneLine) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& out, const Words& words, int status, const std::string& says) {
    const Ran ran = runAirclay(boardWords(folder / out, words));
    EXPECT_EQ(ran.status, status) << says;
    EXPECT_EQ(ran.output, "");
    ASSERT_EQ(ran.errorLines().size(), 1u) << ran.errors;
    EXPECT_NE(ran.errors.find(says), std::string::npos) << ran.errors;
  };
  refused("board.jpg", {}, 2, ".pdf or .png");
  refused("none/board.pdf", {}, 1, "no such folder");
  refused("board.pdf", {"--squares", "5by3"}, 2, "--squares 5by3");
  refused("board.pdf", {"--squares", "2x2"}, 2, "--squares 2x2");
  refused("board.pdf", {"--squares", "7x5"}, 2, "--page a3");
  refused("board.pdf", {"--marker-mm", "60"}, 2, "--marker-mm 60");
  refused("board.pdf", {"--dictionary", "4X4"}, 2, "--dictionary 4X4");
  refused("board.pdf", {"--page", "a5"}, 2, "--page");
  refused("board.pdf", {"--distance", "1"}, 2, "--resolution");
  refused("board.pdf", {"--resolution", "640", "--distance", "1"}, 2, "--resolution 640");
  refused("board.pdf", {"--resolution", "640x480", "--distance", "-1"}, 2, "--distance");
  refused("board.pdf", {"--rig", (folder / "no.toml").string()}, 1, "no.toml");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace airclay
