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

/// The rotation by the angle |w| about the axis w / |w| (Rodrigues' formula), w in radians.
inline Mat3 rotationFromVector(const Vec3& w) {
  const double angle = w.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Mat3(Mat3::Identity());
}

/// The angle between two rotations in radians, exact for small angles too.
inline double angleBetween(const Mat3& a, const Mat3& b) {
  return Eigen::AngleAxisd(Eigen::Quaterniond(a.transpose() * b)).angle();
}

}  // namespace airclay
