// SPDX-License-Identifier: MIT
// `airclay board` as a user runs it.
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
using Strings = std::vector<std::string>;

Strings boardCommand(const std::filesystem::path& out, const Strings& more = {}) {
  Strings arguments{"board", "--out", out.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

json jsonOf(Strings arguments) {
  arguments.push_back("--json");
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  return json::parse(result.output);
}

TEST(BoardApp, MakesDetectableBoards) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "board.png";
  const json report = jsonOf(boardCommand(file, {"--dpi", "100"}));
  EXPECT_EQ(report["squares"], json({5, 3}));
  EXPECT_EQ(report["square_mm"], 54);
  EXPECT_EQ(report["marker_mm"], 40);
  EXPECT_EQ(report["page"], "a4");
  EXPECT_FALSE(report.contains("cell_px"));
  const ImageSize size = imageSize(file);
  std::vector<std::uint8_t> grey(std::size_t(size.width) * std::size_t(size.height));
  readImage(file, size, PixelFormat::kGrey8, grey);
  const auto view = BoardDetector(Board()).find(size, PixelFormat::kGrey8, grey);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->ids.size(), 8u);
}

TEST(BoardApp, ReportsPrintingAndReadability) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "board.pdf";
  const RunResult result = runAirclay(boardCommand(file, {"--resolution", "640x480", "--distance", "1.1"}));
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(contentOf(file).starts_with("%PDF-"));
  for (const char* arguments : {"5 x 3 squares of 54 mm", "100 %", "100 mm", "3.4 pixels wide: readable"})
    EXPECT_NE(result.output.find(arguments), std::string::npos) << arguments << "\n" << result.output;
  EXPECT_EQ(runAirclay(boardCommand(file, {"--quiet"})).output, "");
}

TEST(BoardApp, ProposesReadableBoard) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "board.pdf";
  const json report = jsonOf(boardCommand(file, {"--resolution", "640x480", "--distance", "1.8"}));
  EXPECT_FALSE(report["readable"]);
  ASSERT_TRUE(report.contains("proposal"));
  const json& proposal = report["proposal"];
  const std::string squares = std::to_string(proposal["squares"][0].get<int>()) + "x" +
                              std::to_string(proposal["squares"][1].get<int>());
  const json again = jsonOf(
      boardCommand(file, {"--squares", squares, "--square-mm", proposal["square_mm"].dump(), "--marker-mm",
                          proposal["marker_mm"].dump(), "--dictionary", proposal["dictionary"], "--page",
                          proposal["page"], "--resolution", "640x480", "--distance", "1.8"}));
  EXPECT_TRUE(again["readable"]);
  EXPECT_NEAR(again["cell_px"].get<double>(), proposal["cell_px"].get<double>(), 1e-6);
}

TEST(BoardApp, TakesCamerasFromTheRig) {
  const TemporaryFolder folder;
  const Rig rig = ringRig(3, 640, 480);
  writeRig(folder / "rig.toml", rig);
  const json report = jsonOf(boardCommand(folder / "board.pdf", {"--rig", (folder / "rig.toml").string()}));
  double smallest = 1e9;
  for (const Camera& camera : rig.cameras) {
    const double distance_m = (camera.camera_from_world * rig.workspace.center).norm();
    smallest = std::min(smallest, 0.040 / 6 * (camera.lens.fx + camera.lens.fy) / 2 / distance_m);
  }
  EXPECT_NEAR(report["cell_px"].get<double>(), smallest, 1e-6);
}

TEST(BoardApp, ErrorsAreOneLine) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& out, const Strings& arguments, int status,
                           const std::string& expected) {
    const RunResult result = runAirclay(boardCommand(folder / out, arguments));
    EXPECT_EQ(result.status, status) << expected;
    EXPECT_EQ(result.output, "");
    ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
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
