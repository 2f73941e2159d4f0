// SPDX-License-Identifier: MIT
// Geometry types on the CPU: double precision, metres, radians, right-handed.
// World: z up, origin at the workspace's centre. Camera: x right, y down, z forward (OpenCV's).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace airclay {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Pose = Eigen::Isometry3d;  ///< a rigid transform; variables are named b_from_a

// Not inline: instantiating their Eigen templates takes the compiler longer than parsing this header.

/// The rotation by the angle |w| about the axis w / |w| (Rodrigues' formula), w in radians.
Mat3 rotationFromVector(const Vec3& w);

/// The angle between two rotations in radians, exact for small angles too.
double angleBetween(const Mat3& a, const Mat3& b);

}  // namespace airclay
