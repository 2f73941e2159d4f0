// SPDX-License-Identifier: MIT
#include "app/studio/view_control.h"

#include <algorithm>
#include <cmath>

namespace airclay {
namespace {

constexpr double kRadiansAPixel = 0.006;  // a drag across a laptop's window is one full turn
constexpr double kZoomAStep = 0.9;

}  // namespace

void ViewControl::reset() {
  orbit_ = Orbit{};
  orbit_.distance_m = 1.5 * edge_m_;
}

void ViewControl::look(double azimuth_rad, double elevation_rad) {
  orbit_.azimuth_rad = azimuth_rad;
  orbit_.elevation_rad = elevation_rad;
}

void ViewControl::orbit(const Vec2& drag_px) {
  orbit_.azimuth_rad -= kRadiansAPixel * drag_px.x();
  orbit_.elevation_rad = std::clamp(orbit_.elevation_rad + kRadiansAPixel * drag_px.y(), -M_PI / 2, M_PI / 2);
}

void ViewControl::pan(const Vec2& drag_px, double height_px) {
  orbit_.target -= metresAPixel(height_px) * (drag_px.x() * right() - drag_px.y() * up());
  const double most = 2 * edge_m_;
  orbit_.target = orbit_.target.cwiseMax(-most).cwiseMin(most);
}

void ViewControl::zoom(double steps) {
  orbit_.distance_m =
      std::clamp(orbit_.distance_m * std::pow(kZoomAStep, steps), 0.1 * edge_m_, 12 * edge_m_);
}

void ViewControl::fit(const Vec3& center, double radius_m) {
  orbit_.target = center;
  orbit_.distance_m =
      std::clamp(1.1 * radius_m / std::sin(orbit_.vertical_fov_rad / 2), 0.1 * edge_m_, 12 * edge_m_);
}

double ViewControl::metresAPixel(double height_px) const {
  return 2 * orbit_.distance_m * std::tan(orbit_.vertical_fov_rad / 2) / std::max(height_px, 1.0);
}

}  // namespace airclay
