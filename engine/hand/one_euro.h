// SPDX-License-Identifier: MIT
// A steady hand: the One Euro filter of Casiez, Roussel and Vogel 2012, "1€ Filter: A Simple Speed-based
// Low-pass Filter for Noisy Input in Interactive Systems" (CHI '12), for a rigid pose. A low pass whose
// cutoff rises with speed: a hand at rest doesn't tremble, a fast one isn't late.
#pragma once

#include <optional>

#include "engine/core/math.h"

namespace airclay {

/// f_c = f_c,min + beta v^2 / (v + tremor): the paper's f_c,min + beta v, but that the speed v which tremor
/// feigns at rest counts little, so that beta can be larger. Chosen by measurement, samples at 30 Hz. Of
/// white noise of 0.33 mm and 0.3 degrees along each axis, more than the tracker has on a still hand, 0.09 mm
/// and 0.09 degrees are left. In a recording of a hand at 0.12 to 0.3 m/s the pose is 1.68 mm and 1.02
/// degrees off the truth (RMS), where it is 1.49 mm and 0.92 degrees without the filter, and 2.35 mm and 1.26
/// degrees with the paper's law and as little tremor. At 0.3 m/s the position is 1.4 ms late, at 1 rad/s the
/// rotation 6 ms.
struct OneEuroOptions {
  double rest_cutoff_hz = 0.3;  ///< f_c,min of the position; higher: a hand at rest trembles
  /// beta of the position. In steady motion the hand is at most 0.9 mm behind, at any speed: less than the
  /// tracker's own error. Higher: tremor counts as speed.
  double cutoff_hz_per_m_s = 400;
  double turn_rest_cutoff_hz = 0.2;  ///< f_c,min of the rotation
  /// beta of the rotation: at most 0.7 degrees behind, 2 mm at the fingertips.
  double turn_cutoff_hz_per_rad_s = 30;
  /// Four times what the noise of a hand at rest feigns. Higher: a slow hand is late.
  double tremor_m_s = 0.01, tremor_rad_s = 0.1;
  double speed_cutoff_hz = 1;  ///< f_c,d of the low pass that both velocities go through: the paper's
};

/// Smooths world_from_hand, sample by sample.
class OneEuroPose {
 public:
  explicit OneEuroPose(const OneEuroOptions& options = {}) : options_(options) {}

  /// The smoothed pose at `time_s`. The first after a reset is `measured` itself. Samples may come at any
  /// pace; one that isn't later than the last changes nothing but the time that the next is counted from.
  Pose filter(double time_s, const Pose& measured);
  /// Tracking was lost: the next sample starts anew.
  void reset() { last_.reset(); }

  /// How far the smoothed position is behind the hand, seconds: on steady motion exactly the time constant
  /// 1 / (2 pi f_c); never more than the time since the first sample. 0 before it.
  double latencyS() const;
  /// How fast the hand moves, as the filter believes it.
  double speedMetresS() const { return last_ ? last_->velocity_m_s.norm() : 0; }
  /// The same of the rotation.
  double turnLatencyS() const;

 private:
  struct State {
    double time_s = 0, age_s = 0;
    Vec3 measured = Vec3::Zero(), smooth = Vec3::Zero();
    Eigen::Quaterniond measured_turn = Eigen::Quaterniond::Identity();
    Eigen::Quaterniond smooth_turn = Eigen::Quaterniond::Identity();
    Vec3 velocity_m_s = Vec3::Zero(), turn_rad_s = Vec3::Zero();  ///< smoothed
    double cutoff_hz = 0, turn_cutoff_hz = 0;
  };
  void follow(State& state, double step_s, const Vec3& position, const Eigen::Quaterniond& turn) const;

  OneEuroOptions options_;
  std::optional<State> last_;
};

}  // namespace airclay
