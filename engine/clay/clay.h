// SPDX-License-Identifier: MIT
// The clay in device memory: control points and the surface that they give.
#pragma once

#include "engine/clay/clay_state.h"
#include "engine/clay/solve.h"
#include "engine/clay/subdivide.h"
#include "engine/gpu/recorder.h"

namespace airclay {

/// The virtual clay: a control cage and its subdivision d = A p. Positions live on the device, in the clay's
/// own frame: the workspace's (the world moved to the workspace's centre), turned as the clay has been.
class Clay {
 public:
  /// \throw Error when the cage is none, or too large.
  Clay(Gpu& gpu, const ClayState& state, const Vec3& workspace_center);

  const Subdivision& subdivision() const { return subdivision_; }
  const SolveMethod& solveMethod() const { return *solve_method_; }
  int levels() const { return levels_; }
  const std::vector<std::vector<int>>& cageFaces() const { return cage_faces_; }
  int controlPointCount() const { return static_cast<int>(subdivision_.matrix.cols()); }
  int dataPointCount() const { return static_cast<int>(subdivision_.matrix.rows()); }

  /// The cage and the surface as they are now, in the world. \pre no submission is running
  PolygonMesh cage() const;
  PolygonMesh surface() const;
  /// Moves the control points; the surface follows in the same call. World.
  void setControlPoints(const std::vector<Vec3>& points);
  /// The same in a frame that is turned so.
  void setControlPoints(const std::vector<Vec3>& points, const Eigen::Quaterniond& workspace_from_clay);
  /// Turns all of it about the workspace's centre.
  void turn(const Eigen::Quaterniond& by);
  const Eigen::Quaterniond& workspaceFromClay() const { return workspace_from_clay_; }
  /// How often that was done: whoever followed the surface starts anew.
  int edits() const { return edits_; }

  /// On the device: control points, data points, unit normals at the data points; metres, in the clay's
  /// frame.
  const Buffer<vec3>& controlPoints() const { return control_points_; }
  const Buffer<vec3>& dataPoints() const { return evaluator_.dataPoints(); }
  const Buffer<vec3>& normals() const { return evaluator_.normals(); }
  /// The surface's triangles: two a quad, indices of data points.
  const Buffer<std::uint32_t>& triangles() const { return evaluator_.triangles(); }
  std::uint32_t triangleCount() const { return evaluator_.triangleCount(); }

  /// For whoever moves the control points on the device: x y z each in double, of which controlPoints() are
  /// the rounded copy that the surface is evaluated from.
  const Buffer<double>& exactPoints() const { return exact_points_; }
  SurfaceEvaluator& evaluator() { return evaluator_; }
  /// The control points in the clay's frame. \pre no submission is running
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
