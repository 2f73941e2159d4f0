// SPDX-License-Identifier: MIT
// What `airclay calibrate` and `airclay recalibrate` have in common: a board waved before cameras that run,
// or a recording of one; how they are named on the command line, and how it is said what came of it.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/cli/board_options.h"
#include "app/cli/camera_options.h"
#include "app/cli/command.h"
#include "app/session/live_calibration.h"
#include "capture/calibration/board_recording.h"

namespace airclay {

/// Where views of the board come from, and where the rig that comes of them goes, as written.
struct CalibrationCommandOptions : CommonOptions {
  std::string take, out, image;
  CameraOptions cameras;
  bool headless = false;
  RequiredViews required;  ///< of cameras that run
  BoardOptions board;
  BoardSearch search;
  double measured_square_mm = 0;  ///< 0: not said

  /// The board as it was measured; a line is added to `warnings` when that isn't what was ordered: printers
  /// fit to the page. \throw Error (Fault::kUsage) when it was not measured, or is no board.
  Board measuredBoard(std::vector<std::string>& warnings) const;

  /// Looks for it in all of the recording's cameras, and shows a bar; what is unusual is added to `warnings`.
  std::vector<CameraViews> findBoards(BoardRecording& recording, const Board& of,
                                      std::vector<std::string>& warnings) const;

  /// Before anything is opened. \throw Error when the rig or the image could not be written;
  /// (Fault::kUsage) unless there is either a recording or cameras.
  void check() const;

  bool live() const { return cameras.given(); }
  /// The cameras run until there are views enough, as a window or the terminal shows; `make` makes the rig of
  /// them, in the window as often as it is told to. \throw Error when there was no rig in the end
  void collectLive(LiveCameras& running, const Board& of, const LiveCalibration::Finish& make) const;

  /// Writes both. \throw Error when the rig cannot be real; `hint` is added to its message.
  void write(const Calibration& found, const Board& of, const std::string& hint) const;
};

/// TAKE or --camera and its like, --out, --image, the board's options, --check-square-mm, --every and the
/// common options.
void addCalibrationOptions(CLI::App& command, CalibrationCommandOptions& options);

/// --world, the frame in which the board lies on the table. \param otherwise what is without it
void addWorldOption(CLI::App& command, std::optional<int>& frame, const std::string& otherwise);

/// What came of it, for a window: a line a camera, then what `words` say, then warnings.
std::vector<std::string> resultLines(const Calibration& found, const CalibrationCommandOptions& options);
/// "0.21 mm RMS"
std::string describeScale(const Calibration& found);
/// "rig in rig.toml, and how it looks in rig.png"
std::string describeOutput(const CalibrationCommandOptions& options);
/// `scale_error_mm`: null where it is not known.
nlohmann::ordered_json scaleJson(const Calibration& found);

}  // namespace airclay
