// SPDX-License-Identifier: MIT
// The user's actions on a session: edits, files, recordings, and their replay.
#include "app/session/session.h"
#include "app/session/temporary_document.h"
#include "engine/clay/clay.h"
#include "engine/clay/refine.h"
#include "engine/clay/remesh.h"
#include "engine/core/error.h"
#include "engine/core/task.h"
#include "engine/mesh/cage_file.h"
#include "engine/mesh/mesh_export.h"

namespace airclay {
namespace {

/// A document's clay. Does not modify the file, which may be read-only.
ClayState stateIn(const std::filesystem::path& file) {
  const TemporaryDocument copy(file.filename());
  std::filesystem::copy_file(file, copy.file());
  return Document::open(copy.file()).state();
}

/// Whether both fit the same buffers.
bool sameStructure(const ClayState& a, const ClayState& b) {
  return a.rule == b.rule && a.levels == b.levels && a.solve == b.solve && a.cage.faces == b.cage.faces &&
         a.cage.points.size() == b.cage.points.size();
}

}  // namespace

/// Reports the task's progress to the window, and cancels it.
class Session::Working : public Task {
 public:
  Working(Session& session, const std::string& what) : session_(session) {
    session_.cancel_task_ = false;
    const std::lock_guard lock(session_.mutex_);
    session_.task_status_ = {what, 0, Clock::now()};
  }
  ~Working() override {
    const std::lock_guard lock(session_.mutex_);
    session_.task_status_ = {};
  }
  void onProgress(double share) override {
    if (session_.cancel_task_.exchange(false)) throw Cancelled{};
    const std::lock_guard lock(session_.mutex_);
    session_.task_status_.share = share;
  }

