// SPDX-License-Identifier: MIT
// Signs at the lattice points, crossings at the lattice edges between inside and outside, one vertex per
// cycle of crossings in a cell, one quad per crossing.
#include "engine/mesh/dual_contour.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "engine/core/parallel.h"
#include "engine/core/task.h"
#include "engine/mesh/triangle_tree.h"

namespace airclay {
namespace {

// A cell's corner c is at (c & 1, c >> 1 & 1, c >> 2). Its edge 4 * axis + side runs along the axis from the
// corner that `side` places in the other two axes.
constexpr int kEdges = 12;

int cornerOf(int axis, int side) {
  return (side & 1) << (axis + 1) % 3 | (side >> 1) << (axis + 2) % 3;
}

/// A lattice edge between inside and outside.
struct Cut {
  std::array<int, 3> from{};  ///< the lattice point with the lower coordinate
  int axis = 0;
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< zero: unknown
  bool leaves = false;         ///< the lower point is inside
};

/// The cuts of a cell, in cycles: each is a sheet of the surface.
struct CellCycles {
  std::array<std::int8_t, kEdges> cycle{};  ///< of each edge; -1: not cut
  int count = 0;
};

/// The corners of each face in a cycle, and the edge after each corner.
struct FaceTable {
  std::array<std::array<int, 4>, 6> corners{}, edges{};
  FaceTable() {
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, base = (face & 1) << axis;
      corners[face] = {base, base | 1 << u, base | 1 << u | 1 << v, base | 1 << v};
      for (int k = 0; k < 4; ++k) {
        const int a = corners[face][k], b = corners[face][(k + 1) % 4];
        for (int edge = 0; edge < kEdges; ++edge) {
          const int low = cornerOf(edge / 4, edge % 4), high = low | 1 << edge / 4;
          if (low == std::min(a, b) && high == std::max(a, b)) edges[face][k] = edge;
        }
      }
    }
  }
};
const FaceTable kFaces;

bool isAmbiguous(int signs, const std::array<int, 4>& corners) {
  const auto inside = [&](int k) { return signs >> corners[k] & 1; };
  return inside(0) == inside(2) && inside(1) == inside(3) && inside(0) != inside(1);
}

/// `signs`: bit c is set if corner c is inside. On a face whose diagonals differ, the inside is connected.
CellCycles cyclesOf(int signs) {
  std::array<std::array<int, 2>, kEdges> links;
  for (auto& link : links) link = {-1, -1};
  const auto connect = [&](int a, int b) {
    links[a][links[a][0] >= 0] = b;
    links[b][links[b][0] >= 0] = a;
  };
  for (int face = 0; face < 6; ++face) {
    const auto& corners = kFaces.corners[face];
    const auto& edges = kFaces.edges[face];
    if (isAmbiguous(signs, corners)) {
      for (int k = 0; k < 4; ++k)
        if (!(signs >> corners[k] & 1)) connect(edges[(k + 3) % 4], edges[k]);
      continue;
    }
    int first = -1;
    for (int k = 0; k < 4; ++k) {
      if ((signs >> corners[k] & 1) == (signs >> corners[(k + 1) % 4] & 1)) continue;
      if (first < 0)
        first = edges[k];
      else
        connect(first, edges[k]);
    }
  }
  CellCycles cycles;
  cycles.cycle.fill(-1);
  for (int start = 0; start < kEdges; ++start) {
    if (links[start][0] < 0 || cycles.cycle[start] >= 0) continue;
    for (int edge = start, before = -1; cycles.cycle[edge] < 0;) {
      cycles.cycle[edge] = std::int8_t(cycles.count);
      const int next = links[edge][0] != before ? links[edge][0] : links[edge][1];
      before = edge;
      edge = next;
    }
    ++cycles.count;
  }
  return cycles;
}

/// Extracts the net of one mesh.
class Contour {
 public:
  Contour(const TriangleMesh& mesh, const Lattice& lattice) : mesh_(mesh), lattice_(lattice) {
    for (int axis = 0; axis < 3; ++axis) crossings_.emplace_back(mesh, lattice, axis);
    fillSigns();
    while (joinDoubleEdges()) {
    }
  }

  QuadNet net() {
    findCuts();
    findCells();
    QuadNet net;
    placeVertices(net);
    connect(net);
    return net;
  }

