// SPDX-License-Identifier: MIT
#include "app/session/take_options.h"

#include <CLI/CLI.hpp>

#include "app/cli/command.h"
#include "app/session/actions.h"
#include "engine/silhouette/silhouette.h"

namespace airclay {

RigUnits parseUnits(const std::string& text) {
  if (text == "m") return RigUnits::kMetres;
  return text == "mm" ? RigUnits::kMillimetres : RigUnits::kAsWritten;
}

void addTakeOptions(CLI::App& command, TakeInputOptions& options) {
  command.add_option("TAKE", options.folder, "recording: a folder with rig.toml and videos, images or masks")
      ->type_name("")
      ->required();
  command.add_option("--units", options.units, "unit of a rig file that states none: m or mm")
      ->check(CLI::IsMember({"m", "mm"}).description(""))
      ->type_name("m|mm");
  command
      .add_option("--background", options.background_frames,
                  "number of initial frames that show the empty workspace, 1 to 256, for a take without "
                  "background/ [10]")
      ->check(CLI::Range(1, static_cast<int>(kMaxLearnFrames)).description(""))
      ->type_name("N");
}

Take TakeInputOptions::open(const TakeOptions& options) const {
  TakeOptions whole = options;
  whole.units = parseUnits(units);
  whole.background_frames = background_frames;
  whole.unfinished = hasActions(folder);
  Take take(folder, whole);
  if (take.note()) printWarning(*take.note());
  return take;
}

}  // namespace airclay
