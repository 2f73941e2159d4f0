// SPDX-License-Identifier: MIT
// `airclay calibrate`: computes rig.toml from images of a moving board, and reports its accuracy.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/progress.h"
#include "app/commands/calibration_options.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

struct CalibrateOptions : CalibrationCommandOptions {
  std::string lens = "auto";
  CalibrationOptions calibration;
};

LensChoice lensFrom(const std::string& name) {
  if (name == "5") return LensChoice::kFive;
  if (name == "8") return LensChoice::kEight;
  return name == "fisheye" ? LensChoice::kFisheye : LensChoice::kAuto;
}

void print(const CalibrateOptions& options, const Calibration& found) {
  const std::vector<Camera>& cameras = found.rig.cameras;
  std::vector<std::vector<std::string>> rows = {
      {"camera", "views", "shared", "rms px", "image covered", "lens"}};
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraQuality& quality = found.cameras[i];
    const Lens& lens = cameras[i].lens;
    const auto coefficients =
        std::count_if(lens.distortion.begin(), lens.distortion.end(), [](double k) { return k != 0; });
    rows.push_back({cameras[i].name, std::to_string(quality.views), std::to_string(quality.shared_views),
                    fixed(quality.rms_px, 2), fixed(100 * quality.coverage, 0) + " %",
                    (lens.model == LensModel::kFisheye ? "fisheye, " : "") + fixed(lens.fx, 1) + " px, " +
                        std::to_string(coefficients) +
                        (coefficients == 1 ? " coefficient" : " coefficients")});
  }
  if (options.printsMessages()) printTable(rows);
  std::string distances;
  for (const Baseline& baseline : found.baselines)
    if (baseline.b == baseline.a + 1)
      distances += (distances.empty() ? "" : ", ") + cameras[static_cast<std::size_t>(baseline.a)].name +
                   " - " + cameras[static_cast<std::size_t>(baseline.b)].name + " " +
                   fixed(baseline.metres, 3) + " m";
  printLine(options, "distances: " + distances);
  printLine(options, "reprojection error " + fixed(found.rms_px, 2) +
                         " px RMS; error of lengths on the board " + describeScale(found) +
                         "; the world origin is the board in frame " + std::to_string(found.world_frame) +
                         (options.live() || options.calibration.world_frame
                              ? ""
                              : " (--world N selects a frame in which it is flat on the table)"));
  printLine(options, describeOutput(options));
}

nlohmann::ordered_json jsonOf(const Calibration& found) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < found.cameras.size(); ++i) {
    const CameraQuality& quality = found.cameras[i];
    cameras.push_back({{"name", found.rig.cameras[i].name},
                       {"views", quality.views},
                       {"shared_views", quality.shared_views},
                       {"rms_px", quality.rms_px},
                       {"coverage", quality.coverage}});
  }
  nlohmann::ordered_json baselines = nlohmann::ordered_json::array();
  for (const Baseline& baseline : found.baselines)
    baselines.push_back({{"cameras",
                          {found.rig.cameras[static_cast<std::size_t>(baseline.a)].name,
                           found.rig.cameras[static_cast<std::size_t>(baseline.b)].name}},
                         {"metres", baseline.metres}});
  return {{"rms_px", found.rms_px}, {"scale_error_mm", scaleJson(found)}, {"cameras", cameras},
          {"baselines", baselines}, {"world_frame", found.world_frame},   {"warnings", found.warnings}};
}

Calibration calibrateViews(const CalibrateOptions& options, const Board& board,
                           const std::vector<CameraViews>& views, const std::vector<std::string>& warnings) {
  Calibration found = calibrate(board, views, options.calibration);
  found.warnings.insert(found.warnings.begin(), warnings.begin(), warnings.end());
  options.write(found, board,
                "the world origin is the board in frame " + std::to_string(found.world_frame) +
                    "; --world, --center and --edge move the workspace");
  return found;
}

Calibration fromRecording(const CalibrateOptions& options, const Board& board,
                          std::vector<std::string>& warnings) {
  BoardRecording recording(options.take);
  const std::vector<CameraViews> views = options.findBoards(recording, board, warnings);
  const ProgressTask progress("calibrating", options.printsMessages());
  return calibrateViews(options, board, views, warnings);
}

Calibration fromCameras(CalibrateOptions& options, const Board& board,
                        const std::vector<std::string>& warnings) {
  if (options.calibration.world_frame)
    throw Error(
        "--world does not apply to --camera; press W in the window while the board is flat on the table",
        Fault::kUsage);
  LiveCameras cameras(options.cameras.live(options.cameras.sources()),
                      options.cameras.liveOptions(LiveOptions::Sets::kNewest));
  Calibration found;
  options.collectLive(cameras, board, [&](const std::vector<CameraViews>& views, std::optional<int> world) {
    options.calibration.world_frame = world;
    found = calibrateViews(options, board, views, warnings);
    return resultLines(found, options);
  });
  return found;
}

void runCalibrate(CalibrateOptions options) {
  options.check();
  options.calibration.lens = lensFrom(options.lens);
  options.search.also = options.calibration.world_frame;
  std::vector<std::string> warnings;
  const Board board = options.measuredBoard(warnings);
  const Calibration found =
      options.live() ? fromCameras(options, board, warnings) : fromRecording(options, board, warnings);
  if (options.json) printJson(jsonOf(found));
  print(options, found);
  if (!options.json)
    for (const std::string& warning : found.warnings) printWarning(warning);
}

void addWorldOptions(CLI::App& command, CalibrateOptions& options) {
  CalibrationOptions& calibration = options.calibration;
  addWorldOption(command, calibration.world_frame, "the frame that all cameras see best");
  command
      .add_option_function<std::string>(
          "--center",
          [&calibration](const std::string& text) { calibration.center = parsePoint("--center", text); },
          "centre of the workspace in the world, metres [with --world, half an edge above the board; "
          "otherwise the origin]")
      ->type_name("X,Y,Z");
  command.add_option("--edge", calibration.edge_m, "edge of the workspace, metres [0.6]")
      ->check(CLI::Range(1e-3, 1e4).description(""))
      ->type_name("M");
}

}  // namespace

void addCalibrate(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("calibrate", "calibrate the cameras with a moving board, live or recorded");
  const auto options = std::make_shared<CalibrateOptions>();
  addCalibrationOptions(*command, *options);
  command
      ->add_option("--lens", options->lens,
                   "lens model: auto (default) picks the fewest distortion coefficients that explain the "
                   "views; 5 or 8 coefficients; or fisheye")
      ->check(CLI::IsMember({"auto", "5", "8", "fisheye"}).description(""))
      ->type_name("auto|5|8|fisheye");
  addWorldOptions(*command, *options);
  command->footer(
      "Examples:\n  airclay calibrate --camera left=0 --camera right=2 --out rig.toml\n"
      "  airclay calibrate recording --out rig.toml --world 0\n"
      "  airclay calibrate recording --squares 7x5 --square-mm 55 --marker-mm 41 --out rig.toml --image "
      "rig.png");
  command->callback([options] { runCalibrate(*options); });
}

}  // namespace airclay