 private:
  void fillSigns() {
    inside_.assign(lattice_.points(), 0);
    for (int j = 0; j < lattice_.size[1]; ++j)
      for (int i = 0; i < lattice_.size[0]; ++i) {
        int winding = 0, k = 0;
        for (const Crossing& crossing : crossings_[2].line(std::array{i, j, 0})) {
          for (; k < crossing.position; ++k) inside_[lattice_.index({i, j, k})] = winding > 0;
          winding += crossing.step;
        }
      }
  }

  int signsOf(const std::array<int, 3>& cell) const {
    int signs = 0;
    for (int corner = 0; corner < 8; ++corner)
      signs |= inside_[lattice_.index(
                   {cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)})]
               << corner;
    return signs;
  }

  template <typename Visit>
  void forEachCell(const Visit& visit) const {
    for (int k = 0; k + 1 < lattice_.size[2]; ++k) {
      reportProgress(double(k) / lattice_.size[2]);
      for (int j = 0; j + 1 < lattice_.size[1]; ++j)
        for (int i = 0; i + 1 < lattice_.size[0]; ++i) visit(std::array{i, j, k});
    }
  }

  static bool sharesAllEdges(int signs, int face) {
    const CellCycles cycles = cyclesOf(signs);
    const auto& edges = kFaces.edges[face];
    for (int k = 1; k < 4; ++k)
      if (cycles.cycle[edges[k]] != cycles.cycle[edges[0]]) return false;
    return true;
  }

