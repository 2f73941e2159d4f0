// SPDX-License-Identifier: MIT
#include "app/studio/frame_reader.h"

#include <utility>

namespace airclay {

FrameReader::FrameReader(Recording& recording) : recording_(recording), thread_([this] { run(); }) {}

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
  for (const Camera& camera : recording_.rig().cameras)
    set.bytes.emplace_back(std::size_t(camera.width) * std::size_t(camera.height) *
                           (recording_.hasSilhouettes() ? 1 : 3));
  slot_.bytes = set.bytes;
  try {
    while (waitForRoom()) {
      read(set);
      const std::lock_guard lock(mutex_);
      if (restart_) continue;  // what was read is of the last round
      std::swap(slot_, set);
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

bool FrameReader::waitForRoom() {
  Clock::time_point due = Clock::now();
  std::unique_lock lock(mutex_);
  if (next_ > 0)
    due = slot_.captured_at +
          std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / recording_.rateHz()));
  while (!stop_) {
    if (restart_) {
      restart_ = full_ = ended_ = false;
      next_ = 0;
      due = Clock::now();
    }
    ended_ = next_ == recording_.frameCount() && !full_;
    const bool idle = full_ || paused_ || next_ == recording_.frameCount();
    if (!idle && Clock::now() >= due) return true;
    if (idle)
      changed_.wait(lock);
    else
      changed_.wait_until(lock, due);
  }
  return false;
}

void FrameReader::read(FrameSet& set) {
  set.frame = next_;
  set.time_s = recording_.timeOf(set.frame);
  set.captured_at = Clock::now();
  std::vector<std::span<std::uint8_t>> buffers(set.bytes.begin(), set.bytes.end());
  if (recording_.hasSilhouettes())
    recording_.readSilhouettes(set.frame, buffers);
  else
    recording_.readPictures(set.frame, buffers);
  set.decode_ms = std::chrono::duration<double, std::milli>(Clock::now() - set.captured_at).count();
}

bool FrameReader::take(FrameSet& set, double wait_s) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(wait_s), [&] { return full_ || fault_ || ended_; });
  if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
  if (!full_) return false;
  std::swap(slot_, set);
  slot_.captured_at = set.captured_at;
  full_ = false;
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
