// SPDX-License-Identifier: MIT
#include "app/session/session.h"

#include <algorithm>
#include <cmath>

#include "engine/clay/clay.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// Half of the tracker's own limit: above it, the pose may be off by a centimetre.
constexpr double kDoubtfulShare = 0.35, kDoubtfulMetres = 0.0012;
constexpr double kMouseFrameS = 1.0 / 30;
/// On a CPU device, thumbnails need not update faster than the interface.
constexpr auto kThumbnailsStay = std::chrono::milliseconds(90);
/// Enough data points to locate the clay.
constexpr std::size_t kClayPoints = 2000;
/// A window that draws nothing for this long is minimised or busy.
constexpr auto kRenderWait = std::chrono::milliseconds(50);
// 5 cm/s: below it, the filter's lag is negligible.
constexpr double kMovingMetresS = 0.05;
/// Without a set for this long, the cameras count as silent.
constexpr auto kSilence = std::chrono::milliseconds(700);
// Ten sets of four VGA cameras are 37 MB.
constexpr std::size_t kKeptLearnedBytes = std::size_t(128) << 20;

TrackingState trustIn(const FrameResult& result) {
  switch (result.state()) {
    case HandState::kEmpty:
      return TrackingState::kNoHand;
    case HandState::kLost:
      return TrackingState::kLost;
    case HandState::kUncertain:
      return TrackingState::kUncertain;
    case HandState::kTracked:
      break;
  }
  // a pose from a search has no motion to confirm it yet
  const HandFit& fit = *result.trackedHand();
  const bool doubtful = result.searched || fit.outside_m > kDoubtfulMetres ||
                        (fit.outside_fraction > kDoubtfulShare && fit.outside_m > kDoubtfulMetres / 2);
  return doubtful ? TrackingState::kUncertain : TrackingState::kTracking;
}

std::size_t bytesOf(const FrameSet& set) {
  std::size_t bytes = 0;
  for (const std::vector<std::uint8_t>& one : set.bytes) bytes += one.size();
  return bytes;
}

}  // namespace

Session::Session(Gpu& gpu, const Options& options, Document document)
    : gpu_(gpu),
      options_(options),
      pipeline_(gpu, options.rig, options.hand, options.pipeline, document.state()),
      document_(std::move(document)),
      clay_structure_(document_.state()),
      strokes_(document_),
      settings_(options.settings) {
  placeThumbnails();
  if (options_.recording) reader_.emplace(*options_.recording, !options_.headless);
  refreshDocumentView();
  updateClayView(snapshot_, true);
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

std::vector<std::string> Session::takeMessages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notes_, {});
}

void Session::renderSubmitted(std::uint64_t serial) {
  const std::lock_guard lock(mutex_);
  submitted_serial_ = serial;
  render_submitted_.notify_all();
}

RecorderView Session::recorderView() const {
  const std::lock_guard lock(mutex_);
  return recorder_view_;
}

TaskStatus Session::taskStatus() const {
  const std::lock_guard lock(mutex_);
  return task_status_;
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
  look({pipeline_.clay(), clay_structure_, structure_serial_});
}

const Carver& Session::carver() const {
  return pipeline_.carver();
}

void Session::keepHull(bool keep) {
  post([this, keep] {
    pipeline_.keepHull(keep);
    if (keep) pipeline_.updateHull();
  });
}

void Session::post(std::function<void()> command) {
  const std::lock_guard lock(mutex_);
  commands_.push_back(std::move(command));
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
    guarded([&] { worked = processCommands(); });
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

/// Reports errors of a file or a command and continues; errors of the device end the session. Without a
/// window, every error ends it.
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
  } catch (...) {  // the thread that waits rethrows it
    if (!fault_) fault_ = std::current_exception();
    stop_ = true;
  }
}

bool Session::processCommands() {
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
  if (worked) {
    Snapshot now = snapshot();
    updateClayView(now, true);
    const std::lock_guard lock(mutex_);
    snapshot_ = std::move(now);
  }
  return worked;
}

void Session::copyImages(const FrameSet& set) {
  for (std::size_t c = 0; c < set.bytes.size(); ++c)
    std::copy(set.bytes[c].begin(), set.bytes[c].end(), pipeline_.image(c).begin());
}

