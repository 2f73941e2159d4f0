// SPDX-License-Identifier: MIT
// Puts the frames of several cameras together by the times at which they were taken. Knows no images,
// threads or clocks: who feeds it times can tell exactly what comes out.
//
// A *set* is one frame of each camera whose times differ by at most the allowed skew. A camera that is
// expected may be waited for, up to the patience; after that the set is given without it, marked incomplete,
// if two cameras at least are in it (one alone carves nothing). Cameras that are not expected (frozen, lost)
// are never waited for, and not part of sets.
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
    double max_skew_s = 0.5 / 30;  ///< half a frame: at 1 m/s, 17 mm
    double patience_s = 0.1;       ///< how long after its frames were taken a set waits for a late camera
    std::size_t queue_frames = 4;  ///< a camera's frames that wait to be matched; the oldest gives way
  };
  FrameMatcher(std::size_t cameras, const Options& options);

  /// A camera's next frame; `id` is the caller's and grows. A time that is not after the camera's last one is
  /// refused: false.
  bool add(std::size_t camera, double time_s, std::uint64_t id);
  /// Whether sets wait for the camera. One that is not expected loses the frames that it has waiting.
  void expect(std::size_t camera, bool expected);
  bool expected(std::size_t camera) const { return cameras_[camera].expected; }

  void setPatience(double patience_s) { options_.patience_s = patience_s; }

  struct Set {
    std::vector<std::optional<std::uint64_t>> ids;  ///< one a camera; none: it is missing
    std::vector<double> times_s;                    ///< one a camera; NaN where it is missing
    double skew_s = 0;                              ///< latest time - earliest
    bool complete = false;                          ///< every camera is there, unexpected ones too
  };

  /// The newest set that there is, all expected cameras in it; older frames are passed over. Else, where
  /// `now_s` is past the patience of some frames, the newest incomplete one. Sets come in order of time.
  std::optional<Set> newest(double now_s);

  /// The next set in order, none left out: a frame is dropped only when it fits into no set, or another set
  /// would be tighter. Decides one frame later than newest(), as the next frame may fit better.
  std::optional<Set> next(double now_s);

  /// Frames of this camera that came into no set because the queue was full, or nothing matched them.
  std::uint64_t dropped(std::size_t camera) const { return cameras_[camera].dropped; }
  /// The oldest id that may still come into a set; what is older need not be kept. One past the last added
  /// where none waits.
  std::uint64_t oldestWaiting(std::size_t camera) const;
  /// How many frames wait to be matched.
  std::size_t waiting(std::size_t camera) const { return cameras_[camera].waiting.size(); }
  bool empty() const;
  /// Where frames of all expected cameras came but were too far apart: their skew, which max_skew_s would
  /// have to be. None while sets are found.
  std::optional<double> refusedSkew() const { return refused_skew_s_; }

 private:
  struct Frame {
    double time_s;
    std::uint64_t id;
  };
  struct Camera {
    std::deque<Frame> waiting;
    double last_time_s, period_s;  ///< infinite before they are known
    std::uint64_t next_id = 0;
    std::uint64_t dropped = 0;
    bool expected = true;
  };

  using Frames = std::vector<std::optional<Frame>>;  ///< one a camera

  /// The oldest waiting frames.
  struct Heads {
    Frames frames;
    std::vector<std::size_t> order;  ///< the cameras that have one, earliest first
    double first_s = 0, last_s = 0;
    bool lacks_one = false;  ///< an expected camera has none
  };
  /// What would be had if the `early` earliest heads left.
  struct Later {
    std::size_t early = 0;
    double skew_s = std::numeric_limits<double>::infinity();
    bool unknown = false;  ///< a frame that would decide has not come
  };
  Heads theHeads() const;
  Later laterOf(const Heads& heads) const;
  bool mayBeTighter(double first_s, double last_s) const;
  Set setOf(const Frames& frames) const;
  /// Of each camera the last frame not after `anchor_s` and within the skew of it.
  Frames around(double anchor_s) const;
  void forget(const Frames& used);
  Set give(const Frames& frames);
  void noteRefused();
  std::size_t expectedCount() const;

  Options options_;
  std::vector<Camera> cameras_;
  std::optional<double> refused_skew_s_;
};

}  // namespace airclay
