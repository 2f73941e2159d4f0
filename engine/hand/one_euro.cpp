// SPDX-License-Identifier: MIT
// The One Euro filter of a pose (Casiez, Roussel and Vogel 2012). A position is one vector and a rotation one
// turn, each with a single cutoff from its speed: a cutoff an axis would bend the path of a slanting motion.
#include "engine/hand/one_euro.h"

#include <algorithm>
#include <cmath>

namespace airclay {
namespace {

/// The time constant of a first-order low pass.
double timeConstant(double cutoff_hz) {
  return 1 / (2 * M_PI * cutoff_hz);
}

/// A speed that is believed: of one much below the tremor's little is left, one far above loses only the
/// tremor's own.
double believed(double speed, double tremor) {
  return speed > 0 ? speed * speed / (speed + tremor) : 0;
}

/// The new sample's share, alpha = 1 / (1 + tau / T_e).
double shareOf(double cutoff_hz, double step_s) {
  return 1 / (1 + timeConstant(cutoff_hz) / step_s);
}

/// The turn from `a` to `b` as axis times angle, the shorter way round. q and -q are the same rotation.
Vec3 turnBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
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
    last_->smooth_turn = last_->measured_turn = turn;
  } else if (time_s > last_->time_s) {
    follow(*last_, time_s - last_->time_s, position, turn);
  }
  last_->time_s = time_s;  // a clock set back does not stop the filter until it has caught up
  Pose smooth = Pose::Identity();
  smooth.linear() = last_->smooth_turn.toRotationMatrix();
  smooth.translation() = last_->smooth;
  return smooth;
}

void OneEuroPose::follow(State& state, double step_s, const Vec3& position,
                         const Eigen::Quaterniond& turn) const {
  const double speed_share = shareOf(options_.speed_cutoff_hz, step_s);
  const Vec3 velocity_m_s = (position - state.measured) / step_s;
  state.velocity_m_s += speed_share * (velocity_m_s - state.velocity_m_s);
  const Vec3 turn_rad_s = turnBetween(state.measured_turn, turn) / step_s;
  state.turn_rad_s += speed_share * (turn_rad_s - state.turn_rad_s);
  state.measured = position;
  state.measured_turn = turn;
  state.age_s += step_s;

  // f_c = f_c,min + beta |speed|, but for the tremor
  state.cutoff_hz = options_.rest_cutoff_hz +
                    options_.cutoff_hz_per_m_s * believed(state.velocity_m_s.norm(), options_.tremor_m_s);
  state.smooth += shareOf(state.cutoff_hz, step_s) * (position - state.smooth);
  state.turn_cutoff_hz =
      options_.turn_rest_cutoff_hz +
      options_.turn_cutoff_hz_per_rad_s * believed(state.turn_rad_s.norm(), options_.tremor_rad_s);
  state.smooth_turn = state.smooth_turn.slerp(shareOf(state.turn_cutoff_hz, step_s), turn).normalized();
}

double OneEuroPose::latencyS() const {
  return last_ && last_->age_s > 0 ? std::min(timeConstant(last_->cutoff_hz), last_->age_s) : 0;
}

double OneEuroPose::turnLatencyS() const {
  return last_ && last_->age_s > 0 ? std::min(timeConstant(last_->turn_cutoff_hz), last_->age_s) : 0;
}

}  // namespace airclay
