// SPDX-License-Identifier: MIT
// One mutex guards all data that the threads share. This suffices: there are some hundred frames per second,
// and each locks it for microseconds.
#include "capture/cameras/live_cameras.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>

#include "capture/cameras/live_feed.h"
#include "capture/takes/frame_matcher.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// The interval of attempts to reopen a lost camera.
constexpr double kReopenS = 1;
// All files start together, this long after they were opened.
constexpr double kLeadS = 0.1;
// The decay of a camera's longest lag per frame (to half in two seconds at 30 Hz), and the margin added to
// it.
constexpr double kLagDecay = 0.99, kLagMarginS = 0.05;
// Sets do not wait longer than this for a camera.
constexpr double kMaxPatienceS = 5;
// Frames queued per camera: a few for sculpting, which uses the newest; up to a second for recording, because
// writing to disk can stall. The queues of all cameras are limited to this many bytes, but to no fewer than
// four frames each.
constexpr std::size_t kNewestFrames = 8, kEveryFrames = 30, kMinFrames = 4;
constexpr std::size_t kMaxBytes = 512u << 20;
// How long the destructor waits for blocked reads.
constexpr double kEndS = 0.7;
// The interval at which next() updates the cameras' states while it waits.
constexpr double kUpdateS = 0.02;

std::string describe(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height) + " pixels";
}

}  // namespace

struct LiveCameras::Shared {
  Shared(std::size_t cameras, const FrameMatcher::Options& matching)
      : max_skew_s(matching.max_skew_s),
        patience_s(matching.patience_s),
        matcher(cameras, matching),
        feeds(cameras) {}

  mutable std::mutex mutex;
  std::condition_variable changed;
  bool stopping = false;
  LiveOptions::Sets sets = LiveOptions::Sets::kNewest;
  double max_skew_s, patience_s;
  Clock::time_point start;
  FrameMatcher matcher;
  std::vector<Feed> feeds;

  // Called on a camera's thread, without the lock.
  void run(std::size_t index, std::unique_ptr<CameraSource> source);
  std::unique_ptr<CameraSource> reopen(std::size_t index);
  void readAll(std::size_t index, CameraSource& source);
  void deliver(std::size_t index, LiveImage image, double capture_s);

  // Called with the mutex locked.
  void trim(std::size_t index);
  CameraState stateAt(std::size_t index, double now_s) const;
  void updateExpectations(double now_s);
  LiveSet take(const FrameMatcher::Set& match);
  bool isOver(double now_s) const;
};

void LiveCameras::Shared::run(std::size_t index, std::unique_ptr<CameraSource> source) {
  Feed& feed = feeds[index];
  for (bool ended = false; !ended;) {
    if (source) {
      std::string fault;
      try {
        readAll(index, *source);
        ended = true;
      } catch (const std::exception& error) {
        fault = error.what();
      }
      const std::lock_guard lock(mutex);
      feed.reading = nullptr;
      feed.camera_problem = ended ? CameraState::kEnded : CameraState::kLost;
      if (!ended) feed.fault = fault;
      changed.notify_all();
    }
    source.reset();  // the device must be free before it is opened again
    std::unique_lock lock(mutex);
    if (!ended) changed.wait_for(lock, std::chrono::duration<double>(kReopenS), [&] { return stopping; });
    if (stopping || ended) break;
    feed.camera_problem = CameraState::kReconnecting;
    lock.unlock();
    source = reopen(index);
  }
  const std::lock_guard lock(mutex);
  feed.done = true;
  changed.notify_all();
}

std::unique_ptr<CameraSource> LiveCameras::Shared::reopen(std::size_t index) {
  Feed& feed = feeds[index];
  std::unique_ptr<CameraSource> source;
  std::string fault;
  try {
    source = feed.camera.open();
    if (source->size() != feed.size) {
      fault = "camera \"" + feed.camera.name + "\" has " + describe(source->size()) +
              " after reopening; expected " + describe(feed.size) + " as before";
      source.reset();
    }
  } catch (const std::exception& error) {
    fault = error.what();
  }
  const std::lock_guard lock(mutex);
  if (!source) {
    feed.fault = fault;
    return nullptr;
  }
  feed.camera_problem = CameraState::kLive;
  feed.opened_s = feed.same_since_s = secondsNow();
  ++feed.opened;
  return source;
}

