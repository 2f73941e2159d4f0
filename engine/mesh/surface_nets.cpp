// SPDX-License-Identifier: MIT
// Surface nets: sample, place a vertex in each crossed cell, connect them across crossed edges, relax and
// project.
#include "engine/mesh/surface_nets.h"

#include <algorithm>
#include <thread>

namespace airclay {
namespace {

constexpr int kRelaxations = 5;  // more barely improve the triangles

/// Calls body(i) for i in [0, count) on two threads; nearly every machine has two cores.
template <typename Body>
void inParallel(size_t count, const Body& body) {
  std::thread second([&] {
    for (size_t i = 1; i < count; i += 2) body(i);
  });
  for (size_t i = 0; i < count; i += 2) body(i);
  second.join();
}

struct Net {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 4>> quads;
};

/// The function's samples at the cells' corners.
class Samples {
 public:
  Samples(const Implicit& surface, const NetGrid& grid) : grid_(grid) {
    for (int axis = 0; axis < 3; ++axis) size_[axis] = grid.cells[axis] + 1;
    values_.resize(size_t(size_[0]) * size_[1] * size_[2]);
    inParallel(size_[2], [&](size_t k) {
      for (int j = 0; j < size_[1]; ++j)
        for (int i = 0; i < size_[0]; ++i) values_[index({i, j, int(k)})] = surface(corner({i, j, int(k)}));
    });
  }

  size_t index(const std::array<int, 3>& at) const {
    return size_t(at[0]) + size_t(size_[0]) * (size_t(at[1]) + size_t(size_[1]) * at[2]);
  }
  Vec3 corner(const std::array<int, 3>& at) const {
    return grid_.low_corner + grid_.cell.cwiseProduct(Vec3(at[0], at[1], at[2]));
  }
  double operator[](const std::array<int, 3>& at) const { return values_[index(at)]; }
  const std::array<int, 3>& size() const { return size_; }

  /// The mean of the points where the surface crosses the cell's twelve edges; false if it crosses none.
  bool crossing(const std::array<int, 3>& cell, Vec3& mean) const {
    int crossings = 0;
    mean.setZero();
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 4; ++side) {
        std::array<int, 3> from = cell;
        from[(axis + 1) % 3] += side & 1;
        from[(axis + 2) % 3] += side >> 1;
        std::array<int, 3> to = from;
        ++to[axis];
        const double a = (*this)[from], b = (*this)[to];
        if ((a < 0) == (b < 0)) continue;
        mean += corner(from) + a / (a - b) * (corner(to) - corner(from));
        ++crossings;
      }
    }
    if (crossings > 0) mean /= crossings;
    return crossings > 0;
  }

 private:
  NetGrid grid_;
  std::array<int, 3> size_{};
  std::vector<double> values_;
};

Net extract(const Samples& samples) {
  Net net;
  const auto& [nx, ny, nz] = samples.size();
  std::vector<int> vertex_of_cell(size_t(nx) * ny * nz, -1);
  for (int k = 0; k + 1 < nz; ++k) {
    for (int j = 0; j + 1 < ny; ++j) {
      for (int i = 0; i + 1 < nx; ++i) {
        Vec3 mean;
        if (!samples.crossing({i, j, k}, mean)) continue;
        vertex_of_cell[samples.index({i, j, k})] = int(net.vertices.size());
        net.vertices.push_back(mean);
      }
    }
  }
  for (int k = 1; k + 1 < nz; ++k) {
    for (int j = 1; j + 1 < ny; ++j) {
      for (int i = 1; i + 1 < nx; ++i) {
        const std::array<int, 3> from{i, j, k};
        const bool inside = samples[from] < 0;
        for (int axis = 0; axis < 3; ++axis) {
          std::array<int, 3> to = from;
          ++to[axis];
          if (inside == (samples[to] < 0)) continue;
          // The four cells around the edge, counterclockwise seen from its far end.
          std::array<int, 4> quad{};
          constexpr int kBack[4][2] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
          for (int c = 0; c < 4; ++c) {
            std::array<int, 3> cell = from;
            cell[(axis + 1) % 3] -= kBack[c][0];
            cell[(axis + 2) % 3] -= kBack[c][1];
            quad[c] = vertex_of_cell[samples.index(cell)];
          }
          if (!inside) std::swap(quad[1], quad[3]);
          net.quads.push_back(quad);
        }
      }
    }
  }
  return net;
}

/// One Newton step along the gradient, at most `reach` long.
Vec3 towardsSurface(const Implicit& surface, const Vec3& point, double reach) {
  const double value = surface(point), h = 1e-3 * reach;
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) gradient[axis] = (surface(point + h * Vec3::Unit(axis)) - value) / h;
  const double square = gradient.squaredNorm();
  if (!(square > 1e-12)) return point;
  Vec3 step = -value / square * gradient;
  if (step.norm() > reach) step *= reach / step.norm();
  return point + step;
}

/// Moves each vertex halfway to the mean of its neighbours and then back to the surface, repeatedly.
void relax(const Implicit& surface, double reach, Net& net) {
  std::vector<Vec3> sums(net.vertices.size());
  std::vector<int> counts(net.vertices.size());
  for (int round = 0; round < kRelaxations; ++round) {
    std::fill(sums.begin(), sums.end(), Vec3(Vec3::Zero()));
    std::fill(counts.begin(), counts.end(), 0);
    for (const auto& quad : net.quads) {
      for (int c = 0; c < 4; ++c) {
        const int a = quad[c], b = quad[(c + 1) % 4];
        sums[a] += net.vertices[b], sums[b] += net.vertices[a];
        ++counts[a], ++counts[b];
      }
    }
    const int steps = round + 1 < kRelaxations ? 1 : 3;
    inParallel(net.vertices.size(), [&](size_t v) {
      Vec3 point = 0.5 * net.vertices[v] + 0.5 / counts[v] * sums[v];
      for (int step = 0; step < steps; ++step) point = towardsSurface(surface, point, reach);
      net.vertices[v] = point;
    });
  }
}

}  // namespace

TriangleMesh surfaceNet(const Implicit& surface, const NetGrid& grid) {
  Net net = extract(Samples(surface, grid));
  relax(surface, 0.5 * grid.cell.minCoeff(), net);
  TriangleMesh mesh;
  mesh.vertices = std::move(net.vertices);
  for (const auto& [a, b, c, d] : net.quads) {
    const auto length = [&](int from, int to) { return (mesh.vertices[from] - mesh.vertices[to]).norm(); };
    if (length(a, c) < length(b, d)) {
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    } else {
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({b, c, d});
    }
  }
  return mesh;
}

}  // namespace airclay
