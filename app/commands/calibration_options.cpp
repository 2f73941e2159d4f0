// SPDX-License-Identifier: MIT
#include "app/commands/calibration_options.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/cli/output_paths.h"
#include "app/cli/progress.h"
#include "app/studio/calibration_window.h"
#include "app/studio/window.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Paper shrinks, and a ruler is accurate to half a millimetre over a board: smaller differences are ignored.
constexpr double kSameSize = 0.002;
// For sources with arrival times: half the variation of a USB camera's delay.
constexpr double kUnseenSkewS = 0.008;
constexpr auto kLookS = std::chrono::milliseconds(50);
constexpr double kAdviceStaysS = 2;

/// Collects views until there are enough, the files end, or Ctrl-C. Prints the advice when it changes.
void collectInTerminal(const CalibrationCommandOptions& options, LiveCalibration& calibration) {
  std::string printed;
  Clock::time_point printed_at{};
  try {
    Progress progress("collecting views", 100, options.printsMessages());
    for (;;) {
      std::this_thread::sleep_for(kLookS);
      const LiveCalibration::State state = calibration.state();
      progress.reach(state.share);
      if (state.enough || state.ended) return;
      if (state.advice == printed || secondsBetween(printed_at, Clock::now()) < kAdviceStaysS) continue;
      printed = state.advice;
      printed_at = Clock::now();
      if (!printed.empty()) printLine(options, printed);
    }
  } catch (const Interrupted&) {  // Ctrl-C: calibrate with the views so far
  }
}

LiveCalibration::State finishInTerminal(const CalibrationCommandOptions& options,
                                        LiveCalibration& calibration) {
  calibration.finish();
  Progress progress("calibrating", 100, options.printsMessages());
  for (;;) {
    std::this_thread::sleep_for(kLookS);
    const LiveCalibration::State state = calibration.state();
    progress.reach(state.work_share);
    if (!state.result.empty() || !state.fault.empty()) return state;
  }
}

}  // namespace

void CalibrationCommandOptions::collectLive(LiveCameras& running, const Board& of,
                                            const LiveCalibration::Finish& make) const {
  LiveCalibration::Options options{
      .board = of, .collector = {.required = required}, .finish = make, .wake = {}};
  for (const CameraStatus& camera : running.status())
    if (camera.times == TimeOrigin::kArrival) options.collector.unseen_skew_s = kUnseenSkewS;
  LiveCalibration::State last;
  if (!headless && Window::possible()) {
    CommandGpu gpu(*this);
    last = showCalibration(gpu, running, options);
  } else {
    LiveCalibration calibration(running, options);
    collectInTerminal(*this, calibration);
    last = finishInTerminal(*this, calibration);
  }
  if (last.result.empty())
    throw Error(last.fault.empty()
                    ? "the window was closed before the calibration finished; nothing was written"
                    : last.fault);
}

Board CalibrationCommandOptions::measuredBoard(std::vector<std::string>& warnings) const {
  Board measured = board.board();
  if (measured_square_mm <= 0) return measured;
  const double square_m = measured_square_mm / 1000, ratio = square_m / measured.square_m;
  if (ratio < 0.5 || ratio > 2)
    throw Error("--check-square-mm " + fixed(measured_square_mm, 2) + " is not the size of a square of " +
                    fixed(1000 * measured.square_m, 2) +
                    " mm; expected the measured edge of one square, in millimetres",
                Fault::kUsage);
  if (std::abs(ratio - 1) > kSameSize)
    warnings.push_back("the board was printed at " + fixed(100 * ratio, 1) + " %: its squares are " +
                       fixed(1000 * square_m, 2) + " mm, not " + fixed(1000 * measured.square_m, 2) +
                       "; the rig uses the measured size; pass --square-mm " + fixed(1000 * square_m, 2) +
                       " from now on");
  measured.square_m = square_m;
  measured.marker_m *= ratio;
  return measured;
}

