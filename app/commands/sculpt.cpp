// SPDX-License-Identifier: MIT
// `airclay sculpt` and `airclay demo`: sculpt from a recording, live cameras, the mouse, or synthetic
// cameras.
#include <CLI/CLI.hpp>
#include <ctime>
#include <memory>
#include <utility>

#include "app/cli/cage_options.h"
#include "app/cli/camera_options.h"
#include "app/cli/clay_options.h"
#include "app/cli/output_paths.h"
#include "app/commands/sculpting.h"
#include "app/session/fit_options.h"
#include "app/session/take_options.h"
#include "app/session/temporary_document.h"
#include "app/studio/settings.h"
#include "app/studio/studio.h"
#include "app/studio/window.h"
#include "capture/cameras/live_recording.h"
#include "capture/takes/player.h"
#include "capture/takes/synthetic.h"
#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

struct SculptOptions : CommonOptions {
  TakeInputOptions take;
  CageOptions cage_options;
  ClayOptions clay_options;
  FitOptions fit;
  std::string hand = "right", clay = "tube", out = "out/sculpt", video;
  std::optional<Vec3> place;  ///< world, metres
  double size_m = 0;          ///< 0: unchanged
  std::string rig, save, tool, symmetry;
  StudioLog log;
  CameraOptions cameras;
  std::string record;
  bool headless = false, unfiltered = false, ignore_actions = false;
  std::vector<std::string> not_for_replay;  ///< given options that do not apply to a replay
};

/// The cage at its position and size: --place sets the center of its bounds, --size their longest side.
/// Without --place, a preset is at the workspace's center, and a file's coordinates are kept.
PolygonMesh placedCage(const SculptOptions& options, const Workspace& workspace) {
  const std::vector<std::string>& presets = presetNames();
  const bool is_preset = std::find(presets.begin(), presets.end(), options.clay) != presets.end();
  CageOptions cage_options = options.cage_options;
  if (!is_preset && options.size_m > 0 && cage_options.units.empty())
    cage_options.units = "m";  // any will do
  PolygonMesh cage = cage_options.load(options.clay);
  Eigen::AlignedBox3d bounds;
  for (const Vec3& point : cage.points) bounds.extend(point);
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
    printWarning(
        "the clay reaches outside the workspace, where no hand is tracked; --place and --size move it "
        "inside");
  return cage;
}

SculptControls controlsFrom(const SculptOptions& options) {
  SculptControls controls;
  if (!options.tool.empty()) controls.tool = parseTool(options.tool);
  for (const char axis : options.symmetry) {
    if (axis != 'x' && axis != 'y' && axis != 'z')
      throw Error("--symmetry " + printable(options.symmetry) +
                      " is not a set of axes; expected x, y, z or several of them, as xy",
                  Fault::kUsage);
    (axis == 'x' ? controls.symmetry.x : axis == 'y' ? controls.symmetry.y : controls.symmetry.z) = true;
  }
  return controls;
}

ClayState clayAtStart(const SculptOptions& options, const Workspace& workspace) {
  return {placedCage(options, workspace), options.clay_options.subdivisionRule(), options.clay_options.levels,
          options.clay_options.solveMethod()};
}

/// A new file for clay without a document.
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

/// The document of --clay or --save; otherwise a new unsaved one.
Document documentFrom(const SculptOptions& options, const Workspace& workspace) {
  if (options.clay.ends_with(".clay")) {
    if (options.place || options.size_m > 0)
      throw Error("--place and --size apply to presets and cages; a document stores the position of its clay",
                  Fault::kUsage);
    options.cage_options.refuse("a document is in metres");
    Document opened = Document::open(options.clay);
    if (options.save.empty()) return opened;
    opened.saveAs(options.save);
    return Document::open(options.save);
  }
  const ClayState state = clayAtStart(options, workspace);
  if (!options.save.empty()) return Document::create(options.save, state, "New " + options.clay);
  makeFolder(stateFolder());
  return Document::create(unsavedFile(), state, "New " + options.clay);
}

bool usesWindow(const SculptOptions& options) {
  return !options.headless && Window::possible();
}

/// Runs the studio. Removes an unsaved document without edits.
void sculptInWindow(Gpu& gpu, const Session::Options& session, const SculptOptions& options,
                    const StudioOptions& studio) {
  Document document = documentFrom(options, session.rig.workspace);
  const std::filesystem::path file = document.file();
  runStudio(gpu, session, std::move(document), studio);
  if (namesDocument(options)) return;
  if (Document::open(file).history().size() == 1)
    std::filesystem::remove(file);
  else
    printLine(options, "the clay is saved in " + file.string());
}

