// SPDX-License-Identifier: MIT
// `airclay recalibrate`: corrects a rig whose cameras were moved, from a short recording of a moving board.
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/progress.h"
#include "app/commands/calibration_options.h"
#include "capture/calibration/recalibration.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

struct RecalibrateOptions : CalibrationCommandOptions {
  std::string rig;
  RecalibrationOptions recalibration;
};

/// Adds the warnings and writes the rig.
void save(const RecalibrateOptions& options, const Board& board, Recalibration& found,
          const std::vector<std::string>& warnings) {
  Calibration& calibration = found.calibration;
  calibration.warnings.insert(calibration.warnings.begin(), warnings.begin(), warnings.end());
  options.write(calibration, board,
                "--world N, a frame in which the board is flat on the table, puts the workspace on it");
}

/// \throw Error naming the recording, and the camera.
Recalibration recalibrateRecording(const RecalibrateOptions& options, const Rig& rig, const Board& board,
                                   std::vector<std::string>& warnings) {
  BoardRecording recording(options.take);
  try {
    checkSameCameras(rig, recording.cameras());  // before the slow search
    const std::vector<CameraViews> views = options.findBoards(recording, board, warnings);
    const ProgressTask progress("recalibrating", options.printsMessages());
    Recalibration found = recalibrate(board, rig, views, options.recalibration);
    save(options, board, found, warnings);
    return found;
  } catch (const Error& error) {
    const std::string message = error.what();
    throw Error(message.starts_with(options.take) ? message : options.take + ": " + message, error.fault());
  }
}

Recalibration recalibrateLive(const RecalibrateOptions& options, const Rig& rig, const Board& board,
                              const std::vector<std::string>& warnings) {
  if (options.recalibration.world_frame)
    throw Error(
        "--world does not apply to --camera; press W in the window while the board is flat on the table",
        Fault::kUsage);
  const std::vector<NamedSource> sources = inOrderOf(rig, options.cameras.sources());
  LiveCameras cameras(options.cameras.live(sources), options.cameras.liveOptions(LiveOptions::Sets::kNewest));
  checkSizes(rig, cameras);
  Recalibration found;
  options.collectLive(cameras, board, [&](const std::vector<CameraViews>& views, std::optional<int> world) {
    RecalibrationOptions recalibration = options.recalibration;
    recalibration.world_frame = world;
    found = recalibrate(board, rig, views, recalibration);
    save(options, board, found, warnings);
    return resultLines(found.calibration, options);
  });
  return found;
}

std::string names(const Recalibration& found, bool moved) {
  std::string list;
  for (std::size_t i = 0; i < found.changes.size(); ++i)
    if (found.changes[i].moved == moved)
      list += (list.empty() ? "" : ", ") + found.calibration.rig.cameras[i].name;
  return list;
}

/// Describes which cameras moved and where the world is.
std::string describeWorld(const RecalibrateOptions& options, const Recalibration& found) {
  const std::string moved = names(found, true), still = names(found, false);
  const std::string what = !found.world_kept ? "no two cameras have the same relative pose as before"
                           : moved.empty()   ? "no camera was moved"
                                             : "moved: " + moved;
  if (options.recalibration.world_frame)
    return what + "; the world origin is the board in frame " + std::to_string(found.calibration.world_frame);
  return what + (found.world_kept ? "; the world is unchanged, defined by " + still
                                  : "; the previous world is unknown");
}

void print(const RecalibrateOptions& options, const Recalibration& found) {
  const Calibration& calibration = found.calibration;
  std::vector<std::vector<std::string>> rows = {
      {"camera", "moved", "rotated", "views", "shared", "rms px before", "rms px"}};
  for (std::size_t i = 0; i < found.changes.size(); ++i) {
    const CameraChange& change = found.changes[i];
    const CameraQuality& quality = calibration.cameras[i];
    rows.push_back(
        {calibration.rig.cameras[i].name, change.moved ? fixed(change.moved_mm, 1) + " mm" : "unchanged",
         change.moved ? fixed(change.turned_deg, 2) + " deg" : "", std::to_string(quality.views),
         std::to_string(quality.shared_views), fixed(change.rms_px_before, 2), fixed(quality.rms_px, 2)});
  }
  if (options.printsMessages()) printTable(rows);
  printLine(options, describeWorld(options, found));
  printLine(options, "reprojection error " + fixed(calibration.rms_px, 2) + " px RMS, " +
                         fixed(found.rms_px_before, 2) +
                         " px with the old rig; error of lengths on the board " + describeScale(calibration));
  printLine(options, describeOutput(options));
}

nlohmann::ordered_json jsonOf(const Recalibration& found) {
  const Calibration& calibration = found.calibration;
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < found.changes.size(); ++i) {
    const CameraChange& change = found.changes[i];
    const CameraQuality& quality = calibration.cameras[i];
    cameras.push_back({{"name", calibration.rig.cameras[i].name},
                       {"moved_mm", change.moved_mm},
                       {"turned_deg", change.turned_deg},
                       {"moved", change.moved},
                       {"views", quality.views},
                       {"shared_views", quality.shared_views},
                       {"rms_px", quality.rms_px},
                       {"rms_px_before", change.rms_px_before}});
  }
  return {{"rms_px", calibration.rms_px},
          {"rms_px_before", found.rms_px_before},
          {"scale_error_mm", scaleJson(calibration)},
          {"world_kept", found.world_kept},
          {"cameras", cameras},
          {"warnings", calibration.warnings}};
}

void runRecalibrate(RecalibrateOptions options) {
  options.check();
  options.search.also = options.recalibration.world_frame;
  std::vector<std::string> warnings;
  const Board board = options.measuredBoard(warnings);
  const Rig rig = readRig(options.rig);
  const Recalibration found = options.live() ? recalibrateLive(options, rig, board, warnings)
                                             : recalibrateRecording(options, rig, board, warnings);
  if (options.json) printJson(jsonOf(found));
  print(options, found);
  if (!options.json)
    for (const std::string& warning : found.calibration.warnings) printWarning(warning);
}

}  // namespace

void addRecalibrate(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("recalibrate", "correct a rig whose cameras were moved, with a moving board");
  const auto options = std::make_shared<RecalibrateOptions>();
  options->required = RequiredViews::forPoses();
  command
      ->add_option("RIG", options->rig,
                   "existing rig; its lenses stay, and the cameras that did not move define the world")
      ->type_name("")
      ->required();
  addCalibrationOptions(*command, *options);
  addWorldOption(*command, options->recalibration.world_frame, "the rig's");
  command->footer(
      "Ten seconds are enough. Hold the board still a few times where two cameras see it.\n\nExample:\n  "
      "airclay recalibrate rig.toml recording --out rig2.toml");
  command->callback([options] { runRecalibrate(*options); });
}

}  // namespace airclay
