// SPDX-License-Identifier: MIT
// Matches the frames of several cameras by capture time. Uses only times and ids, no images, threads or
// clocks, so its results are deterministic.
//
// A *set* has one frame per camera; their times differ by at most the maximum skew. A set waits for late
// cameras up to the patience; after that it is returned without them, marked incomplete, if it has at least
// two cameras (one camera cannot carve). Sets neither wait for nor contain cameras that are not expected
// (frozen, lost).
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

namespace airclay {

class FrameMatcher {
 public:
  struct Options {
    double max_skew_s = 0.5 / 30;  ///< half a frame at 30 Hz: 17 mm at 1 m/s
    double patience_s = 0.1;       ///< how long after its first capture time a set waits for late cameras
    std::size_t queue_frames = 4;  ///< queue length per camera; a full queue drops its oldest frame
  };
  FrameMatcher(std::size_t cameras, const Options& options);

  /// Queues a camera's next frame, if the camera is expected. `id`: any number larger than the camera's
  /// previous one. False, and not queued, if `time_s` does not exceed the camera's previous time.
  bool add(std::size_t camera, double time_s, std::uint64_t id);
  /// Sets whether sets wait for the camera. If not, discards its queue.
  void expect(std::size_t camera, bool expected);
  bool expected(std::size_t camera) const { return cameras_[camera].expected; }

  void setPatience(double patience_s) { options_.patience_s = patience_s; }

  struct Set {
    std::vector<std::optional<std::uint64_t>> ids;  ///< one per camera; empty if missing
    std::vector<double> times_s;                    ///< one per camera; NaN if missing
    double skew_s = 0;                              ///< latest - earliest time
    bool complete = false;                          ///< no camera is missing, not even an unexpected one
  };

  /// The newest set with all expected cameras; discards older frames. If there is none, the newest incomplete
  /// set whose patience has expired at `now_s`. Sets are in order of time.
  std::optional<Set> newest(double now_s);

  /// The next set in order of time, skipping none. Drops a frame only if it fits into no set or if a set
  /// without it has a smaller skew. Decides one frame later than newest(), because the next frame may fit
  /// better.
  std::optional<Set> next(double now_s);

  /// The number of frames dropped because the queue was full or no other frame matched.
  std::uint64_t dropped(std::size_t camera) const { return cameras_[camera].dropped; }
  /// The oldest id that can still come into a set; the last id + 1 if the queue is empty.
  std::uint64_t oldestWaiting(std::size_t camera) const;
  /// The length of the camera's queue.
  std::size_t waiting(std::size_t camera) const { return cameras_[camera].waiting.size(); }
  bool empty() const;
  /// The skew of the best match of all expected cameras if it exceeds max_skew_s; empty while there are sets.
  std::optional<double> excessSkew() const { return excess_skew_s_; }

 private:
  struct Frame {
    double time_s;
    std::uint64_t id;
  };
  struct Camera {
    std::deque<Frame> waiting;
    double last_time_s, period_s;  ///< -infinity and infinity until known
    std::uint64_t next_id = 0;
    std::uint64_t dropped = 0;
    bool expected = true;
  };

  using Frames = std::vector<std::optional<Frame>>;  ///< one per camera

  /// The oldest queued frame of each camera.
  struct Heads {
    Frames frames;
    std::vector<std::size_t> order;  ///< the cameras with a frame, earliest first
    double first_s = 0, last_s = 0;
    bool lacks_one = false;  ///< an expected camera has no frame
  };
  /// The tightest match after replacing the `early` earliest heads by their cameras' next frames.
  struct Advance {
    std::size_t early = 0;
    double skew_s = std::numeric_limits<double>::infinity();
    bool unknown = false;  ///< depends on a frame that has not arrived
  };
  Heads findHeads() const;
  Advance bestAdvance(const Heads& heads) const;
  bool mayBeTighter(double first_s, double last_s) const;
  Set setOf(const Frames& frames) const;
  /// Each camera's last frame in [anchor_s - max_skew_s, anchor_s].
  Frames framesBefore(double anchor_s) const;
  void discard(const Frames& used);
  Set take(const Frames& frames);
  void updateExcessSkew();
  std::size_t expectedCount() const;

  Options options_;
  std::vector<Camera> cameras_;
  std::optional<double> excess_skew_s_;
};

}  // namespace airclay
