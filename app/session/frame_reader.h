// SPDX-License-Identifier: MIT
// Reads a recording on a thread of its own, one frame set at a time, when it is asked for and due: what is
// read earlier is late when it is shown. Whoever takes frames asks while the last image is still being
// drawn.
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

/// The images of all cameras at one instant, or their masks.
struct FrameSet {
  int frame = 0;
  double time_s = 0;              ///< the recording's
  Clock::time_point captured_at;  ///< when the frame was due, and its decoding began
  double decode_ms = 0;
  std::vector<double> camera_times_s;            ///< empty where the cameras have none of their own
  std::uint32_t missing_cameras = 0;             ///< bits of cameras without an image
  std::vector<std::string> camera_problems;      ///< what is wrong with the cameras
  std::vector<std::vector<std::uint8_t>> bytes;  ///< one a camera: BGR, or a mask's bytes
};

class FrameReader {
 public:
  /// Frames come in order, none is left out; where `paced`, not faster than the recording itself and not long
  /// before they are wanted, else as fast as they are taken. `recording` must outlive this.
  explicit FrameReader(Recording& recording, bool paced = true);
  ~FrameReader();

  /// The next one will be taken soon: it is read now, or when it is due.
  void ask();
  /// Exchanges `set` with the next one; false when there is none within `wait_s`. \throw what reading threw
  bool take(FrameSet& set, double wait_s);
  /// Whether all frames have been taken.
  bool atEnd() const;
  /// From the first frame on.
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
  int next_ = 0;  ///< frame to be read
  bool ended_ = false;
  bool asked_ = false;  ///< for the next one
  Clock::time_point last_captured_{};
  FrameSet slot_;  ///< read, not taken yet: when full_
  std::exception_ptr fault_;
  std::thread thread_;
};

}  // namespace airclay
