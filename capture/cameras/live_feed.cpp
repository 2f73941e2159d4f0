// SPDX-License-Identifier: MIT
#include "capture/cameras/live_feed.h"

#include <algorithm>
#include <cstring>

namespace airclay {
namespace {

// A camera that is silent for this long is frozen: at 1 m/s the hand has moved half a metre.
constexpr double kFrozenS = 0.5;
// Sensor noise makes every image different; identical bytes for this long indicate a stuck driver.
constexpr double kSameImageS = 2;
// The time that a camera may take to deliver its first image.
constexpr double kFirstImageS = 3;
// A camera below this fraction of its rate is late.
constexpr double kLateRateFraction = 0.8;

}  // namespace

double Feed::measuredHz(double now_s) const {
  const auto first = std::find_if(arrivals_s.begin(), arrivals_s.end(),
                                  [&](double arrival_s) { return now_s - arrival_s <= kRateWindowS; });
  const auto count = arrivals_s.end() - first;
  if (count < 2) return 0;
  // Includes the time since the last image, so that the rate of a stopped camera falls.
  const double silent_s = std::max(0.0, now_s - arrivals_s.back() - 1 / rate_hz);
  return static_cast<double>(count - 1) / (arrivals_s.back() - *first + silent_s);
}

bool Feed::isStuck(double now_s) const {
  return times != TimeOrigin::kFile && frames > 0 && now_s - same_since_s > kSameImageS;
}

CameraState Feed::stateAt(double now_s, double others_capture_s) const {
  if (camera_problem != CameraState::kLive) return camera_problem;
  const bool has_image = !arrivals_s.empty() && arrivals_s.back() >= opened_s;
  if (!has_image) return now_s - opened_s > kFirstImageS ? CameraState::kFrozen : CameraState::kLive;
  const double silent_s = now_s - arrivals_s.back();
  if (silent_s > std::max(kFrozenS, 2.5 / rate_hz) || isStuck(now_s)) return CameraState::kFrozen;
  const bool rate_known = now_s - opened_s > kRateWindowS;
  const bool slow = rate_known && measuredHz(now_s) < kLateRateFraction * rate_hz;
  const bool behind = others_capture_s - last_capture_s > std::max(kFrozenS, 2.5 / rate_hz);
  return slow || behind || silent_s > std::max(0.1, 2.5 / rate_hz) ? CameraState::kLate : CameraState::kLive;
}

CameraStatus Feed::statusAt(double now_s) const {
  CameraStatus one;
  one.name = camera.name;
  one.size = size;
  one.rate_hz = rate_hz;
  one.measured_hz = measuredHz(now_s);
  one.times = times;
  one.frames = frames;
  one.drops = gaps;
  one.reconnects = opened - 1;
  one.skew_s = skew_s;
  one.fault = fault;
  return one;
}

/// Multiplicative hashing of 8-byte words, with Knuth's constant.
std::uint64_t fingerprint(const std::vector<std::uint8_t>& bytes) {
  std::uint64_t hash = bytes.size();
  for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, &bytes[i], 8);
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace airclay
