// SPDX-License-Identifier: MIT
// Small scenes with known geometry, shared by the tests.
#pragma once

#include "engine/camera/gpu_rig.h"

namespace airclay {

/// `count` cameras of width x height, about 1.1 m from the workspace's centre and aimed at it, with mild lens
/// distortion.
Rig ringRig(int count, int width = 320, int height = 240);

/// The silhouette of a sphere in every camera, in closed form: the pixels whose rays pass within its
/// radius.
std::vector<Silhouette> sphereMasks(const Rig& rig, const Vec3& center, double radius_m);

}  // namespace airclay
