// SPDX-License-Identifier: MIT
// Where the lines of a regular lattice cross a closed triangle mesh: exact insides, and the surface between
// neighbouring lattice points with its normal. Overlapping and self-overlapping meshes become their union.
#pragma once

#include <span>

#include "engine/mesh/mesh.h"

namespace airclay {

/// The points low_corner + spacing_m * (i, j, k), with i < size[0], j < size[1], k < size[2].
struct Lattice {
  Vec3 low_corner = Vec3::Zero();
  double spacing_m = 1;
  std::array<int, 3> size{};

  std::size_t points() const { return std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]); }
  std::size_t index(const std::array<int, 3>& at) const {
    return std::size_t(at[0]) +
           std::size_t(size[0]) * (std::size_t(at[1]) + std::size_t(size[1]) * std::size_t(at[2]));
  }
  Vec3 point(const std::array<int, 3>& at) const {
    return low_corner + spacing_m * Vec3(at[0], at[1], at[2]);
  }
};

inline constexpr int kMaxLatticeSide = 4096;  ///< points along an axis

/// The lattice around the box, in its middle, with at least two spacings on each side.
Lattice latticeAround(const Eigen::AlignedBox3d& box, double spacing_m);

/// A crossing of a lattice line with a triangle.
struct Crossing {
  double position = 0;  ///< along the line, in spacings: 2.5 is between the points 2 and 3
  int triangle = 0;
  int step = 0;  ///< change of the winding number along the line: 1 or -1
};

/// All crossings of the lattice lines along one axis, sorted along each line. A line that meets an edge or a
/// vertex crosses exactly the triangles that it would cross if it were moved by an infinitesimal amount:
/// vertices are rounded to 2^-17 spacings, and orientations are evaluated exactly. So the winding number of
/// a closed mesh is an integer everywhere and returns to zero at the end of each line.
class LatticeCrossings {
 public:
  /// \pre the mesh is inside the lattice, whose sides have at most kMaxLatticeSide points
  LatticeCrossings(const TriangleMesh& mesh, const Lattice& lattice, int axis);

  /// Lines count as u + size[u_axis] * v, with u_axis = (axis + 1) % 3 and v_axis = (axis + 2) % 3.
  std::size_t lineCount() const { return starts_.size() - 1; }
  std::span<const Crossing> line(std::size_t line) const {
    return {crossings_.data() + starts_[line], starts_[line + 1] - starts_[line]};
  }
  std::span<const Crossing> line(const std::array<int, 3>& point) const {
    return line(std::size_t(point[(axis_ + 1) % 3]) +
                std::size_t(lattice_.size[(axis_ + 1) % 3]) * std::size_t(point[(axis_ + 2) % 3]));
  }

 private:
  Lattice lattice_;
  int axis_;
  std::vector<std::size_t> starts_;
  std::vector<Crossing> crossings_;
};

/// What the lattice lines find of a closed mesh's overlaps.
struct SolidStructure {
  std::vector<int> group_of_triangle;  ///< connected parts that overlap or enclose each other; from 0
  int groups = 0;
  std::vector<bool> overlaps;  ///< per group: a winding number other than 0 and 1 occurs
  double volume_m3 = 0;        ///< where the winding number is positive, by the midpoint rule over the lines
};

/// Finds parts (by shared vertices), groups and overlaps wider than the lattice's spacing.
SolidStructure solidStructure(const TriangleMesh& mesh, const Lattice& lattice);

/// The number of directed edges without an opposite one; 0: the mesh is closed.
std::size_t openEdges(const TriangleMesh& mesh);

}  // namespace airclay