/// What runs with and without a window share.
struct Job {
  Session::Options session;
  Sculpting sculpting;
};

Job jobFor(const SculptOptions& options, Recording* recording, const Rig& rig) {
  Job job;
  job.sculpting.hand = loadHand(options.hand);
  if (options.hand == "right" || options.hand == "left")
    job.sculpting.forearm = builtInForearm(options.hand == "left");
  if (!options.video.empty()) {
    checkWritable(options.video);
    job.sculpting.video = options.video;
  }
  job.sculpting.out = options.out;
  job.session.recording = recording;
  job.session.rig = rig;
  job.session.hand = job.sculpting.hand;
  job.session.pipeline = options.fit.pipeline(options.voxels);
  job.session.hand_name = options.hand;
  job.session.record = options.record;
  return job;
}

void sculptWithoutWindow(Gpu& gpu, Job& job, const SculptOptions& options, Document document) {
  makeFolder(options.out);
  job.sculpting.clay = document.state();
  job.session.settings.filtered = !options.unfiltered;
  sculptHeadless(gpu, job.session, job.sculpting, controlsFrom(options), std::move(document), options);
}

void sculptRecording(Gpu& gpu, const SculptOptions& options, Recording& recording) {
  const Workspace& workspace = recording.rig().workspace;
  Job job = jobFor(options, &recording, recording.rig());
  if (usesWindow(options)) {
    sculptInWindow(gpu, job.session, options, {.forearm = job.sculpting.forearm, .log = options.log});
    return;
  }
  const TemporaryDocument temporary;
  sculptWithoutWindow(gpu, job, options,
                      namesDocument(options)
                          ? documentFrom(options, workspace)
                          : Document::create(temporary.file(), clayAtStart(options, workspace)));
}

void sculptTake(const SculptOptions& options) {
  Take take = options.take.open();
  controlsFrom(options);  // checks the options before anything opens
  CommandGpu gpu(options);
  sculptRecording(gpu, options, take);
}

/// With live cameras.
void sculptLive(const SculptOptions& options) {
  if (!options.take.folder.empty())
    throw Error("a recording and live cameras exclude each other; give either TAKE or --rig", Fault::kUsage);
  if (options.rig.empty()) throw Error("live cameras need a calibration; give --rig RIG.toml", Fault::kUsage);
  controlsFrom(options);  // checks the options before anything opens
  const Rig rig = readRig(options.rig, parseUnits(options.take.units));
  CameraOptions cameras = options.cameras;
  cameras.offsets = options.take.offsets;  // one option for cameras and takes
  cameras.usual_size = ImageSize{rig.cameras[0].width, rig.cameras[0].height};
  CommandGpu gpu(options);  // takes half a second; cameras must not run meanwhile
  LiveRecording recording(rig, cameras.live(inOrderOf(rig, cameras.sources())),
                          cameras.liveOptions(LiveOptions::Sets::kNewest), options.take.background_frames);
  printLine(options, "keep hand and arm out of the workspace until the background is learned");
  sculptRecording(gpu, options, recording);
}

/// Without cameras: mouse and keys move the hand.
void sculptByMouse(const SculptOptions& options) {
  if (!usesWindow(options) && options.clay.ends_with(".clay"))
    throw Error(
        "the studio needs a display; without a window, use airclay sculpt TAKE --clay " + options.clay,
        Fault::kUsage);
  if (!usesWindow(options))
    throw Error("no recording given: airclay sculpt TAKE; without one, the studio needs a display",
                Fault::kUsage);
  const Job job = jobFor(options, nullptr, demoRig());
  CommandGpu gpu(options);
  sculptInWindow(gpu, job.session, options, {.forearm = job.sculpting.forearm, .log = options.log});
}

