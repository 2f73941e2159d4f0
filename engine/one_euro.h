// SPDX-License-Identifier: MIT
// A steady hand: the One Euro filter of Casiez, Roussel and Vogel 2012, "1€ Filter: A Simple Speed-based
// Low-pass Filter for Noisy Input in Interactive Systems" (CHI '12), for a rigid pose. A low pass whose
// cutoff rises with speed: a hand at rest doesn't tremble, a fast one isn't late.
#pragma once

#include <optional>

#include "engine/math.h"

namespace airclay {

/// f_c = f_c,min + beta speed. Chosen by measurement, samples at 30 Hz. A still hand before the demo's
/// cameras trembles by 0.07 to 0.21 mm and 0.04 to 0.13 degrees (standard deviations along the worst axis):
/// 0.02 to 0.05 mm and 0.01 to 0.03 degrees are left. Of white noise of 0.33 mm and 0.3 degrees, which is
/// what the tracker has on moving hands in compressed videos, 0.09 mm and 0.1 degrees. At 0.3 m/s the
/// position is 4 ms late, at 1 rad/s the rotation 11 ms.
struct OneEuroOptions {
  double rest_cutoff_hz = 0.3;  ///< f_c,min of the position; higher: a hand at rest trembles
  /// beta of the position. In steady motion the hand is at most 1 / (2 pi beta) = 1.2 mm behind, at any
  /// speed: about the tracker's own error. Higher: tremor counts as speed.
  double cutoff_hz_per_m_s = 130;
  double turn_rest_cutoff_hz = 0.2;  ///< f_c,min of the rotation
  /// beta of the rotation: at most 0.65 degrees behind, 2 mm at the fingertips.
  double turn_cutoff_hz_per_rad_s = 14;
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
