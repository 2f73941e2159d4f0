// SPDX-License-Identifier: MIT
// The clay in device memory: control points and the surface that they define.
#pragma once

#include "engine/clay/clay_state.h"
#include "engine/clay/solve.h"
#include "engine/clay/subdivide.h"
#include "engine/gpu/recorder.h"

namespace airclay {

/// The virtual clay: a control cage and its subdivision d = A p. Positions are in device memory, in the clay
/// frame: the workspace frame (the world moved to the workspace's centre), rotated with the clay.
class Clay {
 public:
  /// \throw Error if the cage is invalid or too large.
  Clay(Gpu& gpu, const ClayState& state, const Vec3& workspace_center);

  const Subdivision& subdivision() const { return subdivision_; }
  const SolveMethod& solveMethod() const { return *solve_method_; }
  int levels() const { return levels_; }
  const std::vector<std::vector<int>>& cageFaces() const { return cage_faces_; }
  int controlPointCount() const { return static_cast<int>(subdivision_.matrix.cols()); }
  int dataPointCount() const { return static_cast<int>(subdivision_.matrix.rows()); }

  /// The current cage and surface, world, metres. \pre no submission is running
  PolygonMesh cage() const;
  PolygonMesh surface() const;
  /// Sets the control points (world, metres) and evaluates the surface.
  void setControlPoints(const std::vector<Vec3>& points);
  /// The same, and sets the clay's rotation.
  void setControlPoints(const std::vector<Vec3>& points, const Eigen::Quaterniond& workspace_from_clay);
  /// Rotates the clay about the workspace's centre.
  void rotate(const Eigen::Quaterniond& rotation);
  const Eigen::Quaterniond& workspaceFromClay() const { return workspace_from_clay_; }
  /// The number of setControlPoints() and rotate() calls; a change tells users of the surface to reset.
  int edits() const { return edits_; }

  /// On the device: control points, data points, and unit normals at the data points; clay frame, metres.
  const Buffer<vec3>& controlPoints() const { return control_points_; }
  const Buffer<vec3>& dataPoints() const { return evaluator_.dataPoints(); }
  const Buffer<vec3>& normals() const { return evaluator_.normals(); }
  /// The surface's triangles: two per quad, three indices of data points each.
  const Buffer<std::uint32_t>& triangles() const { return evaluator_.triangles(); }
  std::uint32_t triangleCount() const { return evaluator_.triangleCount(); }

  /// The control points in double precision, x y z each, for kernels that move them. controlPoints() is the
  /// rounded copy from which the surface is evaluated.
  const Buffer<double>& exactPoints() const { return exact_points_; }
  SurfaceEvaluator& evaluator() { return evaluator_; }
  /// The control points, clay frame, metres. \pre no submission is running
  std::vector<Vec3> downloadControlPoints() const;
  void uploadControlPoints(const std::vector<Vec3>& points);

 private:
  Gpu& gpu_;
  Vec3 workspace_center_;
  Eigen::Quaterniond workspace_from_clay_;
  std::vector<std::vector<int>> cage_faces_;
  const SolveMethod* solve_method_;
  int levels_;
  Subdivision subdivision_;
  SurfaceEvaluator evaluator_;
  Buffer<double> exact_points_;
  Buffer<vec3> control_points_;
  int edits_ = 0;
};

}  // namespace airclay