/// A new document with the clay at the start of a recording.
Document replayDocument(const SculptOptions& options, const std::filesystem::path& file) {
  if (std::filesystem::exists(file))
    throw Error(file.string() +
                ": the document already exists; use another name for the result of the replay");
  std::error_code error;
  std::filesystem::copy_file(std::filesystem::path(options.take.folder) / kStartFile, file, error);
  if (error)
    throw Error(options.take.folder + "/" + kStartFile + ": the clay at the start cannot be copied to " +
                file.string() + ": " + error.message());
  std::filesystem::permissions(file, std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
  return Document::open(file);
}

/// Replays recorded frames and actions.
void replay(SculptOptions options) {
  if (!options.not_for_replay.empty())
    throw Error(options.not_for_replay.front() +
                    " does not apply to a replay; --ignore-actions plays only the images",
                Fault::kUsage);
  const std::filesystem::path folder = options.take.folder;
  const Replay replay{folder, readActions(folder / kActionsFile)};
  const ActionsHeader& head = replay.actions.head;
  if (!replay.actions.ended)
    printWarning(folder.string() + ": the recording is incomplete; the replay ends where it ends");
  options.voxels = head.voxels;
  const bool built_in = head.hand == "right" || head.hand == "left";
  options.hand = built_in ? head.hand : (folder / head.hand).string();
  options.take.background_frames = std::max(1, head.background_frames);
  std::optional<Take> take;
  if (!head.by_mouse) {
    take.emplace(options.take.open(static_cast<int>(replay.actions.steps.size())));
  }
  Job job = jobFor(options, take ? &*take : nullptr, take ? take->rig() : readRig(folder / "rig.toml"));
  job.session.replay = &replay;
  CommandGpu gpu(options);
  if (usesWindow(options)) {
    makeFolder(stateFolder());
    const std::filesystem::path file = options.save.empty() ? unsavedFile().string() : options.save;
    runStudio(gpu, job.session, replayDocument(options, file),
              {.forearm = job.sculpting.forearm, .log = options.log});
    printLine(options, "the clay is saved in " + file.string());
    return;
  }
  const TemporaryDocument temporary;
  sculptWithoutWindow(
      gpu, job, options,
      replayDocument(options, options.save.empty() ? temporary.file().string() : options.save));
}

/// TAKE may also be a document: `airclay sculpt FILE.clay` is `airclay sculpt --clay FILE.clay`.
void acceptDocumentAsTake(SculptOptions& options, bool clay_given) {
  if (!options.take.folder.ends_with(".clay") || std::filesystem::is_directory(options.take.folder)) return;
  if (clay_given)
    throw Error(options.take.folder + ": a document, and --clay " + options.clay +
                    " exclude each other; give one of them",
                Fault::kUsage);
  options.clay = std::exchange(options.take.folder, {});
}

void runSculpt(const SculptOptions& options) {
  if (!options.rig.empty() || options.cameras.given()) return sculptLive(options);
  checkVoxels(options.voxels);
  if (options.take.folder.empty())
    sculptByMouse(options);
  else if (hasActions(options.take.folder) && !options.ignore_actions)
    replay(options);
  else
    sculptTake(options);
}

/// Runs the demo in a window, which closes at the end.
void demoInWindow(Gpu& gpu, const Job& job, const SculptOptions& options) {
  std::optional<SculptResults> results;
  Session::Options session = job.session;
  session.on_frame = [&](Pipeline& pipeline, const PlayedFrame* frame) {
    if (!results) results.emplace(gpu, pipeline, session.recording, job.sculpting);
    if (frame) return results->add(*frame);
    results->finish(pipeline);
    results->printLine(options);
  };
  sculptInWindow(gpu, session, options,
                 {.title = "Airclay: the demo",
                  .forearm = job.sculpting.forearm,
                  .close_at_end = true,
                  .log = options.log});
}

void runDemo(const SculptOptions& options) {
  checkVoxels(options.voxels);
  makeFolder(options.out);
  CommandGpu gpu(options);
  Synthetic recording(gpu);
  Job job = jobFor(options, &recording, recording.rig());
  job.sculpting.video = job.sculpting.out / "demo.mp4";
  job.sculpting.clay = clayAtStart(options, recording.rig().workspace);
  const TemporaryDocument temporary;
  if (usesWindow(options))
    demoInWindow(gpu, job, options);
  else
    sculptWithoutWindow(gpu, job, options, Document::create(temporary.file(), job.sculpting.clay));
}

void addOut(CLI::App& command, SculptOptions& options) {
  command.add_option("--out", options.out, "folder for the results [" + options.out + "]")->type_name("DIR");
}

void addLog(CLI::App& command, SculptOptions& options) {
  command.add_option("--log", options.log.file, "write the window's status to FILE as JSON lines")
      ->type_name("FILE");
  command.add_option("--log-interval", options.log.interval_s, "seconds between the lines of --log [1]")
      ->check(CLI::Range(0.01, 3600.0).description(""))
      ->type_name("S");
}

}  // namespace

