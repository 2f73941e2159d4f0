// SPDX-License-Identifier: MIT
#include "app/session/frame_reader.h"

#include <utility>

namespace airclay {

FrameReader::FrameReader(Recording& recording, bool paced)
    : recording_(recording), paced_(paced && !recording.isLive()), thread_([this] { run(); }) {}

FrameReader::~FrameReader() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FrameReader::run() {
  FrameSet set;
  try {
    while (waitForRoom()) {
      if (!read(set)) continue;  // live, no image yet
      const std::lock_guard lock(mutex_);
      if (restart_) continue;  // read before the restart
      std::swap(slot_, set);
      last_captured_ = slot_.captured_at;
      full_ = true;
      ++next_;
      changed_.notify_all();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    fault_ = std::current_exception();
    changed_.notify_all();
  }
}

/// When the next frame is due, at the recording's rate.
Clock::time_point FrameReader::due() const {
  if (next_ == 0 || !paced_) return Clock::now();
  const std::chrono::duration<double> interval(1 / recording_.rateHz());
  return last_captured_ + std::chrono::duration_cast<Clock::duration>(interval);
}

bool FrameReader::waitForRoom() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (restart_) {
      restart_ = full_ = ended_ = false;
      next_ = 0;
    }
    ended_ = next_ == recording_.frameCount() && !full_;
    const bool idle = !asked_ || full_ || paused_ || next_ == recording_.frameCount();
    const Clock::time_point when = due();
    if (!idle && Clock::now() >= when) return true;
    if (idle)
      changed_.wait(lock);
    else
      changed_.wait_until(lock, when);
  }
  return false;
}

/// False if a live recording has no image yet. Its times are known only after the images.
bool FrameReader::read(FrameSet& set) {
  set.frame = next_;
  set.captured_at = Clock::now();
  const std::vector<Camera>& cameras = recording_.rig().cameras;
  set.bytes.resize(cameras.size());  // next() exchanged the last set for another
  for (std::size_t c = 0; c < cameras.size(); ++c)
    set.bytes[c].resize(std::size_t(cameras[c].width) * std::size_t(cameras[c].height) *
                        (recording_.hasSilhouettes() ? 1 : 3));
  std::vector<std::span<std::uint8_t>> buffers(set.bytes.begin(), set.bytes.end());
  if (recording_.hasSilhouettes())
    recording_.readSilhouettes(set.frame, buffers);
  else if (!recording_.readImages(set.frame, buffers))
    return false;
  set.decode_ms = recording_.isLive() ? 0 : millisecondsSince(set.captured_at);
  if (const LiveSource* live = recording_.live()) {
    set.captured_at = live->capturedAt().value_or(set.captured_at);
    set.camera_problems = live->cameraProblems();
  }
  set.time_s = recording_.timeOf(set.frame);
  set.camera_times_s = recording_.cameraTimesOf(set.frame);
  set.missing_cameras = recording_.missingCameras();
  return true;
}

void FrameReader::ask() {
  const std::lock_guard lock(mutex_);
  asked_ = true;
  changed_.notify_all();
}

bool FrameReader::take(FrameSet& set, double wait_s) {
  std::unique_lock lock(mutex_);
  asked_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, std::chrono::duration<double>(wait_s), [&] { return full_ || fault_ || ended_; });
  if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
  if (!full_) return false;
  std::swap(slot_, set);
  asked_ = full_ = false;
  changed_.notify_all();
  return true;
}

bool FrameReader::atEnd() const {
  const std::lock_guard lock(mutex_);
  return !full_ && next_ == recording_.frameCount();
}

void FrameReader::restart() {
  const std::lock_guard lock(mutex_);
  restart_ = true;
  full_ = false;
  changed_.notify_all();
}

void FrameReader::pause(bool paused) {
  const std::lock_guard lock(mutex_);
  paused_ = paused;
  changed_.notify_all();
}

}  // namespace airclay
