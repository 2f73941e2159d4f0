// SPDX-License-Identifier: MIT
// What LiveCameras knows of one of its cameras, and the state that follows from it.
#pragma once

#include <deque>
#include <limits>

#include "capture/cameras/live_cameras.h"

namespace airclay {

/// Rates are measured over so long.
inline constexpr double kRateWindowS = 2;

/// What is known of one camera.
struct Feed {
  struct Kept {
    std::uint64_t id;
    LiveImage image;
    Clock::time_point arrived_at;
  };
  LiveCamera camera;
  ImageSize size;
  double rate_hz = 30;
  TimeOrigin times = TimeOrigin::kArrival;

  CameraState camera_problem = CameraState::kLive;  ///< kLost, kReconnecting, kEnded, or none
  bool done = false;                                ///< its thread has ended
  CameraSource* reading = nullptr;                  ///< what its thread reads from now
  std::deque<Kept> kept;                            ///< images whose frames wait in the matcher
  std::uint64_t frames = 0, gaps = 0;
  int opened = 0;
  double opened_s = 0;
  double last_capture_s = -std::numeric_limits<double>::infinity();
  std::deque<double> arrivals_s;  ///< of the last seconds
  std::uint64_t last_fingerprint = 0;
  double same_since_s = 0;
  double skew_s = 0;
  double lag_s = 0;  ///< from its capture to here: the longest, fading over some seconds
  std::string fault;

  double measuredHz(double now_s) const;
  CameraState stateAt(double now_s, double others_capture_s) const;
  bool isStuck(double now_s) const;
  /// All but what is a matter of the other cameras: the state and what the matcher dropped.
  CameraStatus statusAt(double now_s) const;
};

/// Tells equal images from others.
std::uint64_t fingerprint(const std::vector<std::uint8_t>& bytes);

}  // namespace airclay
