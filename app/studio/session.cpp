// SPDX-License-Identifier: MIT
#include "app/studio/session.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "engine/clay.h"
#include "engine/error.h"
#include "engine/long_work.h"
#include "engine/mesh_export.h"
#include "engine/mesh_file.h"
#include "engine/refine.h"

namespace airclay {
namespace {

// Half of what the tracker still believes: there the pose may be off by a centimetre.
constexpr double kDoubtfulShare = 0.35, kDoubtfulMetres = 0.0012;
constexpr double kMouseFrameS = 1.0 / 30;
// 5 cm/s: slower, the filter's lag is of no distance.
constexpr double kMovingMetresS = 0.05;
// Ten sets of four VGA cameras are 37 MB.
constexpr std::size_t kKeptLearnedBytes = std::size_t(128) << 20;

/// The person gave up on work under way.
struct Cancelled {};

HandTrust trustIn(const FrameResult& result) {
  switch (result.hand) {
    case HandState::kEmpty:
      return HandTrust::kNobody;
    case HandState::kLost:
      return HandTrust::kLost;
    case HandState::kTracked:
      break;
  }
  // a pose just found by a search has no motion yet that would confirm it
  const bool doubtful =
      result.searched || result.fit.outside_m > kDoubtfulMetres ||
      (result.fit.outside_fraction > kDoubtfulShare && result.fit.outside_m > kDoubtfulMetres / 2);
  return doubtful ? HandTrust::kUncertain : HandTrust::kTracking;
}

std::size_t bytesOf(const FrameSet& set) {
  std::size_t bytes = 0;
  for (const std::vector<std::uint8_t>& one : set.bytes) bytes += one.size();
  return bytes;
}

/// A document's clay. The file itself is left alone: it may stand where nothing may be written.
ClayState stateIn(const std::filesystem::path& file) {
  const std::filesystem::path copy =
      std::filesystem::temp_directory_path() / ("airclay-" + std::to_string(::getpid()) + ".clay");
  std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
  const ClayState state = Document::open(copy).state();
  std::filesystem::remove(copy);
  return state;
}

/// Whether the same buffers hold both.
bool sameForm(const ClayState& a, const ClayState& b) {
  return a.rule == b.rule && a.levels == b.levels && a.solve == b.solve && a.cage.faces == b.cage.faces &&
         a.cage.points.size() == b.cage.points.size();
}

}  // namespace

/// Shows the work on this thread, and ends it when it is cancelled.
class Session::Working : public LongWork {
 public:
  Working(Session& session, const std::string& what) : session_(session) {
    session_.cancel_work_ = false;
    const std::lock_guard lock(session_.mutex_);
    session_.work_view_ = {what, 0, Clock::now()};
  }
  ~Working() override {
    const std::lock_guard lock(session_.mutex_);
    session_.work_view_ = {};
  }
  void goesOn(double share) override {
    if (session_.cancel_work_.exchange(false)) throw Cancelled{};
    const std::lock_guard lock(session_.mutex_);
    session_.work_view_.share = share;
  }

 private:
  Session& session_;
};

Session::Session(Gpu& gpu, const Options& options, Document document)
    : gpu_(gpu),
      options_(options),
      pipeline_(gpu, options.rig, options.hand, {options.voxels}, document.state()),
      document_(std::move(document)),
      form_(document_.state()),
      strokes_(document_),
      settings_(options.settings) {
  placeThumbnails();
  if (options_.recording) reader_.emplace(*options_.recording, !options_.headless);
  refreshDocumentView();
  thread_ = std::thread([this] { run(); });
}

Session::~Session() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void Session::finish() {
  thread_.join();
  if (fault_) std::rethrow_exception(fault_);
}

// ----------------------------------------------------------------------------------------------- the
// window's

Snapshot Session::snapshot() const {
  const std::lock_guard lock(mutex_);
  return snapshot_;
}

DocumentView Session::documentView() const {
  const std::lock_guard lock(mutex_);
  return document_view_;
}

std::vector<std::string> Session::takeNotes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notes_, {});
}

RecorderView Session::recorderView() const {
  const std::lock_guard lock(mutex_);
  return recorder_view_;
}

WorkView Session::workView() const {
  const std::lock_guard lock(mutex_);
  return work_view_;
}

void Session::set(const SessionSettings& settings) {
  const std::lock_guard lock(mutex_);
  settings_ = settings;
}