void LiveCameras::Shared::readAll(std::size_t index, CameraSource& source) {
  {
    const std::lock_guard lock(mutex);
    if (stopping) return;
    feeds[index].reading = &source;
  }
  source.begin(start);
  LiveImage image;
  for (double capture_s = 0; source.read(image, capture_s); image = {}) {
    {
      const std::lock_guard lock(mutex);
      if (stopping) return;
      feeds[index].times = source.times();  // may have switched to arrival times
    }
    deliver(index, std::move(image), capture_s);
  }
}

void LiveCameras::Shared::deliver(std::size_t index, LiveImage image, double capture_s) {
  const std::uint64_t print = fingerprint(image.bgr);
  const double now_s = secondsNow();
  const std::lock_guard lock(mutex);
  Feed& feed = feeds[index];
  capture_s -= feed.camera.offset_s;
  if (print != feed.last_fingerprint || feed.frames == 0) feed.same_since_s = now_s;
  feed.last_fingerprint = print;
  const double periods = (capture_s - feed.last_capture_s) * feed.rate_hz;
  if (feed.times != TimeOrigin::kArrival && std::isfinite(periods) && periods > 1.5)
    feed.gaps += static_cast<std::uint64_t>(std::lround(periods)) - 1;
  feed.last_capture_s = capture_s;
  feed.lag_s = std::max(kLagDecay * feed.lag_s, now_s - capture_s);
  feed.arrivals_s.push_back(now_s);
  while (now_s - feed.arrivals_s.front() > kRateWindowS) feed.arrivals_s.pop_front();
  const std::uint64_t id = feed.frames++;
  feed.queued.push_back({id, std::move(image), Clock::now()});
  matcher.expect(index, !feed.isStuck(now_s));
  matcher.add(index, capture_s, id);
  trim(index);
  changed.notify_all();
}

void LiveCameras::Shared::trim(std::size_t index) {
  std::deque<Feed::QueuedImage>& queued = feeds[index].queued;
  const std::uint64_t oldest = matcher.oldestWaiting(index);
  while (!queued.empty() && queued.front().id < oldest) queued.pop_front();
}

CameraState LiveCameras::Shared::stateAt(std::size_t index, double now_s) const {
  double others_s = -std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < feeds.size(); ++c)
    if (c != index) others_s = std::max(others_s, feeds[c].last_capture_s);
  return feeds[index].stateAt(now_s, others_s);
}

/// Sets wait only for cameras that can still deliver frames, for as long as the one with the longest lag
/// needs.
void LiveCameras::Shared::updateExpectations(double now_s) {
  double longest_lag_s = 0;
  for (std::size_t c = 0; c < feeds.size(); ++c) {
    const CameraState state = stateAt(c, now_s);
    const bool delivers = state == CameraState::kLive || state == CameraState::kLate;
    // Frames queued before a camera ended or failed are still used in order.
    const bool has_queued = sets == LiveOptions::Sets::kEvery || state == CameraState::kEnded
                                ? !feeds[c].isStuck(now_s) && matcher.waiting(c) > 0
                                : false;
    matcher.expect(c, delivers || has_queued);
    trim(c);
    if (delivers) longest_lag_s = std::max(longest_lag_s, feeds[c].lag_s);
  }
  matcher.setPatience(std::clamp(longest_lag_s + kLagMarginS, patience_s, kMaxPatienceS));
}