std::vector<CameraViews> CalibrationCommandOptions::findBoards(BoardRecording& recording, const Board& of,
                                                               std::vector<std::string>& warnings) const {
  warnings.insert(warnings.end(), recording.notes().begin(), recording.notes().end());
  const ProgressTask progress("detecting the board", printsMessages());
  return recording.findBoards(BoardDetector(of), search);
}

void CalibrationCommandOptions::check() const {
  if (take.empty() && !live())
    throw Error(
        "no images of the board; expected a recording, TAKE, or live cameras, --camera NAME=SOURCE for each",
        Fault::kUsage);
  if (!take.empty() && live())
    throw Error("a recording and live cameras exclude each other; use either TAKE or --camera",
                Fault::kUsage);
  checkWritable(out);
  if (!image.empty()) checkWritable(image);
}

void CalibrationCommandOptions::write(const Calibration& found, const Board& of,
                                      const std::string& hint) const {
  try {
    checkRig(found.rig, out);
  } catch (const Error& error) {
    throw Error(error.what() + (" (" + hint + ")"));
  }
  writeRig(out, found.rig);
  if (!image.empty()) drawCalibration(image, of, found);
}

void addCalibrationOptions(CLI::App& command, CalibrationCommandOptions& options) {
  command
      .add_option("TAKE", options.take,
                  "recording of the board: a folder with a video NAME.mp4 (.mov, .mkv, .avi, ...) or images "
                  "NAME/000000.png, ... per camera, and optionally timestamps.csv; omit it with --camera")
      ->type_name("");
  addCameraOptions(command, options.cameras);
  command.add_flag("--headless", options.headless, "with --camera, run without a window");
  command.add_option("--out", options.out, "output file for the calibrated rig")
      ->type_name("RIG.toml")
      ->required();
  command
      .add_option("--image", options.image, "output file for an image of the rig and the reprojection errors")
      ->type_name("FILE.png");
  addDeprecatedName(command, "--picture", "--image");
  addBoardOptions(command, options.board);
  command
      .add_option(
          "--check-square-mm", options.measured_square_mm,
          "edge of a square as measured on the print; replaces --square-mm, with a warning if the two differ")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("MM");
  command
      .add_option("--every", options.search.every,
                  "search every Nth frame [chosen to search about 150 frames per camera]")
      ->check(CLI::Range(1, 1'000'000).description(""))
      ->type_name("N");
  addCommonOptions(command, options, Uses::kDevice, true);
}

void addWorldOption(CLI::App& command, std::optional<int>& frame, const std::string& otherwise) {
  command
      .add_option("--world", frame,
                  "frame in which the board is flat on the table: its centre becomes the world origin, z up, "
                  "x along its rows [" +
                      otherwise + "]")
      ->check(CLI::NonNegativeNumber.description(""))
      ->type_name("N");
}

std::vector<std::string> resultLines(const Calibration& found, const CalibrationCommandOptions& options) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < found.cameras.size(); ++i)
    lines.push_back(found.rig.cameras[i].name + ": " + fixed(found.cameras[i].rms_px, 2) + " px RMS in " +
                    std::to_string(found.cameras[i].views) + " views");
  lines.push_back("error of lengths on the board: " + describeScale(found));
  lines.push_back(describeOutput(options));
  lines.insert(lines.end(), found.warnings.begin(), found.warnings.end());
  return lines;
}

std::string describeScale(const Calibration& found) {
  return found.scale_error_mm ? fixed(*found.scale_error_mm, 2) + " mm RMS" : "unknown";
}

std::string describeOutput(const CalibrationCommandOptions& options) {
  return "rig written to " + options.out +
         (options.image.empty() ? "" : ", image of the rig to " + options.image);
}

nlohmann::ordered_json scaleJson(const Calibration& found) {
  return found.scale_error_mm ? nlohmann::ordered_json(*found.scale_error_mm) : nullptr;
}

}  // namespace airclay
