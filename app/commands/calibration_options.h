// SPDX-License-Identifier: MIT
// What `airclay calibrate` and `airclay recalibrate` share: options, collecting views from live cameras or a
// recording, and reporting the result.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/cli/board_options.h"
#include "app/cli/camera_options.h"
#include "app/cli/command.h"
#include "app/session/live_calibration.h"
#include "capture/calibration/board_recording.h"

namespace airclay {

/// Input and output options, as given.
struct CalibrationCommandOptions : CommonOptions {
  std::string take, out, image;
  CameraOptions cameras;
  bool headless = false;
  RequiredViews required;  ///< of live cameras
  BoardOptions board;
  BoardSearch search;
  double measured_square_mm = 0;  ///< 0: not given

  /// The board at its measured size. Adds a warning if that differs from the nominal size, because printers
  /// scale to the page. \throw Error (Fault::kUsage) if the size is implausible or the board invalid.
  Board measuredBoard(std::vector<std::string>& warnings) const;

  /// Detects the board in all cameras of the recording, with a progress bar. Adds the recording's notes to
  /// `warnings`.
  std::vector<CameraViews> findBoards(BoardRecording& recording, const Board& of,
                                      std::vector<std::string>& warnings) const;

  /// Checks the options before anything opens. \throw Error if an output file is not writable;
  /// (Fault::kUsage) unless either a recording or cameras are given.
  void check() const;

  bool live() const { return cameras.given(); }
  /// Collects views from live cameras in a window or the terminal, and calls `make` with them; in the window,
  /// each time the user asks. \throw Error if there is no rig at the end
  void collectLive(LiveCameras& running, const Board& of, const LiveCalibration::Finish& make) const;

  /// Writes the rig and the image. \throw Error if the rig is invalid; its message ends with `hint`.
  void write(const Calibration& found, const Board& of, const std::string& hint) const;
};

/// TAKE, the camera options, --out, --image, the board options, --check-square-mm, --every and the common
/// options.
void addCalibrationOptions(CLI::App& command, CalibrationCommandOptions& options);

/// --world, the frame in which the board is flat on the table. \param otherwise the default, for the help
/// text
void addWorldOption(CLI::App& command, std::optional<int>& frame, const std::string& otherwise);

/// The result for a window: one line per camera, then scale and output files, then warnings.
std::vector<std::string> resultLines(const Calibration& found, const CalibrationCommandOptions& options);
/// "0.21 mm RMS"
std::string describeScale(const Calibration& found);
/// "rig written to rig.toml, image of the rig to rig.png"
std::string describeOutput(const CalibrationCommandOptions& options);
/// `scale_error_mm`; null if it is unknown.
nlohmann::ordered_json scaleJson(const Calibration& found);

}  // namespace airclay
