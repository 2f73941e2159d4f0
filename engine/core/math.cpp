// SPDX-License-Identifier: MIT
#include "engine/core/math.h"

namespace airclay {

Mat3 rotationFromVector(const Vec3& w) {
  const double angle = w.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Mat3(Mat3::Identity());
}

double angleBetween(const Mat3& a, const Mat3& b) {
  return Eigen::AngleAxisd(Eigen::Quaterniond(a.transpose() * b)).angle();
}

}  // namespace airclay
