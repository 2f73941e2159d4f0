// SPDX-License-Identifier: MIT
#include "capture/cameras/live_recording.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airclay {
namespace {

// The longest wait for a set, so that the caller can check for cancellation.
constexpr double kWaitS = 0.1;

}  // namespace

LiveRecording::LiveRecording(const Rig& rig, std::vector<LiveCamera> cameras, const LiveOptions& options,
                             int background_frames)
    : rig_(rig), cameras_(std::move(cameras), options), background_frames_(background_frames) {
  checkSizes(rig_, cameras_);
}

int LiveRecording::frameCount() const {
  return cameras_.ended() ? taken_.load() : std::numeric_limits<int>::max();
}

double LiveRecording::timeOf(int) const {
  return time_s_;
}

std::vector<double> LiveRecording::cameraTimesOf(int) const {
  return camera_times_s_;
}

std::optional<Clock::time_point> LiveRecording::capturedAt() const {
  if (!first_s_) return std::nullopt;
  return Clock::time_point(
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*first_s_ + time_s_)));
}

bool LiveRecording::readImages(int frame, Buffers bgr) {
  const std::optional<LiveSet> set = cameras_.next(kWaitS);
  if (!set || (!set->complete && frame < background_frames_)) return false;
  if (!first_s_) first_s_ = set->time_s;
  time_s_ = set->time_s - *first_s_;
  camera_times_s_.clear();
  missing_cameras_ = 0;
  for (std::size_t c = 0; c < bgr.size(); ++c) {
    const std::vector<std::uint8_t>& image = set->images[c].bgr;
    const bool present =
        image.size() == bgr[c].size();  // false also if the camera has another size after reopening
    if (present)
      std::copy(image.begin(), image.end(), bgr[c].begin());
    else
      std::fill(bgr[c].begin(), bgr[c].end(), std::uint8_t(0));
    if (!present) missing_cameras_ |= 1u << c;
    camera_times_s_.push_back((present ? set->camera_times_s[c] : set->time_s) - *first_s_);
  }
  ++taken_;
  return true;
}

std::vector<std::string> LiveRecording::cameraProblems() const {
  std::vector<std::string> lines;
  for (const CameraStatus& camera : cameras_.status())
    if (camera.state != CameraState::kLive && camera.state != CameraState::kEnded)
      lines.push_back(camera.name + ": " + nameOf(camera.state));
  if (const std::optional<double> skew = cameras_.excessSkew())
    lines.push_back("images are " + std::to_string(std::lround(1000 * *skew)) +
                    " ms apart; increase --max-skew-ms");
  return lines;
}

}  // namespace airclay