 private:
  Session& session_;
};

/// Runs an action that a recording logs and a replay repeats. `what` names a long task.
void Session::act(const Action& action, const std::string& what) {
  post([this, action, what] {
    refuseWhileReplaying();
    if (what.empty()) return perform(action);
    const Working working(*this, what);
    perform(action);
  });
}

void Session::undo() {
  act({.kind = Action::Kind::kUndo});
}

void Session::redo() {
  act({.kind = Action::Kind::kRedo});
}

void Session::refineClay() {
  act({.kind = Action::Kind::kRefine}, "refining");
}

void Session::remeshClay() {
  post([this] {
    refuseWhileReplaying();
    const Working working(*this, "remeshing");
    perform({.kind = Action::Kind::kRemesh, .faces = remeshFaces(document_.state())});
  });
}

void Session::setSurface(int levels, SubdivisionRule rule, const SolveMethod* solve) {
  act({.kind = Action::Kind::kSurface, .levels = levels, .rule = rule, .solve = solve}, "subdividing");
}

void Session::turn(const Vec3& axis, double angle_rad, bool last) {
  act({.kind = Action::Kind::kTurn, .axis = axis, .angle_rad = angle_rad, .last = last});
}

void Session::exportMesh(const std::filesystem::path& file, bool surface) {
  post([this, file, surface] {
    const Working working(*this, "exporting");
    const ClayState state = stateOf(document_, pipeline_.clay());
    const MeshExport written =
        airclay::exportMesh(file, meshAtLevel(state.cage, surface ? state.levels : 0, state.rule));
    note(file.filename().string() + ": " + std::to_string(written.faces) + " faces" +
         (written.watertight() ? ", watertight" : ", open: a slicer will not print it"));
  });
}

void Session::importCage(const std::filesystem::path& file) {
  post([this, file] {
    refuseWhileReplaying();
    const Working working(*this, "importing");
    ClayState state = document_.state();
    CageReadOptions options;
    options.units_option = "airclay set FILE.clay --clay " + file.filename().string() + " --units";
    CageReading reading = readCage(file, options);
    state.cage = std::move(reading.cage);
    state.workspace_from_clay.setIdentity();
    replaceClayWith(state, "Import " + file.filename().string());
    note("imported " + file.filename().string());
    for (const std::string& line : reading.notes()) note(file.filename().string() + ": " + line);
  });
}

void Session::replaceClay(const ClayState& state, const std::string& name) {
  post([this, state, name] {
    refuseWhileReplaying();
    replaceClayWith(state, name);
  });
}

void Session::saveAs(const std::filesystem::path& file) {
  post([this, file] {
    refuseWhileReplaying();
    endStroke();
    document_.saveAs(file);
    document_ = Document::open(file);
    note("saved as " + file.string());
  });
}

void Session::openDocument(const std::filesystem::path& file) {
  post([this, file] {
    refuseWhileReplaying();
    const Working working(*this, "opening");
    replaceDocumentWith(Document::open(file));
    note("opened " + file.string());
  });
}

void Session::restartTake() {
  if (reader_ && !isLive()) act({.kind = Action::Kind::kRestart});
}

void Session::relearnBackground() {
  if (isLive()) act({.kind = Action::Kind::kEmpty});
}

void Session::startRecording(const std::filesystem::path& folder) {
  post([this, folder] {
    refuseWhileReplaying();
    beginRecording(folder);
  });
}

void Session::stopRecording() {
  post([this] { endRecording(); });
}

// ------------------------------------------------------------------------------------------------ deeds

void Session::perform(const Action& action) {
  if (action.kind != Action::Kind::kTurn || !turning_) endStroke();
  switch (action.kind) {
    case Action::Kind::kEndStroke:
      return;  // done
    case Action::Kind::kUndo: {
      if (!document_.canUndo()) return note("nothing to undo");
      const std::string name = *document_.canUndo();
      document_.undo();
      show(document_.state());
      note("undone: " + name);
      break;
    }
    case Action::Kind::kRedo: {
      if (!document_.canRedo()) return note("nothing to redo");
      const std::string name = *document_.canRedo();
      document_.redo();
      show(document_.state());
      note("redone: " + name);
      break;
    }
    case Action::Kind::kRefine: {
      const ClayState refined = refine(document_.state());
      commit("Refine", refined);
      note("refined: " + std::to_string(refined.cage.points.size()) + " control points");
      break;
    }
    case Action::Kind::kRemesh: {
      const ClayState remeshed = remesh(document_.state(), action.faces);
      commit("Remesh", remeshed);
      note("remeshed: " + std::to_string(remeshed.cage.points.size()) + " control points");
      break;
    }
    case Action::Kind::kSurface:
      changeSurface(action);
      break;
    case Action::Kind::kTurn:
      turnClay(action);
      break;
    case Action::Kind::kRestart:
      if (reader_ && !options_.replay) reader_->restart();
      resetTracking();
      break;
    case Action::Kind::kEmpty:
      pipeline_.resetBackground();
      resetTracking();
      learned_.clear();
      learned_bytes_ = 0;
      learned_frames_ = 0;
      if (!options_.replay) still_to_learn_ = options_.recording->backgroundFrames();
      break;
    case Action::Kind::kClay:
    case Action::Kind::kDocument:
      throw std::logic_error("Session: clay from elsewhere comes with its file");
  }
  recordAction(action);
}

void Session::changeSurface(const Action& action) {
  ClayState state = document_.state();
  const bool other_level = action.levels != state.levels;
  state.levels = action.levels;
  state.rule = action.rule;
  state.solve = action.solve;
  commit(other_level ? "Level " + std::to_string(action.levels) : "Settings", state);
}

void Session::turnClay(const Action& action) {
  turning_ = !action.last;
  pipeline_.clay().rotate(Eigen::Quaterniond(Eigen::AngleAxisd(action.angle_rad, action.axis)));
  if (action.last) document_.commit("Turn", stateOf(document_, pipeline_.clay()));
}

void Session::resetTracking() {
  pipeline_.resetTracking();
  for (OneEuroPose& filter : pose_filters_) filter.reset();
  grip_ = Grip::kFree;
}

void Session::replaceClayWith(const ClayState& state, const std::string& name) {
  endStroke();
  commit(name, state);
  if (recorder_) recorder_->clay(state, name);
}

void Session::replaceDocumentWith(Document opened) {
  endStroke();
  std::unique_ptr<Pipeline::PreparedClay> clay = made(opened.state());
  document_ = std::move(opened);
  show(document_.state(), std::move(clay));
  if (recorder_) recorder_->document(document_);
}

/// One edit. If computing its clay fails or is cancelled, nothing changes.
void Session::commit(const std::string& name, const ClayState& state) {
  std::unique_ptr<Pipeline::PreparedClay> clay = made(state);
  document_.commit(name, state);
  show(document_.state(), std::move(clay));
}

/// The clay with another structure on the device; null if the same buffers hold it.
std::unique_ptr<Pipeline::PreparedClay> Session::made(const ClayState& state) {
  return sameStructure(state, clay_structure_) ? nullptr : pipeline_.prepareClay(state);
}

void Session::show(const ClayState& state) {
  show(state, made(state));
}

void Session::show(const ClayState& state, std::unique_ptr<Pipeline::PreparedClay> clay) {
  if (!clay) return pipeline_.clay().setControlPoints(state.cage.points, state.workspace_from_clay);
  const std::unique_lock lock(structure_);
  gpu_.waitIdle();  // the window may still draw the old clay
  pipeline_.setClay(std::move(clay));
  clay_structure_ = state;
  ++structure_serial_;
}

// ------------------------------------------------------------------------------------ recording, replaying

void Session::beginRecording(const std::filesystem::path& folder) {
  if (recorder_) throw Error("a recording is under way already, in " + recorder_->view().folder.string());
  Recording* const source = options_.recording;
  const bool learns = source && !source->hasBackground() && !source->hasSilhouettes();
  if (learns && learned_frames_ > static_cast<int>(learned_.size()))
    throw Error("the empty workspace was learned from " + std::to_string(learned_frames_) +
                " frames, more than are kept for a recording that starts later; use --record from the start");
  if (turning_) perform({.kind = Action::Kind::kTurn, .angle_rad = 0, .last = true});
  endStroke();
  const ActionsHeader head{learns ? source->backgroundFrames() : 0, options_.pipeline.voxels,
                           options_.hand_name, !source};
  recorder_.emplace(SessionRecorder::Start{folder, source, options_.rig, head, learned_}, document_);
  // Start as the replay will: without a hand pose, and with the clay from the file.
  resetTracking();
  pipeline_.clay().setControlPoints(document_.state().cage.points, document_.state().workspace_from_clay);
  note("recording into " + folder.string());
  showRecorder();
}

void Session::endRecording() {
  if (!recorder_) return;
  endStroke();
  const RecorderView view = recorder_->view();
  try {
    recorder_->end();
  } catch (...) {
    recorder_.reset();
    showRecorder();
    throw;
  }
  recorder_.reset();
  showRecorder();
  note("recorded " + std::to_string(view.frames) + " frames in " + view.folder.string());
}

void Session::showRecorder() {
  const RecorderView view = recorder_ ? recorder_->view() : RecorderView();
  const std::lock_guard lock(mutex_);
  recorder_view_ = view;
}

void Session::recordAction(const Action& action) {
  if (recorder_) recorder_->action(action);
}

void Session::recordFrame(const ReplayFrame& done, const FrameSet* set) {
  if (!recorder_) return;
  try {
    recorder_->frame(done, set);
  } catch (const Error&) {
    recorder_.reset();  // keeps what is written so far, as after a power failure
    showRecorder();
    throw;
  }
  showRecorder();
}

void Session::refuseWhileReplaying() const {
  if (options_.replay && !snapshot().ended)
    throw Error("the recording is doing this by itself; wait for its end");
}

/// The recorded step of this frame, after running the actions since the last frame. Null without a replay.
const ReplayFrame* Session::replayedFrame(int frame) {
  if (!options_.replay) return nullptr;
  const Actions::Step& step = options_.replay->actions.steps.at(std::size_t(frame));
  for (const Action& action : step.before) replayAction(action);
  return &step.frame;
}

void Session::replayAction(const Action& action) {
  const std::filesystem::path file = options_.replay->folder / action.file;
  if (action.kind == Action::Kind::kClay) {
    replaceClayWith(stateIn(file), action.name);
  } else if (action.kind == Action::Kind::kDocument) {
    // A copy next to the current document: the recording itself is not modified.
    const std::filesystem::path copy =
        document_.file().parent_path() / (document_.file().stem().string() + "-" + action.file);
    std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
    replaceDocumentWith(Document::open(copy));
  } else {
    perform(action);
  }
  refreshDocumentView();
}

}  // namespace airclay