bool Session::frameFromRecording() {
  Recording& recording = *options_.recording;
  if (!background_learned_ && recording.hasBackground() && !recording.hasSilhouettes()) {
    std::vector<std::span<std::uint8_t>> buffers;
    for (std::size_t c = 0; c < options_.rig.cameras.size(); ++c) buffers.push_back(pipeline_.image(c));
    recording.readBackground(buffers);
    pipeline_.learnBackground();
  }
  background_learned_ = true;
  if (!reader_->take(set_, 0.01)) {
    if (reader_->atEnd())
      endOfTake();
    else if (recording.isLive())
      showSilence();
    return false;
  }

  if (still_to_learn_ > 0 && set_.missing_cameras != 0) {  // a camera would learn from another instant
    reader_->ask();
    return true;
  }
  const ReplayFrame* replayed = replayedFrame(set_.frame);
  const double step_s =
      set_.frame > 0 && last_frame_s_ >= 0 ? set_.time_s - last_frame_s_ : 1 / recording.rateHz();
  ReplayFrame done = replayed ? *replayed : currentInputs(set_.time_s, step_s);
  if (!replayed) {
    done.learned = set_.frame < recording.backgroundFrames() || still_to_learn_ > 0;
    still_to_learn_ = std::max(0, still_to_learn_ - 1);
  }
  if (!replayed) done.missing_cameras = set_.missing_cameras;
  Snapshot next;
  next.frame = set_.frame;
  next.frame_count = recording.isLive() ? 0 : recording.frameCount();
  next.camera_problems = set_.camera_problems;
  next.time_s = done.learned ? set_.time_s : done.time_s;
  next.captured_at = set_.captured_at;
  next.decode_ms = set_.decode_ms;
  next.skew_s = skewOf(set_.camera_times_s);
  next.learning = done.learned;
  bool used = true;
  if (recording.hasSilhouettes()) {
    std::vector<Silhouette> masks;
    for (std::size_t c = 0; c < set_.bytes.size(); ++c)
      masks.push_back({options_.rig.cameras[c].width, options_.rig.cameras[c].height, set_.bytes[c]});
    next.result = pipeline_.trackSilhouettes(masks, {done.missing_cameras, set_.camera_times_s});
  } else {
    copyImages(set_);
    if (next.learning)
      used = learn();
    else
      next.result = pipeline_.trackImages({done.missing_cameras, set_.camera_times_s});
  }
  reader_->ask();  // the rest of this frame uses only one core
  if (!next.learning) {
    next.trust = trustIn(next.result);
    if (!replayed) done.held = !gripIsBarred(next) && done.held;
    sculpt(next, done);
  }
  last_frame_s_ = next.time_s;
  if (used) recordFrame(done, &set_);
  const auto now = Clock::now();
  if (!gpu_.isCpu() || now - thumbnails_at_ > kThumbnailsStay) {
    drawThumbnails(set_);
    thumbnails_at_ = now;
  }
  if (options_.on_frame) {
    const PlayedFrame played{next.frame,     next.time_s, next.learning,
                             next.decode_ms, next.skew_s, next.result};
    options_.on_frame(pipeline_, &played);
  }
  publish(next);
  waitForRender(serial_);
  return true;
}

/// Reports that the cameras give no images, and why.
void Session::showSilence() {
  const auto now = Clock::now();
  if (!frame_times_.empty() && now - frame_times_.back() < kSilence) return;
  frame_times_.clear();
  {
    const std::lock_guard lock(mutex_);
    if (snapshot_.silent && now - snapshot_.captured_at < kSilence) return;
    snapshot_.silent = true;
    snapshot_.captured_at = now;
    snapshot_.camera_problems = options_.recording->live()->cameraProblems();
    snapshot_.rate_hz = 0;
    snapshot_.trust = TrackingState::kNoHand;
    snapshot_.hands.clear();
  }
  if (options_.wake) options_.wake();
}

/// Learns the background from the set. False if it is known already, because the take restarted.
bool Session::learn() {
  if (!options_.replay && set_.frame < learned_frames_) return false;
  pipeline_.learnBackground();
  ++learned_frames_;
  if (options_.headless) return true;  // headless recordings start at the first frame
  learned_bytes_ += bytesOf(set_);
  if (learned_bytes_ <= kKeptLearnedBytes)
    learned_.push_back(set_);
  else
    learned_.clear();
  return true;
}

void Session::endOfTake() {
  if (snapshot().ended) return;
  if (options_.replay)
    for (const Action& action : options_.replay->actions.after) replayAction(action);
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
  ReplayFrame done =
      currentInputs(now_s, last_frame_s_ >= 0 ? std::min(now_s - last_frame_s_, 0.1) : kMouseFrameS);
  {
    const std::lock_guard lock(mutex_);
    if (mouse_hand_.present) done.given_hands = {mouse_hand_.pose};
  }
  workOnMouseFrame(done);
  return true;
}

