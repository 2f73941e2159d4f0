// SPDX-License-Identifier: MIT
// The One Euro filter for a pose (Casiez, Roussel and Vogel 2012). Position and rotation each have a single
// cutoff from their speed: one cutoff per axis would bend the path of a diagonal motion.
#include "engine/hand/one_euro.h"

#include <algorithm>
#include <cmath>

namespace airclay {
namespace {

/// The time constant of a first-order low-pass filter.
double timeConstant(double cutoff_hz) {
  return 1 / (2 * M_PI * cutoff_hz);
}

/// The speed with the effect of tremor reduced: a speed far below the tremor's nearly vanishes, one far above
/// it loses only the tremor's part.
double withoutTremor(double speed, double tremor) {
  return speed > 0 ? speed * speed / (speed + tremor) : 0;
}

/// The weight of the new sample, alpha = 1 / (1 + tau / T_e).
double smoothingFactor(double cutoff_hz, double step_s) {
  return 1 / (1 + timeConstant(cutoff_hz) / step_s);
}

/// The rotation vector from `a` to `b`, along the shorter arc. q and -q are the same rotation.
Vec3 rotationBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  Eigen::Quaterniond turn = b * a.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (sine == 0) return Vec3::Zero();
  return 2 * std::atan2(sine, turn.w()) / sine * turn.vec();
}

}  // namespace

Pose OneEuroPose::filter(double time_s, const Pose& measured) {
  const Vec3 position = measured.translation();
  const Eigen::Quaterniond turn = Eigen::Quaterniond(measured.linear()).normalized();
  if (!last_) {
    last_ = State{};
    last_->smooth = last_->measured = position;
    last_->smooth_rotation = last_->measured_rotation = turn;
  } else if (time_s > last_->time_s) {
    follow(*last_, time_s - last_->time_s, position, turn);
  }
  last_->time_s = time_s;  // also backwards, or a clock set back would stop the filter until it has caught up
  Pose smooth = Pose::Identity();
  smooth.linear() = last_->smooth_rotation.toRotationMatrix();
  smooth.translation() = last_->smooth;
  return smooth;
}

void OneEuroPose::follow(State& state, double step_s, const Vec3& position,
                         const Eigen::Quaterniond& turn) const {
  const double speed_factor = smoothingFactor(options_.speed_cutoff_hz, step_s);
  const Vec3 velocity_m_s = (position - state.measured) / step_s;
  state.velocity_m_s += speed_factor * (velocity_m_s - state.velocity_m_s);
  const Vec3 angular_velocity_rad_s = rotationBetween(state.measured_rotation, turn) / step_s;
  state.angular_velocity_rad_s += speed_factor * (angular_velocity_rad_s - state.angular_velocity_rad_s);
  state.measured = position;
  state.measured_rotation = turn;
  state.age_s += step_s;

  // f_c = f_c,min + beta |speed|, with tremor reduced
  state.cutoff_hz =
      options_.rest_cutoff_hz +
      options_.cutoff_hz_per_m_s * withoutTremor(state.velocity_m_s.norm(), options_.tremor_m_s);
  state.smooth += smoothingFactor(state.cutoff_hz, step_s) * (position - state.smooth);
  state.rotation_cutoff_hz = options_.rotation_rest_cutoff_hz +
                             options_.rotation_cutoff_hz_per_rad_s *
                                 withoutTremor(state.angular_velocity_rad_s.norm(), options_.tremor_rad_s);
  state.smooth_rotation =
      state.smooth_rotation.slerp(smoothingFactor(state.rotation_cutoff_hz, step_s), turn).normalized();
}

double OneEuroPose::latencyS() const {
  return last_ && last_->age_s > 0 ? std::min(timeConstant(last_->cutoff_hz), last_->age_s) : 0;
}

double OneEuroPose::rotationLatencyS() const {
  return last_ && last_->age_s > 0 ? std::min(timeConstant(last_->rotation_cutoff_hz), last_->age_s) : 0;
}

}  // namespace airclay
