// SPDX-License-Identifier: MIT
#include "app/studio/session.h"

#include <algorithm>
#include <cmath>

#include "engine/clay.h"
#include "engine/error.h"
#include "engine/mesh_export.h"
#include "engine/mesh_file.h"
#include "engine/refine.h"

namespace airclay {
namespace {

// Half of what the tracker still believes: there the pose may be off by a centimetre.
constexpr double kDoubtfulShare = 0.35, kDoubtfulMetres = 0.0012;
constexpr double kMouseFrameS = 1.0 / 30;
/// Where it is the CPU that draws, small pictures need not be newer; the interface around them is not either.
constexpr auto kThumbnailsStay = std::chrono::milliseconds(90);
/// As many data points are enough to say where the clay is.
constexpr std::size_t kClayPoints = 2000;
/// A window that draws nothing for so long is minimised, or busy with something else.
constexpr auto kPictureWait = std::chrono::milliseconds(50);

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

ClayOptions optionsFor(const ClayState& state) {
  return {state.cage, state.rule, state.levels, state.solve};
}

/// Whether the same buffers hold both.
bool sameForm(const ClayState& a, const ClayState& b) {
  return a.rule == b.rule && a.levels == b.levels && a.solve == b.solve && a.cage.faces == b.cage.faces &&
         a.cage.points.size() == b.cage.points.size();
}

}  // namespace

Session::Session(Gpu& gpu, const Options& options, Document document)
    : gpu_(gpu),
      options_(options),
      pipeline_(gpu, options.rig, options.hand, {options.voxels}, optionsFor(document.state())),
      document_(std::move(document)),
      form_(document_.state()),
      strokes_(document_) {
  std::size_t pixels = 0;
  for (std::size_t c = 0; c < options_.rig.cameras.size(); ++c) {
    thumbnail_starts_.push_back(pixels);
    pixels += std::size_t(kThumbnailWidth) * std::size_t(thumbnailHeight(c));
  }
  thumbnails_ = Buffer<std::uint32_t>(gpu, pixels, Memory::kHost);
  if (options_.recording) reader_.emplace(*options_.recording);
  refreshDocumentView();
  lookAtClay(snapshot_, true);
  thread_ = std::thread([this] { run(); });
}

Session::~Session() {
  stop_ = true;
  thread_.join();
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

void Session::pictureSubmitted(std::uint64_t serial) {
  const std::lock_guard lock(mutex_);
  submitted_serial_ = serial;
  picture_submitted_.notify_all();
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

int Session::thumbnailHeight(std::size_t camera) const {
  const Camera& c = options_.rig.cameras[camera];
  return std::max(1, kThumbnailWidth * c.height / c.width);
}

const Carver& Session::carver() const {
  return pipeline_.carver();
}

void Session::post(std::function<void()> command) {
  const std::lock_guard lock(mutex_);
  commands_.push_back(std::move(command));
}

void Session::undo() {
  post([this] {
    endStroke();
    if (!document_.canUndo()) return note("nothing to undo");
    const std::string name = *document_.canUndo();
    document_.undo();
    show(document_.state());
    note("undone: " + name);
  });
}

void Session::redo() {
  post([this] {
    endStroke();
    if (!document_.canRedo()) return note("nothing to redo");
    const std::string name = *document_.canRedo();
    document_.redo();
    show(document_.state());
    note("redone: " + name);
  });
}

void Session::refineClay() {
  post([this] {
    endStroke();
    const ClayState refined = refine(document_.state());
    document_.commit("Refine", refined);
    show(refined);
    note("refined: " + std::to_string(refined.cage.points.size()) + " control points");
  });
}

void Session::setForm(int levels, SubdivisionRule rule, SolveRows solve) {
  post([this, levels, rule, solve] {
    endStroke();
    ClayState state = document_.state();
    state.levels = levels;
    state.rule = rule;
    state.solve = solve;
    const int old_levels = document_.state().levels;
    show(state);  // refuses what is too large before the document has it
    document_.commit(levels != old_levels ? "Level " + std::to_string(levels) : "Settings", state);
  });
}

void Session::turn(const Vec3& axis, double angle_rad, bool last) {
  post([this, axis, angle_rad, last] {
    if (!turning_) endStroke();
    turning_ = !last;
    const Mat3 turn = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
    const Vec3& center = options_.rig.workspace.center;
    std::vector<Vec3> points = pipeline_.clay().cage().points;
    for (Vec3& point : points) point = center + turn * (point - center);
    pipeline_.clay().setControlPoints(points);
    if (last) document_.commit("Turn", stateOf(document_, pipeline_.clay()));
  });
}

void Session::exportMesh(const std::filesystem::path& file, bool surface) {
  post([this, file, surface] {
    const ClayState state = stateOf(document_, pipeline_.clay());
    const MeshExport written =
        airclay::exportMesh(file, meshAtLevel(state.cage, surface ? state.levels : 0, state.rule));
    note(file.filename().string() + ": " + std::to_string(written.faces) + " faces" +
         (written.watertight() ? ", watertight" : ", open: a slicer will not print it"));
  });
}

void Session::importCage(const std::filesystem::path& file) {
  post([this, file] {
    endStroke();
    ClayState state = document_.state();
    state.cage = readObj(file);
    show(state);
    document_.commit("Import " + file.filename().string(), state);
    note("imported " + file.filename().string());
  });
}

void Session::replaceClay(const ClayState& wanted, const std::string& name) {
  post([this, wanted, name] {
    endStroke();
    show(wanted);
    document_.commit(name, wanted);
  });
}

void Session::saveAs(const std::filesystem::path& file) {
  post([this, file] {
    endStroke();
    document_.saveAs(file);
    document_ = Document::open(file);
    note("saved as " + file.string());
  });
}

void Session::openDocument(const std::filesystem::path& file) {
  post([this, file] {
    endStroke();
    Document opened = Document::open(file);
    show(opened.state());
    document_ = std::move(opened);
    note("opened " + file.string());
  });
}

void Session::restartTake() {
  post([this] {
    endStroke();
    if (!reader_) return;
    reader_->restart();
    pipeline_.forgetHand();
    steady_.reset();
  });
}

void Session::pauseTake(bool paused) {
  if (reader_) reader_->pause(paused);
}

// --------------------------------------------------------------------------------------------- the own
// thread

void Session::run() {
  while (!stop_) {
    bool worked = false;
    guarded([&] { worked = obey(); });
    guarded([&] { worked = (reader_ ? frameFromRecording() : frameFromMouse()) || worked; });
    if (!worked && !reader_) std::this_thread::sleep_for(std::chrono::milliseconds(4));
  }
  guarded([&] { endStroke(); });
}

/// Faults of a file or a command are said, and the work goes on; those of the device end it.
void Session::guarded(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    note(error.what());
    if (error.fault() == Fault::kDevice) stop_ = failed_ = true;
  } catch (const std::exception& error) {
    note(error.what());
    stop_ = failed_ = true;
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
  if (worked) {
    Snapshot now = snapshot();
    lookAtClay(now, true);
    const std::lock_guard lock(mutex_);
    snapshot_ = std::move(now);
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
    if (reader_->atEnd() && !snapshot().ended) {
      endStroke();
      if (options_.on_frame) options_.on_frame(pipeline_, nullptr);
      Snapshot ended = snapshot();
      ended.ended = true;
      publish(ended);
    }
    return false;
  }

  Snapshot next;
  next.frame = set_.frame;
  next.frame_count = recording.frameCount();
  next.time_s = set_.time_s;
  next.captured_at = set_.captured_at;
  next.decode_ms = set_.decode_ms;
  next.learning = set_.frame < recording.backgroundFrames();
  if (recording.hasSilhouettes()) {
    std::vector<Mask> masks;
    for (std::size_t c = 0; c < set_.bytes.size(); ++c)
      masks.push_back({options_.rig.cameras[c].width, options_.rig.cameras[c].height, set_.bytes[c]});
    next.result = pipeline_.trackMasks(masks);
  } else {
    copyPictures(set_);
    if (next.learning)
      pipeline_.learnBackground();
    else
      next.result = pipeline_.trackPictures();
  }
  reader_->ask();  // what is left of this frame keeps one core busy
  if (!next.learning) {
    next.trust = trustIn(next.result);
    sculpt(next, set_.frame > 0 && last_frame_s_ >= 0 ? next.time_s - last_frame_s_ : 1 / recording.rateHz());
  }
  last_frame_s_ = next.time_s;
  const auto now = Clock::now();
  if (!gpu_.isCpu() || now - thumbnails_at_ > kThumbnailsStay) {
    drawThumbnails(set_);
    thumbnails_at_ = now;
  }
  if (options_.on_frame) {
    const PlayedFrame played{next.frame, next.time_s, next.learning, next.decode_ms, next.result};
    options_.on_frame(pipeline_, &played);
  }
  publish(next);
  waitForPicture(serial_);
  return true;
}

bool Session::frameFromMouse() {
  MouseHand hand;
  {
    const std::lock_guard lock(mutex_);
    hand = mouse_hand_;
  }
  const auto now = Clock::now();
  const double now_s = std::chrono::duration<double>(now.time_since_epoch()).count();
  if (last_frame_s_ >= 0 && now_s - last_frame_s_ < kMouseFrameS) return false;
  Snapshot next;
  next.time_s = now_s;
  next.captured_at = now;
  if (hand.present) {
    next.trust = HandTrust::kTracking;
    next.result.fit.world_from_hand = hand.world_from_hand;
    next.result.fit.tracked = true;
    next.result.hand = HandState::kTracked;
  }
  sculpt(next, last_frame_s_ >= 0 ? std::min(now_s - last_frame_s_, 0.1) : kMouseFrameS);
  last_frame_s_ = now_s;
  publish(next);
  return true;
}

void Session::sculpt(Snapshot& next, double step_s) {
  SessionSettings settings;
  {
    const std::lock_guard lock(mutex_);
    settings = settings_;
  }
  if (!next.result.fit.tracked) {
    steady_.reset();
    pipeline_.forgetGivenHand();
    follow(next, settings);
    return;
  }
  Pose pose = next.result.fit.world_from_hand;
  if (settings.steady) {
    pose = steady_.filter(next.time_s, pose);
    next.steady_ms = 1000 * steady_.latencyS();
  } else {
    steady_.reset();
  }
  next.world_from_hand = pose;
  SculptControls controls;
  controls.tool = settings.tool;
  controls.symmetry = settings.symmetry;
  controls.frame_s = std::clamp(step_s, 1e-3, 0.1);
  controls.held = next.trust == HandTrust::kTracking && !turning_ && settings.held();
  const FrameResult step = pipeline_.sculptWith(pose, controls);
  next.result.clay = step.clay;
  addStages(step.stage_ms, next.result.stage_ms);
  next.result.frame_ms += step.frame_ms;
  follow(next, settings);
}

/// Strokes become entries of the document's history.
void Session::follow(const Snapshot& next, const SessionSettings& settings) {
  StrokeFrame frame;
  frame.time_s = next.time_s;
  frame.touched = next.result.clay.touched;
  frame.held = settings.held();
  frame.tracked = next.trust == HandTrust::kTracking;
  if (strokes_.see(frame, toolName(settings.tool), pipeline_.clay())) refreshDocumentView();
}

void Session::endStroke() {
  if (strokes_.finish(pipeline_.clay())) refreshDocumentView();
}

void Session::show(const ClayState& state) {
  if (sameForm(state, form_)) {
    pipeline_.clay().setControlPoints(state.cage.points);
    return;
  }
  const std::unique_lock lock(structure_);
  gpu_.waitIdle();  // the window's pictures of the old clay
  pipeline_.setClay(optionsFor(state));
  form_ = state;
  ++form_serial_;
}

void Session::waitForPicture(std::uint64_t serial) {
  std::unique_lock lock(mutex_);
  picture_submitted_.wait_for(lock, kPictureWait, [&] { return submitted_serial_ >= serial || stop_; });
}

/// What the window is told of the clay. `moved`: it may have since the last time.
void Session::lookAtClay(Snapshot& next, bool moved) {
  if (moved) {
    const std::vector<vec3> all = pipeline_.clay().dataPoints().download();
    const std::size_t step = std::max<std::size_t>(1, all.size() / kClayPoints);
    clay_points_.clear();
    for (std::size_t i = 0; i < all.size(); i += step) clay_points_.push_back(all[i]);
    ++clay_serial_;
  }
  next.clay_points = clay_points_;
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
  next.sculpting = strokes_.underWay();
  lookAtClay(next, next.result.clay.touched > 0);
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

/// Every few pixels one: enough to see what a camera sees. What belongs to the hand is warm.
void Session::drawThumbnails(const FrameSet& set) {
  const bool masks_only = options_.recording->hasSilhouettes();
  const std::span<const std::uint32_t> masks = pipeline_.silhouettes().masks().host();
  for (std::size_t c = 0; c < set.bytes.size(); ++c) {
    const GpuCamera& camera = pipeline_.gpuRig().camera(c);
    const int height = thumbnailHeight(c);
    std::uint32_t* out = thumbnails_.host().data() + thumbnail_starts_[c];
    for (int row = 0; row < height; ++row) {
      const std::size_t y = std::size_t(row) * camera.height / std::size_t(height);
      for (int column = 0; column < kThumbnailWidth; ++column) {
        const std::size_t x = std::size_t(column) * camera.width / kThumbnailWidth;
        const std::size_t at = y * camera.width + x;
        const bool object = masks[camera.mask_words + y * camera.row_words + x / 32] >> (x % 32) & 1;
        std::uint32_t b = 60, g = 60, r = 60;
        if (!masks_only) {
          b = set.bytes[c][3 * at];
          g = set.bytes[c][3 * at + 1];
          r = set.bytes[c][3 * at + 2];
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
}

}  // namespace airclay