void Session::setMouseHand(const MouseHand& hand) {
  const std::lock_guard lock(mutex_);
  mouse_hand_ = hand;
}

void Session::withClay(const std::function<void(const ClayOnDevice&)>& look) const {
  const std::shared_lock lock(structure_);
  look({pipeline_.clay(), form_, form_serial_});
}

const Carver& Session::carver() const {
  return pipeline_.carver();
}

void Session::post(std::function<void()> command) {
  const std::lock_guard lock(mutex_);
  commands_.push_back(std::move(command));
}

/// Something that a recording notes and a replay does again. `what` names work that takes long.
void Session::act(const Deed& deed, const std::string& what) {
  post([this, deed, what] {
    refuseWhileReplaying();
    if (what.empty()) return perform(deed);
    const Working working(*this, what);
    perform(deed);
  });
}

void Session::undo() {
  act({.what = Deed::What::kUndo});
}

void Session::redo() {
  act({.what = Deed::What::kRedo});
}

void Session::refineClay() {
  act({.what = Deed::What::kRefine}, "refining");
}

void Session::setForm(int levels, SubdivisionRule rule, SolveRows solve) {
  act({.what = Deed::What::kForm, .levels = levels, .rule = rule, .solve = solve}, "subdividing");
}

void Session::turn(const Vec3& axis, double angle_rad, bool last) {
  act({.what = Deed::What::kTurn, .axis = axis, .angle_rad = angle_rad, .last = last});
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
    state.cage = readObj(file);
    becomeClay(state, "Import " + file.filename().string());
    note("imported " + file.filename().string());
  });
}

void Session::replaceClay(const ClayState& wanted, const std::string& name) {
  post([this, wanted, name] {
    refuseWhileReplaying();
    becomeClay(wanted, name);
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
    becomeDocument(Document::open(file));
    note("opened " + file.string());
  });
}