void Session::workOnMouseFrame(ReplayFrame done) {
  Snapshot next;
  next.frame = static_cast<int>(replayed_mouse_frames_);
  next.time_s = done.time_s;
  next.captured_at = Clock::now();
  if (!done.given_hands.empty()) next.trust = TrackingState::kTracking;
  for (const HandPose& pose : done.given_hands) {
    HandFit& fit = next.result.hands.emplace_back();
    fit.pose = pose;
    fit.tracked = true;
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
    pulling = settings_.tool.tool().grabs && settings_.clutch == Clutch::kHold && settings_.clutch_down;
  }
  const bool there = next.trust == TrackingState::kTracking || next.trust == TrackingState::kUncertain;
  if (!pulling) grip_ = Grip::kFree;
  if (pulling && there && grip_ == Grip::kFree) grip_ = Grip::kSeen;
  if (pulling && !there && grip_ == Grip::kSeen) grip_ = Grip::kBarred;
  return grip_ == Grip::kBarred;
}

/// The window's current settings for a frame.
ReplayFrame Session::currentInputs(double time_s, double step_s) const {
  const std::lock_guard lock(mutex_);
  ReplayFrame done;
  done.time_s = time_s;
  done.step_s = step_s;
  done.tool = settings_.tool;
  done.symmetry = settings_.symmetry;
  done.held = settings_.held();
  done.filtered = settings_.filtered;
  return done;
}

void Session::sculpt(Snapshot& next, const ReplayFrame& done) {
  next.grip_barred = grip_ == Grip::kBarred;
  for (const HandFit& fit : next.result.hands)
    if (fit.tracked) next.hands.push_back(fit.pose);
  if (done.filtered) filterPoses(next);
  for (std::size_t k = done.filtered ? next.hands.size() : 0; k < kMaxHands; ++k) pose_filters_[k].reset();
  if (next.hands.empty()) {
    pipeline_.sculptWith({});
    follow(next, done);
    return;
  }
  SculptControls controls;
  controls.tool = done.tool;
  controls.symmetry = done.symmetry;
  controls.frame_s = std::clamp(done.step_s, 1e-3, 0.1);
  controls.held = next.trust == TrackingState::kTracking && !turning_ && done.held;
  const FrameResult step = pipeline_.sculptWith(next.hands, controls);
  next.result.clay = step.clay;
  addStages(step.stage_ms, next.result.stage_ms);
  next.result.frame_ms += step.frame_ms;
  follow(next, done);
}

/// Smooths the hands' root transforms.
void Session::filterPoses(Snapshot& next) {
  for (std::size_t k = 0; k < next.hands.size(); ++k) {
    Pose& root = next.hands[k].world_from_hand;
    root = pose_filters_[k].filter(next.time_s, root);
  }
  if (!next.hands.empty() && pose_filters_[0].speedMetresS() > kMovingMetresS)
    next.filter_lag_ms = 1000 * pose_filters_[0].latencyS();
}

/// Commits strokes to the document's history.
void Session::follow(const Snapshot& next, const ReplayFrame& done) {
  StrokeFrame frame;
  frame.time_s = next.time_s;
  frame.touched = next.result.clay.touched;
  frame.held = done.held;
  frame.tracked = next.trust == TrackingState::kTracking;
  if (strokes_.see(frame, done.tool.tool().name, pipeline_.clay())) refreshDocumentView();
}

void Session::endStroke() {
  if (!strokes_.finish(pipeline_.clay())) return;
  recordAction({.kind = Action::Kind::kEndStroke});
  refreshDocumentView();
}

/// Lets the window draw this frame before the next one uses the device.
void Session::waitForRender(std::uint64_t serial) {
  if (options_.headless) return;
  std::unique_lock lock(mutex_);
  render_submitted_.wait_for(lock, kRenderWait, [&] { return submitted_serial_ >= serial || stop_; });
}

/// Updates the snapshot's clay. `moved`: it may have moved since the last call.
void Session::updateClayView(Snapshot& next, bool moved) {
  if (options_.headless) return;
  if (moved) {
    const std::vector<vec3> all = pipeline_.clay().dataPoints().download();
    const std::size_t step = std::max<std::size_t>(1, all.size() / kClayPoints);
    clay_points_.clear();
    workspace_from_clay_ = Pose(pipeline_.clay().workspaceFromClay());
    const Eigen::Matrix3f turn = workspace_from_clay_.linear().cast<float>();
    for (std::size_t i = 0; i < all.size(); i += step) clay_points_.push_back(turn * all[i]);
    ++clay_serial_;
  }
  next.clay_points = clay_points_;
  next.workspace_from_clay = workspace_from_clay_;
  next.clay_serial = clay_serial_;
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
  renewStages(next.result.stage_ms, stage_ms_);
  next.stage_ms = stage_ms_;
  next.sculpting = strokes_.active();
  updateClayView(next, next.result.clay.touched > 0);
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

void Session::note(const std::string& text) {
  const std::lock_guard lock(mutex_);
  notes_.push_back(text);
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

/// Samples every few pixels. The hand's silhouette is tinted.
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
