// SPDX-License-Identifier: MIT
// The clay in device memory: control points, data points, and what is kept between the frames.
#pragma once

#include <memory>

#include "engine/gpu/recorder.h"
#include "engine/solve.h"
#include "engine/subdivide.h"

namespace airclay {

struct ClayOptions;

/// The virtual clay: a control cage, its subdivision d = A p, and the factored inverse. Positions live on the device.
class Clay {
 public:
  Clay(Gpu& gpu, const ClayOptions& options);
  ~Clay();

  const Subdivision& subdivision() const;
  int controlPointCount() const;
  int dataPointCount() const;

  /// The cage and the surface as they are now, in the world. \pre no submission is running
  PolygonMesh cage() const;
  PolygonMesh surface() const;
  /// Moves the control points; the surface follows in the same call.
  void setControlPoints(const std::vector<Vec3>& points);

  /// On the device: control points, data points, unit normals at the data points; metres, in the workspace's frame (the world moved to the
  /// workspace's centre).
  const Buffer<vec3>& controlPoints() const;
  const Buffer<vec3>& dataPoints() const;
  const Buffer<vec3>& normals() const;
  /// The surface's triangles: two a quad, indices of data points.
  const Buffer<std::uint32_t>& triangles() const;
  std::uint32_t triangleCount() const;

 private:
  friend class Sculptor;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
