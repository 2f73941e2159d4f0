// SPDX-License-Identifier: MIT
// `airclay sculpt` and `airclay demo`: the main job, from a recording or from the built-in cameras and hand.
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <ctime>
#include <memory>

#include "app/cli/camera_options.h"
#include "app/cli/clay_options.h"
#include "app/cli/output_paths.h"
#include "app/commands/sculpting.h"
#include "app/session/take_options.h"
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
  ClayOptions words;
  std::string hand = "right", fit = "paper", clay = "tube", out = "out/sculpt", video;
  std::optional<Vec3> place;  ///< world, metres
  double size_m = 0;          ///< 0: as it comes
  std::string rig, save, log, tool, symmetry;
  CameraOptions cameras;
  std::string record;
  bool headless = false, unsteady = false, afresh = false;
  std::vector<std::string> given;  ///< words on the command line that a replay has no use for
};

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
    printWarning(
        "the clay reaches outside the workspace, where no hand is seen; --place and --size put it inside");
  return cage;
}

SculptControls controlsFrom(const SculptOptions& options) {
  SculptControls controls;
  try {
    if (!options.tool.empty()) controls.tool = parseTool(options.tool);
  } catch (const Error& error) {
    throw Error("--tool " + printable(options.tool) + ": " + error.what(), Fault::kUsage);
  }
  for (const char axis : options.symmetry) {
    if (axis != 'x' && axis != 'y' && axis != 'z')
      throw Error("--symmetry " + printable(options.symmetry) +
                      " is none; x, y, z or several of them would be right: xy",
                  Fault::kUsage);
    (axis == 'x' ? controls.symmetry.x : axis == 'y' ? controls.symmetry.y : controls.symmetry.z) = true;
  }
  return controls;
}

ClayState clayAtStart(const SculptOptions& options, const Workspace& workspace) {
  return {placedCage(options, workspace), options.words.subdivisionRule(), options.words.levels,
          options.words.solveMethod()};
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
  const ClayState state = clayAtStart(options, workspace);
  if (!options.save.empty()) return Document::create(options.save, state, "New " + options.clay);
  makeFolder(stateFolder());
  return Document::create(unsavedFile(), state, "New " + options.clay);
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
    printLine(options, "the clay is kept in " + file.string());
}

/// A document that is gone at the end: without a window nobody goes on with it.
class PassingDocument {
 public:
  PassingDocument()
      : file_(std::filesystem::temp_directory_path() / ("airclay-" + std::to_string(::getpid()) + ".clay")) {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }
  ~PassingDocument() {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
};

/// All that window and headless runs have in common.
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
  job.session.voxels = options.voxels;
  job.session.hand_name = options.hand;
  job.session.record = options.record;
  return job;
}

void sculptWithout(Gpu& gpu, Job& job, const SculptOptions& options, Document document) {
  makeFolder(options.out);
  job.sculpting.clay = document.state();
  job.session.settings.filtered = !options.unsteady;
  sculptHeadless(gpu, job.session, job.sculpting, controlsFrom(options), std::move(document), options);
}

void sculptRecording(Gpu& gpu, const SculptOptions& options, Recording& recording) {
  const Workspace& workspace = recording.rig().workspace;
  Job job = jobFor(options, &recording, recording.rig());
  if (wantsWindow(options)) {
    sculptInWindow(gpu, job.session, options, {.forearm = job.sculpting.forearm, .log = options.log});
    return;
  }
  const PassingDocument passing;
  sculptWithout(gpu, job, options,
                namesDocument(options) ? documentFrom(options, workspace)
                                       : Document::create(passing.file(), clayAtStart(options, workspace)));
}

void sculptTake(const SculptOptions& options) {
  Take take = options.take.open();
  controlsFrom(options);  // refused before anything is opened
  CommandGpu gpu(options);
  sculptRecording(gpu, options, take);
}

/// With cameras that run.
void sculptLive(const SculptOptions& options) {
  if (!options.take.folder.empty())
    throw Error("a recording and live cameras cannot be had at once; one of TAKE and --rig would be right",
                Fault::kUsage);
  if (options.rig.empty())
    throw Error("live cameras want their calibration: --rig RIG.toml would be right", Fault::kUsage);
  controlsFrom(options);  // refused before anything is opened
  const Rig rig = readRig(options.rig, parseUnits(options.take.units));
  CameraOptions words = options.cameras;
  words.usual_size = ImageSize{rig.cameras[0].width, rig.cameras[0].height};
  CommandGpu gpu(options);  // takes half a second, in which cameras would run for nobody
  LiveRecording recording(rig, words.live(inOrderOf(rig, words.sources())),
                          words.liveOptions(LiveOptions::Sets::kNewest), options.take.background_frames);
  printLine(options, "keep hand and arm away until the empty workspace is learned");
  sculptRecording(gpu, options, recording);
}

/// Without cameras: mouse and keys move a hand.
void sculptByMouse(const SculptOptions& options) {
  if (!wantsWindow(options))
    throw Error(
        "say which recording: airclay sculpt TAKE; without one, the studio wants a display for its window",
        Fault::kUsage);
  const Job job = jobFor(options, nullptr, demoRig());
  CommandGpu gpu(options);
  sculptInWindow(gpu, job.session, options, {.forearm = job.sculpting.forearm, .log = options.log});
}

