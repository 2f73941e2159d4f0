// SPDX-License-Identifier: MIT
// Camera control: orbit, pan, zoom, and the standard views.
#pragma once

#include "engine/render/renderer.h"

namespace airclay {

/// Works in the workspace's frame; drags are in window pixels, right and down.
class ViewControl {
 public:
  /// \param edge_m the workspace's edge
  explicit ViewControl(double edge_m) : edge_m_(edge_m) { reset(); }

  View view() const { return orbitView(orbit_); }
  void orbit(const Vec2& drag_px);
  /// Moves the scene with the pointer. `height_px`: height of the window.
  void pan(const Vec2& drag_px, double height_px);
  /// Positive: closer.
  void zoom(double steps);
  void front() { look(-M_PI / 2, 0); }
  void side() { look(0, 0); }
  void top() { look(-M_PI / 2, M_PI / 2); }
  void reset();
  /// Frames a sphere.
  void fit(const Vec3& center, double radius_m);

  /// Metres per pixel at the target, and the image's axes in the workspace.
  double metresAPixel(double height_px) const;
  Vec3 right() const { return axis(0); }
  Vec3 up() const { return -axis(1); }
  Vec3 forward() const { return axis(2); }

 private:
  void look(double azimuth_rad, double elevation_rad);
  Vec3 axis(int row) const { return view().camera_from_workspace.linear().row(row).transpose(); }

  double edge_m_;
  Orbit orbit_;
};

}  // namespace airclay
