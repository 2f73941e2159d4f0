// SPDX-License-Identifier: MIT
// How the designer goes round the clay: orbit, pan, zoom, and the views that everybody expects.
#pragma once

#include "engine/render/renderer.h"

namespace airclay {

/// All in the workspace's frame; drags in window pixels, right and down.
class ViewControl {
 public:
  /// \param edge_m the workspace's edge
  explicit ViewControl(double edge_m) : edge_m_(edge_m) { reset(); }

  View view() const { return orbitView(orbit_); }
  void orbit(const Vec2& drag_px);
  /// Keeps what is under the pointer there. `height_px`: the window's.
  void pan(const Vec2& drag_px, double height_px);
  /// Positive: nearer.
  void zoom(double steps);
  void front() { look(-M_PI / 2, 0); }
  void side() { look(0, 0); }
  void top() { look(-M_PI / 2, M_PI / 2); }
  void reset();
  /// Centres on a ball and shows all of it.
  void fit(const Vec3& center, double radius_m);

  /// Metres at the target that a pixel covers, and the image's axes in the workspace.
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
