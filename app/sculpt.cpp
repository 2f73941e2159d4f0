// SPDX-License-Identifier: MIT
// `airclay sculpt` and `airclay demo`: the main job, from a recording or from the built-in cameras and hand.
#include <CLI/CLI.hpp>
#include <ctime>
#include <memory>

#include "app/clay_words.h"
#include "app/outputs.h"
#include "app/player.h"
#include "app/sculpting.h"
#include "app/studio/settings.h"
#include "app/studio/studio.h"
#include "app/studio/window.h"
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
  std::string rig, save, log, tool = "push", symmetry;
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
}

SculptControls controlsFrom(const SculptOptions& options) {
  SculptControls controls;
  controls.tool = options.tool == "pull"     ? Tool::kPull
                  : options.tool == "smooth" ? Tool::kSmooth
                                             : Tool::kPush;
  for (const char axis : options.symmetry) {
    if (axis != 'x' && axis != 'y' && axis != 'z')
      throw Error("--symmetry " + printable(options.symmetry) +
                      " is none; x, y, z or several of them would be right: xy",
                  Fault::kUsage);
    (axis == 'x' ? controls.symmetry.x : axis == 'y' ? controls.symmetry.y : controls.symmetry.z) = true;
  }
  return controls;
}

/// Where clay goes that was given no document: it is kept all the same.
std::filesystem::path unsavedFile() {
  const std::time_t now = std::time(nullptr);
  char name[64];
  std::strftime(name, sizeof name, "unsaved-%Y%m%d-%H%M%S", std::localtime(&now));
  std::filesystem::path file = stateFolder() / (std::string(name) + ".clay");
  for (int i = 2; std::filesystem::exists(file); ++i)
    file = stateFolder() / (name + std::string("-") + std::to_string(i) + ".clay");
  return file;
}

bool namesDocument(const SculptOptions& options) {
  return !options.save.empty() || options.clay.ends_with(".clay");
}

/// The document that --clay and --save mean; else one among the unsaved.
Document documentFrom(const SculptOptions& options, const Workspace& workspace) {
  if (options.clay.ends_with(".clay")) {
    if (options.place || options.size_m > 0)
      throw Error("--place and --size are for presets and OBJ files; a document knows where its clay is",
                  Fault::kUsage);
    Document opened = Document::open(options.clay);
    if (options.save.empty()) return opened;
    opened.saveAs(options.save);
    return Document::open(options.save);
  }
  const ClayState state{placedCage(options, workspace), options.words.subdivisionRule(), options.words.levels,
                        options.words.solveRows()};
  if (!options.save.empty()) return Document::create(options.save, state, "New " + options.clay);
  makeFolder(stateFolder());
  return Document::create(unsavedFile(), state, "New " + options.clay);
}

ClayOptions clayOf(const ClayState& state) {
  return {state.cage, state.rule, state.levels, state.solve};
}

bool wantsWindow(const SculptOptions& options) {
  return !options.headless && Window::possible();
}

/// Runs the studio; unsaved clay that nobody touched leaves nothing behind.
void sculptInWindow(Gpu& gpu, const Session::Options& session, const SculptOptions& options,
                    const StudioOptions& studio) {
  Document document = documentFrom(options, session.rig.workspace);
  const std::filesystem::path file = document.file();
  runStudio(gpu, session, std::move(document), studio);
  if (namesDocument(options)) return;
  if (Document::open(file).history().size() == 1)
    std::filesystem::remove(file);
  else
    say(options, "the clay is kept in " + file.string());
}

void sculptTake(const SculptOptions& options) {
  Take take = options.take.open();
  Sculpting sculpting;
  sculpting.hand = loadHand(options.hand);
  sculpting.controls = controlsFrom(options);
  if (options.hand == "right" || options.hand == "left")
    sculpting.forearm = builtInForearm(options.hand == "left");
  if (!options.video.empty()) {
    checkWritable(options.video);
    sculpting.video = options.video;
  }
  sculpting.out = options.out;
  CommandGpu gpu(options);
  if (wantsWindow(options)) {
    Session::Options session{&take, take.rig(), sculpting.hand, options.voxels, {}, {}};
    sculptInWindow(gpu, session, options, {.forearm = sculpting.forearm, .log = options.log});
    return;
  }
  std::optional<Document> document;
  if (namesDocument(options)) document = documentFrom(options, take.rig().workspace);
  sculpting.clay = document ? clayOf(document->state()) : clayOptions(options, take.rig().workspace);
  makeFolder(options.out);
  sculptHeadless(gpu, take, sculpting, document ? &*document : nullptr, options);
}