/// The clay at the start of a recording, in a document of its own.
Document replayDocument(const SculptOptions& options, const std::filesystem::path& file) {
  if (std::filesystem::exists(file))
    throw Error(file.string() +
                ": there is a document already; a new name for what the recording makes would be right");
  std::error_code fault;
  std::filesystem::copy_file(std::filesystem::path(options.take.folder) / kStartFile, file, fault);
  if (fault)
    throw Error(options.take.folder + "/" + kStartFile + ": the clay at the start cannot be copied to " +
                file.string() + ": " + fault.message());
  std::filesystem::permissions(file, std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
  return Document::open(file);
}

/// What was recorded, once more: frames, wishes, clay.
void replay(SculptOptions options) {
  if (!options.given.empty())
    throw Error(options.given.front() +
                    " has no place in a replay, which knows it all; --afresh plays the images alone",
                Fault::kUsage);
  const std::filesystem::path folder = options.take.folder;
  const Replay replay{folder, readActions(folder / kActionsFile)};
  const ActionsHeader& head = replay.actions.head;
  if (!replay.actions.ended)
    printWarning(folder.string() + ": the recording broke off; it is played as far as it goes");
  options.voxels = head.voxels;
  const bool built_in = head.hand == "right" || head.hand == "left";
  options.hand = built_in ? head.hand : (folder / head.hand).string();
  options.take.background_frames = std::max(1, head.background_frames);
  std::optional<Take> take;
  if (!head.by_mouse) {
    TakeOptions excerpt;
    excerpt.most_frames = static_cast<int>(replay.actions.steps.size());
    take.emplace(options.take.open(excerpt));
  }
  Job job = jobFor(options, take ? &*take : nullptr, take ? take->rig() : readRig(folder / "rig.toml"));
  job.session.replay = &replay;
  CommandGpu gpu(options);
  if (wantsWindow(options)) {
    makeFolder(stateFolder());
    const std::filesystem::path file = options.save.empty() ? unsavedFile().string() : options.save;
    runStudio(gpu, job.session, replayDocument(options, file),
              {.forearm = job.sculpting.forearm, .log = options.log});
    printLine(options, "the clay is kept in " + file.string());
    return;
  }
  const PassingDocument passing;
  sculptWithout(gpu, job, options,
                replayDocument(options, options.save.empty() ? passing.file().string() : options.save));
}

void runSculpt(const SculptOptions& options) {
  if (!options.rig.empty() || options.cameras.given()) return sculptLive(options);
  checkFit(options.fit);
  checkVoxels(options.voxels);
  if (options.take.folder.empty())
    sculptByMouse(options);
  else if (hasActions(options.take.folder) && !options.afresh)
    replay(options);
  else
    sculptTake(options);
}

/// The same job with the window looking on: it closes at the end.
void demoInWindow(Gpu& gpu, const Job& job, const SculptOptions& options) {
  std::optional<SculptResults> results;
  Session::Options session = job.session;
  session.on_frame = [&](const Pipeline& pipeline, const PlayedFrame* frame) {
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
  const PassingDocument passing;
  if (wantsWindow(options))
    demoInWindow(gpu, job, options);
  else
    sculptWithout(gpu, job, options, Document::create(passing.file(), job.sculpting.clay));
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
          "--place", [options](const std::string& text) { options->place = parsePoint("--place", text); },
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
  command
      ->add_option("--tool", options->tool,
                   "without a window: " + toolUsage() + " [" + tools().front()->id + "]")
      ->type_name("TOOL");
  command->add_option("--symmetry", options->symmetry, "without a window: planes that are mirrored, as xy")
      ->type_name("AXES");
  command->add_flag("--unsteady", options->unsteady,
                    "without a window: the hand as it is measured, without the filter");
  command
      ->add_option("--record", options->record,
                   "a new folder: the sets of images that are used, and all that is done, to be played again")
      ->type_name("DIR");
  command->add_flag("--afresh", options->afresh,
                    "of such a recording, the images alone, without what was done at the time");
  addLog(*command, *options);
  addOut(*command, *options);
  command->add_option("--video", options->video, "a video of it, too")->type_name("FILE.mp4");
  command->add_option("--rig", options->rig, "live: the cameras' calibration")->type_name("RIG.toml");
  addCameraOptions(*command, options->cameras);
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, false);
  command->footer(
      "Examples:\n  airclay sculpt\n  airclay sculpt TAKE --clay vase --place 0,0,-0.05 --save vase.clay\n"
      "  airclay sculpt TAKE --clay cage.obj --size 0.25 --solve touched --out out/mine\n"
      "  airclay sculpt --rig rig.toml --camera left=0 --camera right=2\n"
      "  airclay sculpt TAKE --record mine; airclay sculpt mine --headless --out out/again");
  command->callback([options, command] {
    for (const char* word : {"--clay", "--place", "--size", "--levels", "--rule", "--solve", "--hand",
                             "--tool", "--symmetry", "--unsteady", "--voxels", "--background", "--record"})
      if (command->count(word) > 0) options->given.push_back(word);
    runSculpt(*options);
  });
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
      "errors are printed. Leaves surface.obj, cage.obj, poses.tum, images and demo.mp4.");
  command->callback([options] { runDemo(*options); });
}

}  // namespace airclay