LiveSet LiveCameras::Shared::take(const FrameMatcher::Set& match) {
  LiveSet set;
  set.camera_times_s = match.times_s;
  set.skew_s = match.skew_s;
  set.complete = match.complete;
  set.images.resize(feeds.size());
  int count = 0;
  for (const double time_s : match.times_s)
    if (!std::isnan(time_s)) set.time_s += time_s, ++count;
  set.time_s /= count;
  for (std::size_t c = 0; c < feeds.size(); ++c) {
    if (!match.ids[c]) continue;
    feeds[c].skew_s = match.times_s[c] - set.time_s;
    for (Feed::QueuedImage& queued : feeds[c].queued)
      if (queued.id == *match.ids[c]) {
        set.images[c] = std::move(queued.image);
        set.arrived_at = std::max(set.arrived_at, queued.arrived_at);
      }
    trim(c);
  }
  return set;
}

/// Whether all sources are files that have ended, and no queued frame can come into a set.
bool LiveCameras::Shared::isOver(double now_s) const {
  double last_s = -std::numeric_limits<double>::infinity();
  for (const Feed& feed : feeds) {
    if (feed.camera_problem != CameraState::kEnded) return false;
    last_s = std::max(last_s, feed.last_capture_s);
  }
  const bool may_match = sets == LiveOptions::Sets::kEvery || now_s - last_s <= 2 * patience_s;
  return matcher.empty() || !may_match;
}

// -------------------------------------------------------------------------------------------- LiveCameras

LiveCameras::LiveCameras(std::vector<LiveCamera> cameras, const LiveOptions& options) {
  std::vector<std::unique_ptr<CameraSource>> sources;
  double slowest_hz = std::numeric_limits<double>::infinity();
  std::size_t bytes = 0;  // per set
  for (const LiveCamera& camera : cameras) {
    sources.push_back(camera.open());
    slowest_hz = std::min(slowest_hz, sources.back()->rateHz());
    const ImageSize size = sources.back()->size();
    bytes += 3 * std::size_t(size.width) * std::size_t(size.height);
  }
  const bool every = options.sets == LiveOptions::Sets::kEvery;
  FrameMatcher::Options matching;
  matching.max_skew_s = options.max_skew_s.value_or((every ? 1 : 0.5) / slowest_hz);
  matching.patience_s = options.patience_s.value_or(every ? 0.5 : 0.1);
  matching.queue_frames = std::clamp(kMaxBytes / std::max<std::size_t>(bytes, 1), kMinFrames,
                                     every ? kEveryFrames : kNewestFrames);
  shared_ = std::make_shared<Shared>(cameras.size(), matching);
  shared_->sets = options.sets;
  shared_->start =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kLeadS));
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    Feed& feed = shared_->feeds[c];
    feed.camera = std::move(cameras[c]);
    feed.size = sources[c]->size();
    feed.rate_hz = sources[c]->rateHz();
    feed.times = sources[c]->times();
    feed.opened_s = feed.same_since_s = secondsNow();
    feed.opened = 1;
  }
  for (std::size_t c = 0; c < sources.size(); ++c)
    threads_.emplace_back([shared = shared_, c, source = std::move(sources[c])]() mutable {
      shared->run(c, std::move(source));
    });
}

LiveCameras::~LiveCameras() {
  std::unique_lock lock(shared_->mutex);
  shared_->stopping = true;
  for (const Feed& feed : shared_->feeds)
    if (feed.reading) feed.reading->stop();
  shared_->changed.notify_all();
  const auto allDone = [&] {
    return std::all_of(shared_->feeds.begin(), shared_->feeds.end(), [](const Feed& f) { return f.done; });
  };
  shared_->changed.wait_for(lock, std::chrono::duration<double>(kEndS), allDone);
  for (std::size_t c = 0; c < threads_.size(); ++c) {
    if (!shared_->feeds[c].done) {
      threads_[c].detach();
      continue;
    }
    lock.unlock();
    threads_[c].join();
    lock.lock();
  }
}

