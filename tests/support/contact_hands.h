// SPDX-License-Identifier: MIT
// Simple solids as hands, and hand poses in the fit's format.
#pragma once

#include "engine/hand/hand_model.h"
#include "engine/hand/hand_pose.h"

namespace airclay {

/// A ball about the origin, its skin within 0.02 mm of the sphere. The engine needs only the skin of a
/// hand.
HandModel ballHand(double radius_m);

/// A box about the origin.
HandModel boxHand(const Vec3& size_m);

GpuHandPose gpuHandAt(const Vec3& position_m,
                      const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity());
GpuHandPose lostHand();

}  // namespace airclay