void Session::restartTake() {
  if (reader_) act({.what = Deed::What::kAgain});
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

void Session::pauseTake(bool paused) {
  if (reader_) reader_->pause(paused);
}

// --------------------------------------------------------------------------------------------- the own
// thread

void Session::run() {
  if (!options_.record.empty()) guarded([&] { beginRecording(options_.record); });
  while (!stop_) {
    bool worked = false;
    guarded([&] { worked = obey(); });
    guarded([&] {
      worked = (reader_           ? frameFromRecording()
                : options_.replay ? frameFromReplayedMouse()
                                  : frameFromMouse()) ||
               worked;
    });
    if (!worked && !reader_)
      std::this_thread::sleep_for(std::chrono::milliseconds(options_.headless ? 0 : 4));
  }
  guarded([&] {
    endStroke();
    endRecording();
  });
}

/// Faults of a file or a command are said, and the work goes on; those of the device end it. Without a window
/// there is nobody who would see to them: each ends it.
void Session::guarded(const std::function<void()>& work) {
  try {
    work();
  } catch (const Cancelled&) {
    note("cancelled: everything is as it was");
  } catch (const Error& error) {
    note(error.what());
    if (options_.headless && !fault_) fault_ = std::current_exception();
    if (error.fault() == Fault::kDevice || options_.headless) stop_ = failed_ = true;
  } catch (const std::exception& error) {
    note(error.what());
    if (options_.headless && !fault_) fault_ = std::current_exception();
    stop_ = failed_ = true;
  } catch (...) {  // the process is to end: whoever waits for it knows
    if (!fault_) fault_ = std::current_exception();
    stop_ = true;
  }
}

bool Session::obey() {
  bool worked = false;
  for (;;) {
    std::function<void()> command;
    {
      const std::lock_guard lock(mutex_);
      if (commands_.empty()) break;
      command = std::move(commands_.front());
      commands_.pop_front();
    }
    worked = true;
    guarded(command);
    refreshDocumentView();
  }
  return worked;
}

void Session::copyPictures(const FrameSet& set) {
  for (std::size_t c = 0; c < set.bytes.size(); ++c)
    std::copy(set.bytes[c].begin(), set.bytes[c].end(), pipeline_.picture(c).begin());
}

bool Session::frameFromRecording() {
  Recording& recording = *options_.recording;
  if (!background_learned_ && recording.hasBackground() && !recording.hasSilhouettes()) {
    std::vector<std::span<std::uint8_t>> buffers;
    for (std::size_t c = 0; c < options_.rig.cameras.size(); ++c) buffers.push_back(pipeline_.picture(c));
    recording.readBackground(buffers);
    pipeline_.learnBackground();
  }
  background_learned_ = true;
  if (!reader_->take(set_, 0.01)) {
    if (reader_->atEnd()) endOfTake();
    return false;
  }

  const DoneFrame* replayed = replayedFrame(set_.frame);
  const double step_s =
      set_.frame > 0 && last_frame_s_ >= 0 ? set_.time_s - last_frame_s_ : 1 / recording.rateHz();
  DoneFrame done = replayed ? *replayed : wishesNow(set_.time_s, step_s);
  if (!replayed) done.learned = set_.frame < recording.backgroundFrames();
  Snapshot next;
  next.frame = set_.frame;
  next.frame_count = recording.frameCount();
  next.time_s = done.learned ? set_.time_s : done.time_s;
  next.captured_at = set_.captured_at;
  next.decode_ms = set_.decode_ms;
  next.skew_s = skewOf(set_.camera_times_s);
  next.learning = done.learned;
  if (recording.hasSilhouettes()) {
    std::vector<Mask> masks;
    for (std::size_t c = 0; c < set_.bytes.size(); ++c)
      masks.push_back({options_.rig.cameras[c].width, options_.rig.cameras[c].height, set_.bytes[c]});
    next.result = pipeline_.trackMasks(masks);
  } else {
    copyPictures(set_);
    if (next.learning)
      learn();
    else
      next.result = pipeline_.trackPictures();
  }
  if (!next.learning) {
    next.trust = trustIn(next.result);
    if (!replayed) done.held = !gripIsBarred(next) && done.held;
    sculpt(next, done);
  }
  last_frame_s_ = next.time_s;
  recordFrame(done, &set_);
  drawThumbnails(set_);
  if (options_.on_frame) {
    const PlayedFrame played{next.frame,     next.time_s, next.learning,
                             next.decode_ms, next.skew_s, next.result};
    options_.on_frame(pipeline_, &played);
  }
  publish(next);
  return true;
}

/// The set shows the empty workspace. A take that is played again has taught it already.
void Session::learn() {
  if (!options_.replay && set_.frame < learned_frames_) return;
  pipeline_.learnBackground();
  ++learned_frames_;
  learned_bytes_ += bytesOf(set_);
  if (learned_bytes_ <= kKeptLearnedBytes)
    learned_.push_back(set_);
  else
    learned_.clear();
}

void Session::endOfTake() {
  if (snapshot().ended) return;
  if (options_.replay)
    for (const Deed& deed : options_.replay->actions.after) replayDeed(deed);
  endStroke();
  if (options_.on_frame) options_.on_frame(pipeline_, nullptr);
  Snapshot ended = snapshot();
  ended.ended = true;
  publish(ended);
  if (options_.headless) stop_ = true;
}

bool Session::frameFromMouse() {
  const auto now = Clock::now();
  const double now_s = std::chrono::duration<double>(now.time_since_epoch()).count();
  if (last_frame_s_ >= 0 && now_s - last_frame_s_ < kMouseFrameS) return false;
  DoneFrame done = wishesNow(now_s, last_frame_s_ >= 0 ? std::min(now_s - last_frame_s_, 0.1) : kMouseFrameS);
  {
    const std::lock_guard lock(mutex_);
    if (mouse_hand_.present) done.given_hand = mouse_hand_.world_from_hand;
  }
  workOnMouseFrame(done);
  return true;
}

void Session::workOnMouseFrame(DoneFrame done) {
  Snapshot next;
  next.frame = static_cast<int>(replayed_mouse_frames_);
  next.time_s = done.time_s;
  next.captured_at = Clock::now();
  if (done.given_hand) {
    next.trust = HandTrust::kTracking;
    next.result.fit.world_from_hand = *done.given_hand;
    next.result.fit.tracked = true;
    next.result.hand = HandState::kTracked;
  }
  if (!options_.replay) done.held = !gripIsBarred(next) && done.held;
  sculpt(next, done);
  last_frame_s_ = done.time_s;
  recordFrame(done, nullptr);
  publish(next);
}

bool Session::frameFromReplayedMouse() {
  const std::vector<Actions::Step>& steps = options_.replay->actions.steps;
  if (replayed_mouse_frames_ == steps.size()) {
    endOfTake();
    return false;
  }
  if (replayed_mouse_frames_ == 0) replay_began_ = Clock::now();
  const double due_s = steps[replayed_mouse_frames_].frame.time_s - steps.front().frame.time_s;
  if (!options_.headless && secondsBetween(replay_began_, Clock::now()) < due_s) return false;
  workOnMouseFrame(*replayedFrame(static_cast<int>(replayed_mouse_frames_)));
  ++replayed_mouse_frames_;
  return true;
}

/// A hand that was lost while it pulled does not take hold where it comes back: the clutch has to be pressed
/// anew.
bool Session::gripIsBarred(const Snapshot& next) {
  bool pulling = false;
  {
    const std::lock_guard lock(mutex_);
    pulling = settings_.tool == Tool::kPull && settings_.clutch == Clutch::kHold && settings_.clutch_down;
  }
  const bool there = next.trust == HandTrust::kTracking || next.trust == HandTrust::kUncertain;
  if (!pulling) grip_ = Grip::kFree;
  if (pulling && there && grip_ == Grip::kFree) grip_ = Grip::kSeen;
  if (pulling && !there && grip_ == Grip::kSeen) grip_ = Grip::kBarred;
  return grip_ == Grip::kBarred;
}

/// What is wanted of a frame, as the window says it now.
DoneFrame Session::wishesNow(double time_s, double step_s) const {
  const std::lock_guard lock(mutex_);
  DoneFrame done;
  done.time_s = time_s;
  done.step_s = step_s;
  done.tool = settings_.tool;
  done.symmetry = settings_.symmetry;
  done.held = settings_.held();
  done.steady = settings_.steady;
  return done;
}

void Session::sculpt(Snapshot& next, const DoneFrame& done) {
  next.grip_barred = grip_ == Grip::kBarred;
  if (!next.result.fit.tracked) {
    steady_.reset();
    pipeline_.forgetGivenHand();
    follow(next, done);
    return;
  }
  Pose pose = next.result.fit.world_from_hand;
  if (done.steady) {
    pose = steady_.filter(next.time_s, pose);
    if (steady_.speedMetresS() > kMovingMetresS) next.steady_ms = 1000 * steady_.latencyS();
  } else {
    steady_.reset();
  }
  next.world_from_hand = pose;
  SculptControls controls;
  controls.tool = done.tool;
  controls.symmetry = done.symmetry;
  controls.frame_s = std::clamp(done.step_s, 1e-3, 0.1);
  controls.held = next.trust == HandTrust::kTracking && !turning_ && done.held;
  const FrameResult step = pipeline_.sculptWith(pose, controls);
  next.result.clay = step.clay;
  addStages(step.stage_ms, next.result.stage_ms);
  next.result.frame_ms += step.frame_ms;
  follow(next, done);
}

/// Strokes become entries of the document's history.
void Session::follow(const Snapshot& next, const DoneFrame& done) {
  StrokeFrame frame;
  frame.time_s = next.time_s;
  frame.touched = next.result.clay.touched;
  frame.held = done.held;
  frame.tracked = next.trust == HandTrust::kTracking;
  if (strokes_.see(frame, toolName(done.tool), pipeline_.clay())) refreshDocumentView();
}

void Session::endStroke() {
  if (!strokes_.finish(pipeline_.clay())) return;
  recordDeed({.what = Deed::What::kEndStroke});
  refreshDocumentView();
}

// ------------------------------------------------------------------------------------------------ deeds

void Session::perform(const Deed& deed) {
  if (deed.what != Deed::What::kTurn || !turning_) endStroke();
  switch (deed.what) {
    case Deed::What::kEndStroke:
      return;  // that was it
    case Deed::What::kUndo: {
      if (!document_.canUndo()) return note("nothing to undo");
      const std::string name = *document_.canUndo();
      document_.undo();
      show(document_.state());
      note("undone: " + name);
      break;
    }
    case Deed::What::kRedo: {
      if (!document_.canRedo()) return note("nothing to redo");
      const std::string name = *document_.canRedo();
      document_.redo();
      show(document_.state());
      note("redone: " + name);
      break;
    }
    case Deed::What::kRefine: {
      const ClayState refined = refine(document_.state());
      commit("Refine", refined);
      note("refined: " + std::to_string(refined.cage.points.size()) + " control points");
      break;
    }
    case Deed::What::kForm:
      changeForm(deed);
      break;
    case Deed::What::kTurn:
      turnClay(deed);
      break;
    case Deed::What::kAgain:
      if (reader_ && !options_.replay) reader_->restart();
      forgetHand();
      break;
    case Deed::What::kClay:
    case Deed::What::kDocument:
      throw std::logic_error("Session: clay from elsewhere comes with its file");
  }
  recordDeed(deed);
}

void Session::changeForm(const Deed& deed) {
  ClayState state = document_.state();
  const bool other_level = deed.levels != state.levels;
  state.levels = deed.levels;
  state.rule = deed.rule;
  state.solve = deed.solve;
  commit(other_level ? "Level " + std::to_string(deed.levels) : "Settings", state);
}

void Session::turnClay(const Deed& deed) {
  turning_ = !deed.last;
  const Mat3 turn = Eigen::AngleAxisd(deed.angle_rad, deed.axis).toRotationMatrix();
  const Vec3& center = options_.rig.workspace.center;
  std::vector<Vec3> points = pipeline_.clay().cage().points;
  for (Vec3& point : points) point = center + turn * (point - center);
  pipeline_.clay().setControlPoints(points);
  if (deed.last) document_.commit("Turn", stateOf(document_, pipeline_.clay()));
}

void Session::forgetHand() {
  pipeline_.forgetHand();
  steady_.reset();
  grip_ = Grip::kFree;
}

void Session::becomeClay(const ClayState& state, const std::string& name) {
  endStroke();
  commit(name, state);
  if (recorder_) recorder_->clay(state, name);
}

void Session::becomeDocument(Document opened) {
  endStroke();
  std::unique_ptr<Pipeline::MadeClay> clay = made(opened.state());
  document_ = std::move(opened);
  show(document_.state(), std::move(clay));
  if (recorder_) recorder_->document(document_);
}

/// One edit: cancelled or refused while its clay is made, it has changed nothing.
void Session::commit(const std::string& name, const ClayState& state) {
  std::unique_ptr<Pipeline::MadeClay> clay = made(state);
  document_.commit(name, state);
  show(document_.state(), std::move(clay));
}

/// The clay of another form on the device; none when the same buffers hold it.
std::unique_ptr<Pipeline::MadeClay> Session::made(const ClayState& state) {
  return sameForm(state, form_) ? nullptr : pipeline_.makeClay(state);
}

void Session::show(const ClayState& state) {
  show(state, made(state));
}

void Session::show(const ClayState& state, std::unique_ptr<Pipeline::MadeClay> clay) {
  if (!clay) return pipeline_.clay().setControlPoints(state.cage.points);
  const std::unique_lock lock(structure_);
  gpu_.waitIdle();  // the window's pictures of the old clay
  pipeline_.setClay(std::move(clay));
  form_ = state;
  ++form_serial_;
}

// ------------------------------------------------------------------------------------ recording, replaying

void Session::beginRecording(const std::filesystem::path& folder) {
  if (recorder_) throw Error("a recording is under way already, in " + recorder_->view().folder.string());
  Recording* const source = options_.recording;
  const bool learns = source && !source->hasBackground() && !source->hasSilhouettes();
  if (learns && learned_frames_ > static_cast<int>(learned_.size()))
    throw Error("the empty workspace was learned from " + std::to_string(learned_frames_) +
                " frames, more than are kept for a recording that begins later; --record, from the start, "
                "would be right");
  if (turning_) perform({.what = Deed::What::kTurn, .angle_rad = 0, .last = true});
  endStroke();
  const ActionsHead head{learns ? source->backgroundFrames() : 0, options_.voxels, options_.hand_name,
                         !source};
  recorder_.emplace(SessionRecorder::Start{folder, source, options_.rig, head, learned_}, document_);
  // From here on as it will be when this is played: nothing is known of the hand, and the clay is the file's.
  forgetHand();
  pipeline_.clay().setControlPoints(document_.state().cage.points);
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

void Session::recordDeed(const Deed& deed) {
  if (recorder_) recorder_->deed(deed);
}

void Session::recordFrame(const DoneFrame& done, const FrameSet* set) {
  if (!recorder_) return;
  try {
    recorder_->frame(done, set);
  } catch (const Error&) {
    recorder_.reset();  // what is there stays, as it is after a power cut
    showRecorder();
    throw;
  }
  showRecorder();
}

void Session::refuseWhileReplaying() const {
  if (options_.replay && !snapshot().ended)
    throw Error("the recording is doing this by itself; wait for its end");
}

/// What was done of this frame; before it, what was done since the last. None without a replay.
const DoneFrame* Session::replayedFrame(int frame) {
  if (!options_.replay) return nullptr;
  const Actions::Step& step = options_.replay->actions.steps.at(std::size_t(frame));
  for (const Deed& deed : step.before) replayDeed(deed);
  return &step.frame;
}

void Session::replayDeed(const Deed& deed) {
  const std::filesystem::path file = options_.replay->folder / deed.file;
  if (deed.what == Deed::What::kClay) {
    becomeClay(stateIn(file), deed.name);
  } else if (deed.what == Deed::What::kDocument) {
    // A copy beside the document at hand: the recording itself stays as it is.
    const std::filesystem::path copy =
        document_.file().parent_path() / (document_.file().stem().string() + "-" + deed.file);
    std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
    becomeDocument(Document::open(copy));
  } else {
    perform(deed);
  }
  refreshDocumentView();
}

void Session::publish(Snapshot next) {
  const auto now = Clock::now();
  if (!next.ended) {
    frame_times_.push_back(now);
    next.serial = ++serial_;
  }
  while (!frame_times_.empty() && now - frame_times_.front() > std::chrono::seconds(1))
    frame_times_.pop_front();
  next.rate_hz = static_cast<double>(frame_times_.size());
  next.sculpting = strokes_.underWay();
  {
    const std::lock_guard lock(mutex_);
    snapshot_ = std::move(next);
  }
  if (options_.wake) options_.wake();
}

void Session::refreshDocumentView() {
  DocumentView view;
  view.file = document_.file();
  view.undo = document_.canUndo();
  view.redo = document_.canRedo();
  view.undo_count = document_.undoCount();
  view.redo_count = document_.redoCount();
  view.levels = document_.state().levels;
  view.rule = document_.state().rule;
  view.solve = document_.state().solve;
  view.control_points = pipeline_.clay().controlPointCount();
  view.data_points = pipeline_.clay().dataPointCount();
  const std::lock_guard lock(mutex_);
  document_view_ = std::move(view);
}

void Session::note(const std::string& words) {
  const std::lock_guard lock(mutex_);
  notes_.push_back(words);
}

void Session::placeThumbnails() {
  std::size_t pixels = 0;
  for (const bool small : {false, true})
    for (const Camera& camera : options_.rig.cameras) {
      const int width = small ? (kThumbnailWidth - kThumbnailGap) / 2 : kThumbnailWidth;
      const Thumbnail place{pixels, width, std::max(1, width * camera.height / camera.width)};
      thumbnail_places_[small].push_back(place);
      pixels += std::size_t(place.width) * std::size_t(place.height);
    }
  thumbnails_ = Buffer<std::uint32_t>(gpu_, pixels, Memory::kHost);
}

void Session::drawThumbnails(const FrameSet& set) {
  if (options_.headless) return;
  for (const std::vector<Thumbnail>& places : thumbnail_places_)
    for (std::size_t c = 0; c < set.bytes.size(); ++c) drawThumbnail(places[c], c, set.bytes[c]);
}

/// Every few pixels one: enough to see what a camera sees. What belongs to the hand is warm.
void Session::drawThumbnail(const Thumbnail& to, std::size_t c, const std::vector<std::uint8_t>& bytes) {
  const bool masks_only = options_.recording->hasSilhouettes();
  const std::span<const std::uint32_t> masks = pipeline_.silhouettes().masks().host();
  const GpuCamera& camera = pipeline_.gpuRig().camera(c);
  std::uint32_t* out = thumbnails_.host().data() + to.first;
  for (int row = 0; row < to.height; ++row) {
    const std::size_t y = std::size_t(row) * camera.height / std::size_t(to.height);
    for (int column = 0; column < to.width; ++column) {
      const std::size_t x = std::size_t(column) * camera.width / std::size_t(to.width);
      const std::size_t at = y * camera.width + x;
      const bool object = masks[camera.mask_words + y * camera.row_words + x / 32] >> (x % 32) & 1;
      std::uint32_t b = 60, g = 60, r = 60;
      if (!masks_only) {
        b = bytes[3 * at];
        g = bytes[3 * at + 1];
        r = bytes[3 * at + 2];
      }
      if (object) {
        b = b / 2 + 30;
        g = g / 2 + 60;
        r = r / 2 + 115;
      }
      *out++ = b | g << 8 | r << 16 | 0xFF000000u;
    }
  }
}

}  // namespace airclay
