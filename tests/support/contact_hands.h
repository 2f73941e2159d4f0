// SPDX-License-Identifier: MIT
// Simple solids as hands, and a hand's place as the fit leaves it.
#pragma once

#include "engine/hand/hand_model.h"
#include "engine/hand/hand_pose.h"

namespace airclay {

/// A ball about the origin, its skin within 0.02 mm of the sphere. The engine asks no more of a hand than its
/// skin.
HandModel ballHand(double radius_m);

/// A box about the origin.
HandModel boxHand(const Vec3& size_m);

GpuHandPose gpuHandAt(const Vec3& position_m,
                      const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity());
GpuHandPose lostHand();

}  // namespace airclay
