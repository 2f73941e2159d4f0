// SPDX-License-Identifier: MIT
// `airclay sculpt` and `airclay demo`: the main job, from a recording or from the built-in cameras and hand.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/clay_words.h"
#include "app/outputs.h"
#include "app/player.h"
#include "app/sculpting.h"
#include "capture/synthetic.h"
#include "engine/error.h"
#include "engine/mesh_file.h"
#include "engine/presets.h"

namespace airclay {
namespace {

struct SculptOptions : CommonOptions {
  TakeWords take;
  ClayWords words;
  std::string hand = "right", fit = "paper", clay = "tube", out = "out/sculpt", video;
  std::optional<Vec3> place;  ///< world, metres
  double size_m = 0;          ///< 0: as it comes
  std::string rig, save;
  std::vector<std::string> cameras;
  bool headless = false;
};

Vec3 placeFrom(const std::string& text) {
  std::vector<double> values;
  std::size_t start = 0;
  while (start <= text.size()) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    const std::optional<double> value = parseNumber(std::string_view(text).substr(start, end - start));
    if (!value) break;
    values.push_back(*value);
    start = end + 1;
  }
  if (values.size() != 3 || start <= text.size())
    throw Error(
        "--place " + printable(text) + " is no place; X,Y,Z in metres would be right: --place 0,0,0.05",
        Fault::kUsage);
  return {values[0], values[1], values[2]};
}

/// The cage where and as large as it is wanted: --place moves the middle of its bounds, --size is their
/// longest side. A preset without a place stands in the workspace's centre, a file where its coordinates say.
PolygonMesh placedCage(const SculptOptions& options, const Workspace& workspace) {
  PolygonMesh cage = loadCage(options.clay);
  Eigen::AlignedBox3d bounds;
  for (const Vec3& point : cage.points) bounds.extend(point);
  const std::vector<std::string>& presets = presetNames();
  const bool is_preset = std::find(presets.begin(), presets.end(), options.clay) != presets.end();
  Vec3 center = bounds.center();
  if (is_preset) center += workspace.center;
  if (options.place) center = *options.place;
  const double scale = options.size_m > 0 ? options.size_m / bounds.sizes().maxCoeff() : 1;
  const Vec3 half = Vec3::Constant(workspace.edge_m / 2);
  const Eigen::AlignedBox3d cube(workspace.center - half, workspace.center + half);
  bool inside = true;
  for (Vec3& point : cage.points) {
    point = center + scale * (point - bounds.center());
    inside = inside && cube.contains(point);
  }
  if (!inside)
    warn("the clay reaches outside the workspace, where no hand is seen; --place and --size put it inside");
  return cage;
}

ClayOptions clayOptions(const SculptOptions& options, const Workspace& workspace) {
  return {placedCage(options, workspace), options.words.subdivisionRule(), options.words.levels,
          options.words.solveRows()};
}

void refuseWhatComesLater(const SculptOptions& options) {
  if (!options.rig.empty() || !options.cameras.empty())
    throw Error(
        "live cameras (--rig, --camera) do not exist yet; a recording would be right: airclay sculpt TAKE",
        Fault::kUsage);
  if (!options.save.empty())
    throw Error("--save does not exist yet; cage.obj in --out holds the result", Fault::kUsage);
  if (options.clay.ends_with(".clay"))
    throw Error(
        "--clay " + options.clay + ": documents cannot be opened yet; a preset or an OBJ would be right",
        Fault::kUsage);
  if (options.take.folder.empty())
    throw Error("say which recording: airclay sculpt TAKE; `airclay sculpt --help` says more", Fault::kUsage);
}

void runSculpt(const SculptOptions& options) {
  refuseWhatComesLater(options);
  checkFit(options.fit);
  checkVoxels(options.voxels);
  Take take = options.take.open();
  Sculpting sculpting;
  sculpting.hand = loadHand(options.hand);
  if (options.hand == "right" || options.hand == "left")
    sculpting.forearm = builtInForearm(options.hand == "left");
  sculpting.clay = clayOptions(options, take.rig().workspace);
  makeFolder(options.out);
  sculpting.out = options.out;
  if (!options.video.empty()) {
    checkWritable(options.video);
    sculpting.video = options.video;
  }
  CommandGpu gpu(options);
  sculpt(gpu, take, sculpting, options);
}

void runDemo(const SculptOptions& options) {
  checkVoxels(options.voxels);
  makeFolder(options.out);
  CommandGpu gpu(options);
  Synthetic recording(gpu);
  Sculpting sculpting;
  sculpting.hand = builtInHand(false);
  sculpting.forearm = builtInForearm(false);
  sculpting.clay = clayOptions(options, recording.rig().workspace);
  sculpting.out = options.out;
  sculpting.video = sculpting.out / "demo.mp4";
  sculpt(gpu, recording, sculpting, options);
}

void addOut(CLI::App& command, SculptOptions& options) {
  command.add_option("--out", options.out, "the folder that the results go to [" + options.out + "]")
      ->type_name("DIR");
}

}  // namespace

void addSculpt(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("sculpt", "sculpt clay with the hand of a recording");
  const auto options = std::make_shared<SculptOptions>();
  addTakeOptions(*command, options->take);
  command->get_option("TAKE")->required(false);  // refuseWhatComesLater() says it better
  command
      ->add_option("--clay", options->clay,
                   "a preset: tube [this], cube, ball, slab, vase; or a cage in an OBJ")
      ->type_name("PRESET|FILE");
  command
      ->add_option_function<std::string>(
          "--place", [options](const std::string& text) { options->place = placeFrom(text); },
          "where the clay's middle stands: world, metres")
      ->type_name("X,Y,Z");
  command->add_option("--size", options->size_m, "the clay's longest side in metres")
      ->check(CLI::Range(1e-4, 1e4).description(""))
      ->type_name("M");
  addSubdivisionOptions(*command, options->words);
  addSolveOption(*command, options->words);
  addHandOption(*command, options->hand);
  addFitOption(*command, options->fit);
  command->add_flag("--headless", options->headless, "open no window");
  addOut(*command, *options);
  command->add_option("--video", options->video, "a video of it, too")->type_name("FILE.mp4");
  command->add_option("--rig", options->rig)->group("");
  command->add_option("--camera", options->cameras)->group("");
  command->add_option("--save", options->save)->group("");
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "Examples:\n  airclay sculpt TAKE --clay vase --place 0,0,-0.05\n"
      "  airclay sculpt TAKE --clay cage.obj --size 0.25 --solve touched --out out/mine");
  command->callback([options] { runSculpt(*options); });
}

void addDemo(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("demo", "sculpt with the built-in cameras and hand: nothing else is needed");
  const auto options = std::make_shared<SculptOptions>();
  options->out = "out/demo";
  addOut(*command, *options);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "A scripted hand before synthetic cameras presses the paper's clay; its true poses are known, so "
      "the\n"
      "errors are printed. Leaves surface.obj, cage.obj, poses.tum, pictures and demo.mp4.");
  command->callback([options] { runDemo(*options); });
}

}  // namespace airclay