std::optional<LiveSet> LiveCameras::next(double wait_s) {
  Shared& shared = *shared_;
  const double until_s = secondsNow() + wait_s;
  std::unique_lock lock(shared.mutex);
  for (;;) {
    const double now_s = secondsNow();
    shared.updateExpectations(now_s);
    const bool every = shared.sets == LiveOptions::Sets::kEvery;
    if (const auto match = every ? shared.matcher.next(now_s) : shared.matcher.newest(now_s))
      return shared.take(*match);
    if (now_s >= until_s || shared.isOver(now_s)) return std::nullopt;
    // States and patience also change while no image arrives.
    shared.changed.wait_for(lock, std::chrono::duration<double>(std::min(until_s - now_s, kUpdateS)));
  }
}

bool LiveCameras::ended() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->isOver(secondsNow());
}

std::vector<CameraStatus> LiveCameras::status() const {
  const std::lock_guard lock(shared_->mutex);
  const double now_s = secondsNow();
  std::vector<CameraStatus> all;
  for (std::size_t c = 0; c < shared_->feeds.size(); ++c) {
    CameraStatus one = shared_->feeds[c].statusAt(now_s);
    one.state = shared_->stateAt(c, now_s);
    one.drops += shared_->matcher.dropped(c);
    all.push_back(one);
  }
  return all;
}

std::optional<double> LiveCameras::excessSkew() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->matcher.excessSkew();
}

double LiveCameras::maxSkew() const {
  return shared_->max_skew_s;
}

double LiveCameras::slowestRateHz() const {
  double slowest_hz = std::numeric_limits<double>::infinity();
  for (const CameraStatus& camera : status()) slowest_hz = std::min(slowest_hz, camera.rate_hz);
  return slowest_hz;
}

void LiveCameras::setOffsets(const std::vector<double>& offsets_s) {
  const std::lock_guard lock(shared_->mutex);
  for (std::size_t c = 0; c < offsets_s.size() && c < shared_->feeds.size(); ++c)
    shared_->feeds[c].camera.offset_s = offsets_s[c];
}

LiveCamera liveCamera(const NamedSource& camera, const SourceOptions& options, double offset_s) {
  return {camera.name, [camera, options] { return openSource(camera, options); }, offset_s};
}

const char* nameOf(CameraState state) {
  switch (state) {
    case CameraState::kLive:
      return "live";
    case CameraState::kLate:
      return "late";
    case CameraState::kFrozen:
      return "frozen";
    case CameraState::kLost:
      return "lost";
    case CameraState::kReconnecting:
      return "reconnecting";
    default:
      return "ended";
  }
}

std::vector<NamedSource> inOrderOf(const Rig& rig, const std::vector<NamedSource>& sources) {
  std::string names;
  for (const Camera& camera : rig.cameras) names += (names.empty() ? "" : ", ") + camera.name;
  std::vector<NamedSource> ordered;
  for (const Camera& camera : rig.cameras) {
    const auto found = std::find_if(sources.begin(), sources.end(),
                                    [&](const NamedSource& source) { return source.name == camera.name; });
    if (found == sources.end())
      throw Error(
          "the rig's camera \"" + camera.name + "\" has no source; give --camera " + camera.name + "=SOURCE",
          Fault::kUsage);
    ordered.push_back(*found);
  }
  for (const NamedSource& source : sources)
    if (std::none_of(rig.cameras.begin(), rig.cameras.end(),
                     [&](const Camera& camera) { return camera.name == source.name; }))
      throw Error(
          "--camera " + source.name + "=...: the rig has no camera with this name; expected one of " + names,
          Fault::kUsage);
  return ordered;
}

void checkSizes(const Rig& rig, const LiveCameras& cameras) {
  const std::vector<CameraStatus> all = cameras.status();
  for (std::size_t c = 0; c < all.size() && c < rig.cameras.size(); ++c) {
    const ImageSize expected{rig.cameras[c].width, rig.cameras[c].height};
    if (all[c].size != expected)
      throw Error("camera \"" + all[c].name + "\" has " + describe(all[c].size) + "; expected the rig's " +
                  describe(expected));
  }
}

}  // namespace airclay