void addSculpt(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "sculpt", "sculpt clay in the studio, with a hand from a recording, live cameras or the mouse");
  const auto options = std::make_shared<SculptOptions>();
  addTakeOptions(*command, options->take);
  command->get_option("TAKE")->required(false);  // the mouse hand
  command
      ->add_option("--clay", options->clay,
                   "a preset: tube (default), cube, ball, slab or vase; a control cage (.obj, .ply, .stl, "
                   ".gltf, .glb); "
                   "or a document, FILE.clay")
      ->type_name("PRESET|FILE");
  options->cage_options.units_option = "--clay-units";  // --units is the rig's
  options->cage_options.up_option = "--clay-up";
  addCageOptions(*command, options->cage_options);
  command
      ->add_option_function<std::string>(
          "--place", [options](const std::string& text) { options->place = parsePoint("--place", text); },
          "centre of the clay in the world, metres")
      ->type_name("X,Y,Z");
  command->add_option("--size", options->size_m, "longest side of the clay, metres")
      ->check(CLI::Range(1e-4, 1e4).description(""))
      ->type_name("M");
  addSubdivisionOptions(*command, options->clay_options);
  addSolveOption(*command, options->clay_options);
  addHandOption(*command, options->hand);
  addFitOptions(*command, options->fit);
  command->add_flag("--headless", options->headless, "run without a window");
  command->add_option("--save", options->save, "document to save every stroke in")->type_name("FILE.clay");
  command
      ->add_option("--tool", options->tool,
                   "without a window, use this tool: " + toolUsage() + " [" + tools().front()->id + "]")
      ->check(CLI::Validator(
          [](const std::string& text) {
            try {
              parseTool(text);
              return std::string();
            } catch (const Error& error) {
              return std::string(error.what());
            }
          },
          ""))
      ->type_name("TOOL");
  command
      ->add_option("--symmetry", options->symmetry,
                   "without a window, mirror the hand's effect along these axes of the clay: x, y, z or "
                   "several, as xy")
      ->type_name("AXES");
  command->add_flag("--no-filter", options->unfiltered,
                    "without a window, use the measured hand pose without temporal filtering");
  command
      ->add_option("--record", options->record,
                   "record images and actions to a new folder; as TAKE, it is replayed")
      ->type_name("DIR");
  command->add_flag("--ignore-actions", options->ignore_actions,
                    "use only the images of a TAKE that --record wrote, not its actions");
  addDeprecatedName(*command, "--unsteady", "--no-filter");
  addDeprecatedName(*command, "--afresh", "--ignore-actions");
  addLog(*command, *options);
  addOut(*command, *options);
  command->add_option("--video", options->video, "also write a video")->type_name("FILE.mp4");
  command->add_option("--rig", options->rig, "rig of the live cameras")->type_name("RIG.toml");
  addCameraOptions(*command, options->cameras);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "Examples:\n  airclay sculpt\n  airclay sculpt vase.clay\n  airclay sculpt TAKE --clay vase --place "
      "0,0,-0.05 --save vase.clay\n"
      "  airclay sculpt TAKE --clay cage.obj --size 0.25 --solve touched --out out/mine\n"
      "  airclay sculpt --rig rig.toml --camera left=0 --camera right=2\n"
      "  airclay sculpt TAKE --record mine\n"
      "  airclay sculpt mine --headless --out out/again");
  command->callback([options, command] {
    for (const char* name : {"--clay", "--clay-units", "--clay-up", "--place", "--size", "--levels", "--rule",
                             "--solve", "--hand", "--tool", "--symmetry", "--no-filter", "--voxels",
                             "--background", "--offset", "--record"})
      if (command->count(name) > 0) options->not_for_replay.push_back(name);
    acceptDocumentAsTake(*options, command->count("--clay") > 0);
    runSculpt(*options);
  });
}

void addDemo(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "demo", "sculpt with synthetic cameras and a scripted hand; needs no other input");
  const auto options = std::make_shared<SculptOptions>();
  options->out = "out/demo";
  addOut(*command, *options);
  command->add_flag("--headless", options->headless, "run without a window");
  addLog(*command, *options);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "A scripted hand in front of synthetic cameras presses the paper's clay. Its true poses are known, so "
      "the\ncommand prints the tracking errors. Writes surface.obj, cage.obj, poses.tum, images and "
      "demo.mp4.");
  command->callback([options] { runDemo(*options); });
}

}  // namespace airclay