  /// Two sheets of neighbouring cells that meet in all four edges of a face would share two edges of the net.
  /// Adds an outside corner of each such face to the solid. False if there is none.
  bool joinDoubleEdges() {
    bool found = false;
    forEachCell([&](const std::array<int, 3>& cell) {
      const int signs = signsOf(cell);
      if (signs == 0 || signs == 255) return;
      for (int axis = 0; axis < 3; ++axis) {
        const int face = 2 * axis + 1;
        if (!isAmbiguous(signs, kFaces.corners[face]) || !sharesAllEdges(signs, face)) continue;
        std::array<int, 3> next = cell;
        ++next[axis];
        if (!sharesAllEdges(signsOf(next), face - 1)) continue;
        for (const int corner : kFaces.corners[face])
          if (!(signs >> corner & 1)) {
            inside_[lattice_.index(
                {cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)})] = 1;
            break;
          }
        found = true;
        return;
      }
    });
    return found;
  }

  void findCuts() {
    for (int k = 0; k + 1 < lattice_.size[2]; ++k)
      for (int j = 0; j + 1 < lattice_.size[1]; ++j)
        for (int i = 0; i + 1 < lattice_.size[0]; ++i)
          for (int axis = 0; axis < 3; ++axis) {
            const std::array<int, 3> from{i, j, k};
            std::array<int, 3> to = from;
            ++to[axis];
            const bool from_inside = inside_[lattice_.index(from)];
            if (from_inside == bool(inside_[lattice_.index(to)])) continue;
            cuts_.push_back({from, axis, Vec3::Zero(), Vec3::Zero(), from_inside});
            cut_keys_.push_back(3 * lattice_.index(from) + std::size_t(axis));
          }
    parallelFor(cuts_.size(), 1024, [&](std::size_t first, std::size_t last) {
      for (std::size_t c = first; c < last; ++c) measure(cuts_[c]);
    });
  }

  /// Finds where the winding number becomes positive or stops being positive.
  void measure(Cut& cut) const {
    const int start = cut.from[cut.axis];
    double position = start + 0.5;
    int winding = 0;
    for (const Crossing& crossing : crossings_[cut.axis].line(cut.from)) {
      const bool was_inside = winding > 0;
      winding += crossing.step;
      if (crossing.position < start || was_inside == (winding > 0) || was_inside != cut.leaves) continue;
      if (crossing.position > start + 1) break;
      position = crossing.position;
      const auto& [a, b, c] = mesh_.triangles[std::size_t(crossing.triangle)];
      cut.normal = normalOf({mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]});
      break;
    }
    cut.point = lattice_.point(cut.from) + lattice_.spacing_m * (position - start) * Vec3::Unit(cut.axis);
  }

  void findCells() {
    for (const Cut& cut : cuts_)
      for (int side = 0; side < 4; ++side) {
        std::array<int, 3> cell = cut.from;
        cell[(cut.axis + 1) % 3] -= side & 1;
        cell[(cut.axis + 2) % 3] -= side >> 1;
        cells_.push_back(lattice_.index(cell));
      }
    std::sort(cells_.begin(), cells_.end());
    cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
  }

  std::array<int, 3> cellAt(std::size_t index) const {
    const std::size_t nx = std::size_t(lattice_.size[0]), ny = std::size_t(lattice_.size[1]);
    return {int(index % nx), int(index / nx % ny), int(index / nx / ny)};
  }

  int cutAt(const std::array<int, 3>& from, int axis) const {
    const std::size_t key = 3 * lattice_.index(from) + std::size_t(axis);
    return int(std::lower_bound(cut_keys_.begin(), cut_keys_.end(), key) - cut_keys_.begin());
  }

  void placeVertices(QuadNet& net) {
    vertices_of_cut_.assign(cuts_.size(), {-1, -1, -1, -1});
    std::vector<std::vector<TangentPlane>> planes;
    std::vector<Vec3> means;
    for (const std::size_t index : cells_) {
      const std::array<int, 3> cell = cellAt(index);
      const CellCycles cycles = cyclesOf(signsOf(cell));
      const std::size_t first = planes.size();
      planes.resize(first + std::size_t(cycles.count));
      std::vector<std::pair<Vec3, int>> sums(std::size_t(cycles.count), {Vec3::Zero(), 0});
      for (int edge = 0; edge < kEdges; ++edge) {
        if (cycles.cycle[edge] < 0) continue;
        const int axis = edge / 4, side = edge % 4;
        std::array<int, 3> from = cell;
        from[(axis + 1) % 3] += side & 1;
        from[(axis + 2) % 3] += side >> 1;
        const int cut = cutAt(from, axis);
        const std::size_t cycle = std::size_t(cycles.cycle[edge]);
        vertices_of_cut_[cut][side] = int(first + cycle);
        sums[cycle].first += cuts_[cut].point;
        ++sums[cycle].second;
        if (cuts_[cut].normal != Vec3::Zero())
          planes[first + cycle].push_back({cuts_[cut].point, cuts_[cut].normal});
      }
      for (const auto& [sum, count] : sums) means.push_back(sum / count);
    }
    net.features.resize(means.size());
    net.points = means;
    parallelFor(means.size(), 256, [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v) meetingPoint(planes[v], means[v], net.features[v]);
    });
  }

  void connect(QuadNet& net) const {
    // A cell that is `side` steps behind the edge sees it as its own edge `side`. Counterclockwise seen from
    // the edge's far end.
    constexpr int kAround[4] = {3, 2, 0, 1};
    for (std::size_t c = 0; c < cuts_.size(); ++c) {
      std::array<int, 4> quad{};
      for (int k = 0; k < 4; ++k) quad[k] = vertices_of_cut_[c][kAround[k]];
      if (!cuts_[c].leaves) std::swap(quad[1], quad[3]);
      net.quads.push_back(quad);
    }
  }

  const TriangleMesh& mesh_;
  const Lattice& lattice_;
  std::vector<LatticeCrossings> crossings_;
  std::vector<std::uint8_t> inside_;
  std::vector<Cut> cuts_;
  std::vector<std::size_t> cut_keys_, cells_;
  std::vector<std::array<int, 4>> vertices_of_cut_;  ///< by the edge's side in the cell
};

}  // namespace

Vec3 meetingPoint(std::span<const TangentPlane> planes, const Vec3& start, Feature& feature) {
  feature = Feature::kSmooth;
  if (planes.empty()) return start;
  // Relative to the largest eigenvalue: two planes at 40 degrees, of the same number of crossings, have 0.13.
  constexpr double kDetermined = 0.13;
  Mat3 squares = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const TangentPlane& plane : planes) {
    squares += plane.normal * plane.normal.transpose();
    right += plane.normal * plane.normal.dot(plane.point - start);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(squares);
  Vec3 step = Vec3::Zero();
  int rank = 0;
  for (int i = 2; i >= 0; --i) {
    const double value = solver.eigenvalues()[i];
    if (value < kDetermined * solver.eigenvalues()[2] || value <= 0) break;
    const Vec3 direction = solver.eigenvectors().col(i);
    step += direction * (direction.dot(right) / value);
    ++rank;
  }
  feature = rank == 3 ? Feature::kCorner : rank == 2 ? Feature::kCrease : Feature::kSmooth;
  return start + step;
}

QuadNet dualContour(const TriangleMesh& mesh, const Lattice& lattice) {
  return Contour(mesh, lattice).net();
}

}  // namespace airclay
