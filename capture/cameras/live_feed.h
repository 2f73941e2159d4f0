// SPDX-License-Identifier: MIT
// The data of one camera in LiveCameras, and the state derived from it.
#pragma once

#include <deque>
#include <limits>

#include "capture/cameras/live_cameras.h"

namespace airclay {

/// The interval over which rates are measured.
inline constexpr double kRateWindowS = 2;

/// One camera's data.
struct Feed {
  struct QueuedImage {
    std::uint64_t id;
    LiveImage image;
    Clock::time_point arrived_at;
  };
  LiveCamera camera;
  ImageSize size;
  double rate_hz = 30;
  TimeOrigin times = TimeOrigin::kArrival;

  CameraState camera_problem = CameraState::kLive;  ///< kLost, kReconnecting, kEnded; kLive: none
  bool done = false;                                ///< its thread has ended
  CameraSource* reading = nullptr;                  ///< the source that its thread currently reads from
  std::deque<QueuedImage> queued;                   ///< images of the frames queued in the matcher
  std::uint64_t frames = 0, gaps = 0;
  int opened = 0;
  double opened_s = 0;
  double last_capture_s = -std::numeric_limits<double>::infinity();
  std::deque<double> arrivals_s;  ///< of the last seconds
  std::uint64_t last_fingerprint = 0;
  double same_since_s = 0;
  double skew_s = 0;
  double lag_s = 0;  ///< the longest delay from capture to arrival, decaying over some seconds
  std::string fault;

  double measuredHz(double now_s) const;
  CameraState stateAt(double now_s, double others_capture_s) const;
  bool isStuck(double now_s) const;
  /// All fields except those that depend on other cameras: the state, and the frames that the matcher
  /// dropped.
  CameraStatus statusAt(double now_s) const;
};

/// A hash to detect identical images.
std::uint64_t fingerprint(const std::vector<std::uint8_t>& bytes);

}  // namespace airclay
