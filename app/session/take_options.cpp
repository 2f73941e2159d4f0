// SPDX-License-Identifier: MIT
#include "app/session/take_options.h"

#include <CLI/CLI.hpp>

#include "app/cli/camera_options.h"
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
  addTakeReadingOptions(command, options);
}

void addTakeReadingOptions(CLI::App& command, TakeInputOptions& options) {
  command.add_option("--units", options.units, "unit of a rig file that states none: m or mm")
      ->check(CLI::IsMember({"m", "mm"}).description(""))
      ->type_name("m|mm");
  command
      .add_option(
          "--background", options.background_frames,
          "number of frames at the start that show the empty workspace, 1 to 256; ignored if the take "
          "has a folder background/ [10]")
      ->check(CLI::Range(1, static_cast<int>(kMaxLearnFrames)).description(""))
      ->type_name("N");
  addOffsetOption(command, options.offsets);
}

TakeOptions TakeInputOptions::takeOptions() const {
  TakeOptions options;
  options.units = parseUnits(units);
  options.background_frames = background_frames;
  options.unfinished = hasActions(folder);
  for (const std::string& text : offsets) {
    const auto [name, offset_s] = parseOffset(text);
    options.offsets_s[name] = offset_s;
  }
  return options;
}

Take TakeInputOptions::open(int max_frames) const {
  TakeOptions whole = takeOptions();
  whole.max_frames = max_frames;
  Take take(folder, whole);
  if (take.note()) printWarning(*take.note());
  return take;
}

}  // namespace airclay
