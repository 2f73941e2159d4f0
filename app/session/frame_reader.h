// SPDX-License-Identifier: MIT
// Reads a recording on its own thread, one frame set at a time, when it is requested and due; reading earlier
// would add latency. The consumer requests the next set while the last image is being drawn.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "capture/takes/recording.h"
#include "engine/core/clock.h"

namespace airclay {

/// The images or masks of all cameras at one instant.
struct FrameSet {
  int frame = 0;
  double time_s = 0;              ///< on the recording's clock
  Clock::time_point captured_at;  ///< when the frame was due, and its decoding began
  double decode_ms = 0;
  std::vector<double> camera_times_s;            ///< empty if the cameras have no timestamps
  std::uint32_t missing_cameras = 0;             ///< bit mask of cameras without an image
  std::vector<std::string> camera_problems;      ///< problems of the cameras
  std::vector<std::vector<std::uint8_t>> bytes;  ///< one per camera: BGR or mask bytes
};

class FrameReader {
 public:
  /// Reads frames in order, without skipping. If `paced`, not faster than the recording's rate; otherwise as
  /// fast as they are taken. `recording` must outlive this.
  explicit FrameReader(Recording& recording, bool paced = true);
  ~FrameReader();

  /// Requests the next set, which is read now or when it is due.
  void ask();
  /// Exchanges `set` with the next one; false if there is none within `wait_s`. Rethrows reading errors.
  bool take(FrameSet& set, double wait_s);
  /// Whether all frames have been taken.
  bool atEnd() const;
  /// Restarts at the first frame.
  void restart();
  void pause(bool paused);

 private:
  void run();
  bool waitForRoom();
  Clock::time_point due() const;
  bool read(FrameSet& set);

  Recording& recording_;
  const bool paced_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stop_ = false, paused_ = false, restart_ = false, full_ = false;
  int next_ = 0;  ///< next frame to read
  bool ended_ = false;
  bool asked_ = false;  ///< the next set is requested
  Clock::time_point last_captured_{};
  FrameSet slot_;  ///< valid if full_: read, not yet taken
  std::exception_ptr fault_;
  std::thread thread_;
};

}  // namespace airclay
