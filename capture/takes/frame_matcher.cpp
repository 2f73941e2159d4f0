// SPDX-License-Identifier: MIT
#include "capture/takes/frame_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airclay {
namespace {

template <class Frame>
std::size_t countOf(const std::vector<std::optional<Frame>>& frames) {
  return static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [](const auto& frame) { return frame.has_value(); }));
}

}  // namespace

FrameMatcher::FrameMatcher(std::size_t cameras, const Options& options) : options_(options) {
  options_.queue_frames = std::max<std::size_t>(options_.queue_frames, 2);
  cameras_.resize(cameras);
  for (Camera& camera : cameras_) {
    camera.period_s = std::numeric_limits<double>::infinity();
    camera.last_time_s = -camera.period_s;
  }
}

bool FrameMatcher::add(std::size_t camera, double time_s, std::uint64_t id) {
  Camera& of = cameras_[camera];
  of.next_id = id + 1;
  if (!(time_s > of.last_time_s)) return false;
  if (std::isfinite(of.last_time_s)) of.period_s = time_s - of.last_time_s;
  of.last_time_s = time_s;
  if (!of.expected) return true;
  of.waiting.push_back({time_s, id});
  if (of.waiting.size() > options_.queue_frames) {
    of.waiting.pop_front();
    ++of.dropped;
  }
  return true;
}

void FrameMatcher::expect(std::size_t camera, bool expected) {
  cameras_[camera].expected = expected;
  if (!expected) cameras_[camera].waiting.clear();
}

std::size_t FrameMatcher::expectedCount() const {
  return static_cast<std::size_t>(
      std::count_if(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return camera.expected; }));
}

std::uint64_t FrameMatcher::oldestWaiting(std::size_t camera) const {
  const Camera& of = cameras_[camera];
  return of.waiting.empty() ? of.next_id : of.waiting.front().id;
}

bool FrameMatcher::empty() const {
  return std::all_of(cameras_.begin(), cameras_.end(),
                     [](const Camera& camera) { return camera.waiting.empty(); });
}

FrameMatcher::Set FrameMatcher::setOf(const Frames& frames) const {
  Set set;
  double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;
  for (const std::optional<Frame>& frame : frames) {
    set.ids.push_back(frame ? std::optional(frame->id) : std::nullopt);
    set.times_s.push_back(frame ? frame->time_s : std::numeric_limits<double>::quiet_NaN());
    if (!frame) continue;
    first_s = std::min(first_s, frame->time_s);
    last_s = std::max(last_s, frame->time_s);
  }
  set.skew_s = last_s - first_s;
  set.complete = countOf(frames) == cameras_.size();
  return set;
}

FrameMatcher::Frames FrameMatcher::framesBefore(double anchor_s) const {
  Frames frames;
  for (const Camera& camera : cameras_) {
    frames.emplace_back();
    for (const Frame& frame : camera.waiting)
      if (frame.time_s <= anchor_s && frame.time_s >= anchor_s - options_.max_skew_s) frames.back() = frame;
  }
  return frames;
}

/// Removes used and older frames. Of a camera that is not in the set, removes the frames that are too old for
/// any later set.
void FrameMatcher::discard(const Frames& used) {
  double last_s = -std::numeric_limits<double>::infinity();
  for (const std::optional<Frame>& frame : used)
    if (frame) last_s = std::max(last_s, frame->time_s);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    const double until_s = used[c] ? used[c]->time_s : last_s - options_.max_skew_s;
    std::deque<Frame>& waiting = cameras_[c].waiting;
    while (!waiting.empty() && waiting.front().time_s <= until_s) waiting.pop_front();
  }
}

/// Computes the smallest skew above the maximum among matches of all expected cameras.
void FrameMatcher::updateExcessSkew() {
  excess_skew_s_.reset();
  for (const Camera& anchor : cameras_)
    for (const Frame& last : anchor.waiting) {
      double first_s = last.time_s;
      bool all = true;
      for (const Camera& camera : cameras_) {
        double nearest_s = -std::numeric_limits<double>::infinity();
        for (const Frame& frame : camera.waiting)
          if (frame.time_s <= last.time_s) nearest_s = frame.time_s;
        if (camera.expected) all &= std::isfinite(nearest_s), first_s = std::min(first_s, nearest_s);
      }
      const double skew_s = last.time_s - first_s;
      if (all && skew_s > options_.max_skew_s)
        excess_skew_s_ = std::min(skew_s, excess_skew_s_.value_or(skew_s));
    }
}

/// Whether a set with this time span could become tighter: it exceeds half a period, and the next frame of
/// its earliest camera has not arrived.
bool FrameMatcher::mayBeTighter(double first_s, double last_s) const {
  double period_s = std::numeric_limits<double>::infinity();
  for (const Camera& camera : cameras_) period_s = std::min(period_s, camera.period_s);
  const auto isFirst = [&](const Camera& camera) {
    return !camera.waiting.empty() && camera.waiting.back().time_s == first_s;
  };
  return last_s - first_s > 0.5 * period_s && std::any_of(cameras_.begin(), cameras_.end(), isFirst);
}

