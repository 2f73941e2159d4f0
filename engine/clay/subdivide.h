// SPDX-License-Identifier: MIT
// Eq. (3)-(5): the Catmull-Clark subdivision of a control cage as one sparse matrix, d = A p.
#pragma once

#include <Eigen/SparseCore>

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/mesh/mesh.h"
#include "shaders/clay/subdivide_io.h"

namespace airclay {

/// The weights of a new vertex point.
enum class SubdivisionRule {
  kCatmullClark,  ///< Catmull and Clark 1978, from OpenSubdiv's stencil table
  kPrinted,       ///< eq. (4) as the paper prints it, (a + 4m + p) / 6
};

using StencilMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// A subdivision; depends only on the cage's connectivity, the rule and the number of levels.
struct Subdivision {
  StencilMatrix matrix;                   ///< A: data points by control points; each row sums to 1
  std::vector<std::array<int, 4>> quads;  ///< faces of the result, counterclockwise seen from outside
};

/// Subdivides the connectivity of `cage` `levels` times (>= 1). Data points are in OpenSubdiv's order for
/// both rules: at each level face points, then edge points, then vertex points. Borders follow the standard
/// rule: edge midpoints, and 1/8, 3/4, 1/8 for vertices, also at corners of a single face (OpenSubdiv's
/// VTX_BOUNDARY_EDGE_ONLY). \throw Error if `cage` is not a valid control cage (engine/mesh/manifold.h),
/// `levels` is not 1 to 15, or the result would exceed kMaxDataPoints or about 5 GB of weights.
Subdivision subdivide(const PolygonMesh& cage, int levels, SubdivisionRule rule);

/// The subdivided surface of `control_points` (one per column of A), in the same frame and unit: one point
/// per row of A, and the quads.
PolygonMesh surfaceMesh(const Subdivision& subdivision, const std::vector<Vec3>& control_points);

/// `cage` subdivided `levels` times, points and faces in subdivide()'s order; the cage itself for 0 levels.
/// \throw Error like subdivide().
PolygonMesh meshAtLevel(const PolygonMesh& cage, int levels, SubdivisionRule rule);

/// 20 million: 240 MB of positions; more indicates a mistyped level.
inline constexpr long kMaxDataPoints = 20'000'000;

/// Evaluates the surface on the GPU: data points and their normals, which stay in device memory.
class SurfaceEvaluator {
 public:
  SurfaceEvaluator(Gpu& gpu, const Subdivision& subdivision);

  /// Records d = A p and the normals for `control_points`, one per column of A; metres, any frame.
  void record(Recorder& recorder, const Buffer<vec3>& control_points);
  /// The two parts of record().
  void recordPoints(Recorder& recorder, const Buffer<vec3>& control_points);
  void recordNormals(Recorder& recorder);
  /// The same with workgroup counts from device memory: three uints, pointGroups() or zeros.
  void recordPointsIndirect(Recorder& recorder, const Buffer<vec3>& control_points, const RawBuffer& groups,
                            std::uint64_t byte_offset);
  void recordNormalsIndirect(Recorder& recorder, const RawBuffer& groups, std::uint64_t byte_offset);
  GroupRows pointGroups() const { return groupRowsFor(dataPointCount(), kSubdivideWorkgroup); }

  const Buffer<vec3>& dataPoints() const { return data_points_; }
  /// Unit length; zero where the adjoining faces' normals cancel out.
  const Buffer<vec3>& normals() const { return normals_; }
  /// Two per quad, three data points each, counterclockwise seen from outside.
  const Buffer<std::uint32_t>& triangles() const { return triangles_; }
  std::uint32_t triangleCount() const { return static_cast<std::uint32_t>(triangles_.count() / 3); }
  std::uint32_t dataPointCount() const { return static_cast<std::uint32_t>(data_points_.count()); }

 private:
  SubdivideArgs subdivideArgs(const Buffer<vec3>& control_points) const;
  NormalsArgs normalsArgs() const;

  Kernel<SubdivideArgs> subdivide_;
  Kernel<NormalsArgs> normals_kernel_;
  Buffer<std::uint32_t> row_starts_, columns_;
  Buffer<float> weights_;
  Buffer<std::uint32_t> quad_starts_, quads_at_, quads_, triangles_;
  Buffer<vec3> data_points_, normals_;
};

/// Eq. (5), d = A p, in double precision: the reference implementation of the kernel `subdivide`.
std::vector<Vec3> dataPoints(const StencilMatrix& matrix, const std::vector<Vec3>& control_points);

/// Unit normals at the data points: the area-weighted average of the adjoining faces' normals; zero where
/// these cancel out. The reference implementation of the kernel `normals`.
std::vector<Vec3> dataNormals(const std::vector<std::array<int, 4>>& quads,
                              const std::vector<Vec3>& data_points);

}  // namespace airclay