/// Without cameras: mouse and keys move a hand.
void sculptByMouse(const SculptOptions& options) {
  if (!wantsWindow(options))
    throw Error(
        "say which recording: airclay sculpt TAKE; without one, the studio wants a display for its window",
        Fault::kUsage);
  Session::Options session{nullptr, demoRig(), loadHand(options.hand), options.voxels, {}, {}};
  StudioOptions studio{.log = options.log};
  if (options.hand == "right" || options.hand == "left")
    studio.forearm = builtInForearm(options.hand == "left");
  CommandGpu gpu(options);
  sculptInWindow(gpu, session, options, studio);
}

void runSculpt(const SculptOptions& options) {
  refuseWhatComesLater(options);
  checkFit(options.fit);
  checkVoxels(options.voxels);
  if (options.take.folder.empty())
    sculptByMouse(options);
  else
    sculptTake(options);
}

/// The same job with the window looking on: it closes at the end.
void demoInWindow(Gpu& gpu, Recording& recording, const Sculpting& sculpting, const SculptOptions& options) {
  std::optional<SculptResults> results;
  Session::Options session{&recording, recording.rig(), sculpting.hand, options.voxels, {}, {}};
  session.on_frame = [&](const Pipeline& pipeline, const PlayedFrame* frame) {
    if (!results) results.emplace(gpu, pipeline, recording, sculpting);
    if (frame)
      results->add(*frame);
    else
      results->finish(options);
  };
  sculptInWindow(
      gpu, session, options,
      {.title = "Airclay: the demo", .forearm = sculpting.forearm, .close_at_end = true, .log = options.log});
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
  if (wantsWindow(options))
    demoInWindow(gpu, recording, sculpting, options);
  else
    sculptHeadless(gpu, recording, sculpting, nullptr, options);
}

void addOut(CLI::App& command, SculptOptions& options) {
  command.add_option("--out", options.out, "the folder that the results go to [" + options.out + "]")
      ->type_name("DIR");
}

void addLog(CLI::App& command, SculptOptions& options) {
  command.add_option("--log", options.log, "a line of JSON a second with what the window's status shows")
      ->type_name("FILE");
}

}  // namespace

void addSculpt(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "sculpt", "sculpt clay in the studio's window, with the hand of a recording or of the mouse");
  const auto options = std::make_shared<SculptOptions>();
  addTakeOptions(*command, options->take);
  command->get_option("TAKE")->required(false);  // the mouse's hand
  command
      ->add_option(
          "--clay", options->clay,
          "a preset: tube [this], cube, ball, slab, vase; a cage in an OBJ; or a document, FILE.clay")
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
  command->add_flag("--headless", options->headless, "open no window, though there be a display");
  command->add_option("--save", options->save, "the document that every stroke is kept in")
      ->type_name("FILE.clay");
  command->add_option("--tool", options->tool, "without a window: push [this], pull or smooth")
      ->check(CLI::IsMember({"push", "pull", "smooth"}).description(""))
      ->type_name("TOOL");
  command->add_option("--symmetry", options->symmetry, "without a window: planes that are mirrored, as xy")
      ->type_name("AXES");
  addLog(*command, *options);
  addOut(*command, *options);
  command->add_option("--video", options->video, "a video of it, too")->type_name("FILE.mp4");
  command->add_option("--rig", options->rig)->group("");
  command->add_option("--camera", options->cameras)->group("");
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "Examples:\n  airclay sculpt\n  airclay sculpt TAKE --clay vase --place 0,0,-0.05 --save vase.clay\n"
      "  airclay sculpt TAKE --clay cage.obj --size 0.25 --solve touched --out out/mine");
  command->callback([options] { runSculpt(*options); });
}

void addDemo(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("demo", "sculpt with the built-in cameras and hand: nothing else is needed");
  const auto options = std::make_shared<SculptOptions>();
  options->out = "out/demo";
  addOut(*command, *options);
  command->add_flag("--headless", options->headless, "open no window, though there be a display");
  addLog(*command, *options);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "A scripted hand before synthetic cameras presses the paper's clay; its true poses are known, so "
      "the\n"
      "errors are printed. Leaves surface.obj, cage.obj, poses.tum, pictures and demo.mp4.");
  command->callback([options] { runDemo(*options); });
}

}  // namespace airclay