std::optional<FrameMatcher::Set> FrameMatcher::newest(double now_s) {
  std::vector<double> anchors_s;
  for (const Camera& camera : cameras_)
    for (const Frame& frame : camera.waiting) anchors_s.push_back(frame.time_s);
  std::sort(anchors_s.rbegin(), anchors_s.rend());
  const std::size_t expected = expectedCount(), min_count = std::min<std::size_t>(2, cameras_.size());
  for (const bool all : {true, false}) {
    for (const double anchor_s : anchors_s) {
      const Frames frames = framesBefore(anchor_s);
      const std::size_t count = countOf(frames);
      if (count < min_count || (all && count < expected)) continue;
      const double first_s = anchor_s - setOf(frames).skew_s;
      const bool waits = now_s - first_s < options_.patience_s;
      if (waits && (!all || mayBeTighter(first_s, anchor_s))) continue;
      if (all) excess_skew_s_.reset();
      return take(frames);
    }
    if (all) updateExcessSkew();
  }
  return std::nullopt;
}

std::optional<FrameMatcher::Set> FrameMatcher::next(double now_s) {
  const std::size_t min_count = std::min<std::size_t>(2, cameras_.size());
  const double max_skew_s = options_.max_skew_s;
  for (;;) {
    const Heads heads = findHeads();
    if (heads.order.empty()) return std::nullopt;
    const bool waits = now_s - heads.first_s < options_.patience_s;
    if (heads.lacks_one && waits) return std::nullopt;
    std::size_t leaving = 0;  // the number of earliest heads to separate from the others; 0: no tighter match
    if (!heads.lacks_one && heads.order.size() >= min_count) {
      const double skew_s = heads.last_s - heads.first_s;
      const bool fits = skew_s <= max_skew_s;
      // Prefer the next frames of the early cameras only if they are tighter by half the maximum skew.
      // Otherwise, cameras half a period apart would lose a frame whenever their times jitter.
      Advance advance;
      if (skew_s > 0.5 * max_skew_s) advance = bestAdvance(heads);
      if (advance.unknown && waits) return std::nullopt;
      const bool better =
          advance.skew_s <= max_skew_s && (!fits || advance.skew_s < skew_s - 0.5 * max_skew_s);
      if (fits && !better) {
        excess_skew_s_.reset();
        return take(heads.frames);
      }
      if (better) leaving = advance.early;
      if (!better) excess_skew_s_ = std::min(skew_s, advance.skew_s);
    }
    // A camera missed this instant: return the set without it.
    Frames together(cameras_.size());
    for (std::size_t i = 0; i < heads.order.size(); ++i) {
      const std::size_t c = heads.order[i];
      const bool leaves = leaving == 0 || i < leaving;
      if (leaves && heads.frames[c]->time_s <= heads.first_s + max_skew_s) together[c] = heads.frames[c];
    }
    if (countOf(together) >= min_count) return take(together);
    cameras_[heads.order[0]].waiting.pop_front();
    ++cameras_[heads.order[0]].dropped;
  }
}

FrameMatcher::Set FrameMatcher::take(const Frames& frames) {
  discard(frames);
  return setOf(frames);
}

FrameMatcher::Heads FrameMatcher::findHeads() const {
  Heads heads;
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    const Camera& camera = cameras_[c];
    heads.frames.emplace_back();
    if (camera.waiting.empty()) {
      heads.lacks_one |= camera.expected;
      continue;
    }
    heads.frames[c] = camera.waiting.front();
    heads.order.push_back(c);
  }
  std::sort(heads.order.begin(), heads.order.end(),
            [&](std::size_t a, std::size_t b) { return heads.frames[a]->time_s < heads.frames[b]->time_s; });
  if (heads.order.empty()) return heads;
  heads.first_s = heads.frames[heads.order.front()]->time_s;
  heads.last_s = heads.frames[heads.order.back()]->time_s;
  return heads;
}

/// Tries to replace the heads of the 1, 2, ... earliest cameras by their next frames.
FrameMatcher::Advance FrameMatcher::bestAdvance(const Heads& heads) const {
  Advance advance;
  double next_first_s = std::numeric_limits<double>::infinity(), next_last_s = -next_first_s;
  for (std::size_t early = 1; early < heads.order.size(); ++early) {
    const std::deque<Frame>& waiting = cameras_[heads.order[early - 1]].waiting;
    if (waiting.size() < 2) {
      advance.unknown = waiting.front().time_s < heads.last_s - 0.5 * options_.max_skew_s;
      return advance;
    }
    next_first_s = std::min(next_first_s, waiting[1].time_s);
    next_last_s = std::max(next_last_s, waiting[1].time_s);
    const double first_s = std::min(next_first_s, heads.frames[heads.order[early]]->time_s);
    const double skew_s = std::max(next_last_s, heads.last_s) - first_s;
    if (skew_s < advance.skew_s) advance.skew_s = skew_s, advance.early = early;
  }
  return advance;
}

}  // namespace airclay
