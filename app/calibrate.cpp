// SPDX-License-Identifier: MIT
// `airclay calibrate`: from a recording of a waved board to rig.toml, with a word on how good it is.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/board_words.h"
#include "app/command.h"
#include "app/outputs.h"
#include "app/progress.h"
#include "capture/calibration_recording.h"
#include "engine/error.h"
#include "engine/mesh_file.h"

namespace airclay {
namespace {

// Paper shrinks and rulers are read to half a millimetre over a board: less than this is no other size.
constexpr double kSameSize = 0.002;

struct CalibrateOptions : CommonOptions {
  std::string take, out, picture, lens = "auto";
  BoardWords board;
  BoardSearch search;
  CalibrationOptions calibration;
  double measured_square_mm = 0;  ///< 0: not said
};

LensChoice lensFrom(const std::string& word) {
  if (word == "5") return LensChoice::kFive;
  if (word == "8") return LensChoice::kEight;
  return word == "fisheye" ? LensChoice::kFisheye : LensChoice::kAuto;
}

/// The board as it was measured, and a line when that isn't what was ordered: printers fit to the page.
Board measuredBoard(const CalibrateOptions& options, std::vector<std::string>& warnings) {
  Board board = options.board.board();
  if (options.measured_square_mm <= 0) return board;
  const double square_m = options.measured_square_mm / 1000, ratio = square_m / board.square_m;
  if (ratio < 0.5 || ratio > 2)
    throw Error("--check-square-mm " + fixed(options.measured_square_mm, 2) +
                    " is not the size of a square of " + fixed(1000 * board.square_m, 2) +
                    " mm; the measured length of one square, in millimetres, would be right",
                Fault::kUsage);
  if (std::abs(ratio - 1) > kSameSize)
    warnings.push_back("the board was printed at " + fixed(100 * ratio, 1) + " %: its squares are " +
                       fixed(1000 * square_m, 2) + " mm, not " + fixed(1000 * board.square_m, 2) +
                       "; the rig is of the measured size, and --square-mm " + fixed(1000 * square_m, 2) +
                       " says so from now on");
  board.square_m = square_m;
  board.marker_m *= ratio;
  return board;
}

Calibration calibrateRecording(const CalibrateOptions& options, const Board& board,
                               std::vector<std::string>& warnings) {
  BoardRecording recording(options.take);
  warnings.insert(warnings.end(), recording.notes().begin(), recording.notes().end());
  const std::vector<CameraViews> views = [&] {
    const WorkProgress progress("looking for the board", options.talks());
    return recording.findBoards(BoardDetector(board), options.search);
  }();
  const WorkProgress progress("calibrating", options.talks());
  return calibrate(board, views, options.calibration);
}

void print(const CalibrateOptions& options, const Calibration& found) {
  const std::vector<Camera>& cameras = found.rig.cameras;
  std::vector<std::vector<std::string>> rows = {
      {"camera", "views", "shared", "rms px", "picture covered", "lens"}};
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
  if (options.talks()) printTable(rows);
  std::string apart;
  for (const Baseline& baseline : found.baselines)
    if (baseline.b == baseline.a + 1)
      apart += (apart.empty() ? "" : ", ") + cameras[static_cast<std::size_t>(baseline.a)].name + " - " +
               cameras[static_cast<std::size_t>(baseline.b)].name + " " + fixed(baseline.metres, 3) + " m";
  say(options, "apart: " + apart);
  say(options,
      "corners are off by " + fixed(found.rms_px, 2) + " px RMS; lengths on the board by " +
          (found.scale_error_mm ? fixed(*found.scale_error_mm, 2) + " mm RMS" : "an unknown amount") +
          "; the world is the board's of frame " + std::to_string(found.world_frame) +
          (options.calibration.world_frame ? "" : " (--world N names one that lies on the table)"));
  say(options,
      "rig in " + options.out + (options.picture.empty() ? "" : ", and how it looks in " + options.picture));
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
  return {{"rms_px", found.rms_px},
          {"scale_error_mm", found.scale_error_mm ? nlohmann::ordered_json(*found.scale_error_mm) : nullptr},
          {"cameras", cameras},
          {"baselines", baselines},
          {"world_frame", found.world_frame},
          {"warnings", found.warnings}};
}

void runCalibrate(CalibrateOptions options) {
  checkWritable(options.out);
  if (!options.picture.empty()) checkWritable(options.picture);
  options.calibration.lens = lensFrom(options.lens);
  options.search.also = options.calibration.world_frame;
  std::vector<std::string> warnings;
  const Board board = measuredBoard(options, warnings);
  Calibration found = calibrateRecording(options, board, warnings);
  found.warnings.insert(found.warnings.begin(), warnings.begin(), warnings.end());
  try {
    checkRig(found.rig, options.out);
  } catch (const Error& error) {
    throw Error(std::string(error.what()) + " (the world is the board's of frame " +
                std::to_string(found.world_frame) + "; --world, --center and --edge put the cube elsewhere)");
  }
  writeRig(options.out, found.rig);
  if (!options.picture.empty()) drawCalibration(options.picture, board, found);
  if (options.json) printJson(jsonOf(found));
  print(options, found);
  if (!options.json)
    for (const std::string& warning : found.warnings) warn(warning);
}

void addWorldOptions(CLI::App& command, CalibrateOptions& options) {
  CalibrationOptions& calibration = options.calibration;
  command
      .add_option(
          "--world", calibration.world_frame,
          "the frame in which the board lies on the table: its middle is the world's origin, z up, x along "
          "its rows [the first that all cameras see best]")
      ->check(CLI::NonNegativeNumber.description(""))
      ->type_name("N");
  command
      .add_option_function<std::string>(
          "--center",
          [&calibration](const std::string& text) { calibration.center = placeFrom("--center", text); },
          "the cube's middle, metres, world [with --world half an edge above the board, else the origin]")
      ->type_name("X,Y,Z");
  command.add_option("--edge", calibration.edge_m, "the cube's edge, metres [0.6]")
      ->check(CLI::Range(1e-3, 1e4).description(""))
      ->type_name("M");
}

}  // namespace

void addCalibrate(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("calibrate", "find the cameras from a recording of a waved board");
  const auto options = std::make_shared<CalibrateOptions>();
  command
      ->add_option("TAKE", options->take,
                   "the recording: a folder with a video NAME.mp4, .mkv or .avi, or pictures NAME/000000.png "
                   "and on, of each camera; timestamps.csv is used where there is one")
      ->type_name("")
      ->required();
  command->add_option("--out", options->out, "where the calibrated rig goes")
      ->type_name("RIG.toml")
      ->required();
  command->add_option("--picture", options->picture, "where a picture of the rig and what is left over goes")
      ->type_name("FILE.png");
  addBoardOptions(*command, options->board);
  command
      ->add_option(
          "--check-square-mm", options->measured_square_mm,
          "a square's edge as measured on the print: another size than --square-mm is said, and used")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("MM");
  command
      ->add_option(
          "--lens", options->lens,
          "auto [this]: as few distortion coefficients as explain the views; or so many; or a fisheye lens")
      ->check(CLI::IsMember({"auto", "5", "8", "fisheye"}).description(""))
      ->type_name("auto|5|8|fisheye");
  addWorldOptions(*command, *options);
  command
      ->add_option("--every", options->search.every,
                   "look at every Nth frame [as many as make 150 of a camera]")
      ->check(CLI::Range(1, 1'000'000).description(""))
      ->type_name("N");
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay calibrate recording --out rig.toml --world 0\n"
      "  airclay calibrate recording --squares 7x5 --square-mm 55 --marker-mm 41 --out rig.toml --picture "
      "rig.png");
  command->callback([options] { runCalibrate(*options); });
}

}  // namespace airclay
