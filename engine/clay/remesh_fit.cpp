// SPDX-License-Identifier: MIT
#include "engine/clay/remesh_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"

namespace airclay {
namespace {

// The image of a control point at level 2 takes between a ninth (a checkerboard of displacements in a regular
// grid) and all of its own displacement, so the steps converge. A few steps recover all but the waves of one
// or two edges, which would make the cage jagged where points lie alternately on both sides of a sharp edge.
constexpr double kStep = 1;
constexpr int kSteps = 1;
// Spacings between a control point and its target, at most: more only at points that are too close to each
// other, where it would fold the surface.
constexpr double kFarthest = 0.4;
constexpr int kVolumeRounds = 3;
// Only some of a control point's data points are far from the samples, so it moves by more than their mean.
constexpr double kApproach = 2;
constexpr int kApproachRounds = 6;

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Points matrixOf(const std::vector<Vec3>& points) {
  Points matrix(Eigen::Index(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) matrix.row(Eigen::Index(i)) = points[i].transpose();
  return matrix;
}

std::vector<Vec3> pointsOf(const Points& matrix) {
  std::vector<Vec3> points;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) points.emplace_back(matrix.row(i).transpose());
  return points;
}

struct Enclosed {
  double volume = 0, area = 0;
};

Enclosed enclosedBy(const std::vector<std::array<int, 4>>& quads, const Points& points) {
  Enclosed enclosed;
  const Vec3 origin = points.row(0).transpose();
  for (const auto& quad : quads) {
    std::array<Vec3, 4> p;
    for (int k = 0; k < 4; ++k) p[k] = points.row(quad[k]).transpose() - origin;
    for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}}) {
      enclosed.volume += p[a].dot(p[b].cross(p[c])) / 6;
      enclosed.area += (p[b] - p[a]).cross(p[c] - p[a]).norm() / 2;
    }
  }
  return enclosed;
}

/// Moves points, one per control point, along the surface's normals at its vertex points, equally far and at
/// most `farthest`, so that the surface of `control_points` encloses the volume to first order.
void moveToVolume(const Subdivision& subdivision, const Points& control_points, double volume_m3,
                  double farthest, std::vector<Vec3>& points) {
  const Points surface = subdivision.matrix * control_points;
  const Enclosed now = enclosedBy(subdivision.quads, surface);
  const double outwards = std::clamp((volume_m3 - now.volume) / now.area, -farthest, farthest);
  const std::vector<Vec3> normals = dataNormals(subdivision.quads, pointsOf(surface));
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] += outwards * normals[normals.size() - points.size() + i];
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

void addSamples(const Triangle& t, double step_m, std::vector<Vec3>& samples) {
  const Vec3 ab = (t[0] + t[1]) / 2, bc = (t[1] + t[2]) / 2, ca = (t[2] + t[0]) / 2;
  if (std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()}) <= step_m) {
    samples.push_back((t[0] + t[1] + t[2]) / 3);
    return;
  }
  for (const Triangle& quarter : {Triangle{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}})
    addSamples(quarter, step_m, samples);
}

double farthestFrom(const TriangleTree& tree, const std::vector<Vec3>& samples) {
  std::vector<double> distances(samples.size());
  parallelFor(samples.size(), 512, [&](std::size_t first, std::size_t last) {
    // Samples follow each other on the surface: the last distance and the step bound the next one.
    double bound = std::numeric_limits<double>::infinity();
    for (std::size_t i = first; i < last; ++i) {
      if (i > first) bound = 1.0001 * (distances[i - 1] + (samples[i] - samples[i - 1]).norm()) + 1e-12;
      distances[i] = tree.nearest(samples[i], bound).distance;
    }
  });
  return largest(distances);
}

}  // namespace

std::vector<Vec3> controlPointsThrough(const Subdivision& subdivision, std::vector<Vec3> targets,
                                       double volume_m3, double spacing_m) {
  const Eigen::Index count = subdivision.matrix.cols();
  // The images of the control points are the last vertex points.
  const StencilMatrix images = subdivision.matrix.bottomRows(count);
  Points points = matrixOf(targets);
  for (int round = 0;; ++round) {
    const Points wanted = matrixOf(targets);
    for (int step = 0; step < kSteps; ++step) {
      points += kStep * (wanted - images * points);
      for (Eigen::Index i = 0; i < count; ++i) {
        const double distance = (points.row(i) - wanted.row(i)).norm();
        if (distance > kFarthest * spacing_m)
          points.row(i) = wanted.row(i) + kFarthest * spacing_m / distance * (points.row(i) - wanted.row(i));
      }
    }
    if (round == kVolumeRounds) return pointsOf(points);
    moveToVolume(subdivision, points, volume_m3, spacing_m / 10, targets);
  }
}

void approachSamples(const Subdivision& subdivision, const std::vector<Triangle>& surface, double step_m,
                     double tolerance_m, double volume_m3, std::vector<Vec3>& control_points) {
  std::vector<Vec3> samples;
  for (const Triangle& triangle : surface) addSamples(triangle, step_m, samples);
  Points points = matrixOf(control_points);
  const StencilMatrix by_control_point = subdivision.matrix.transpose();
  TriangleMesh mesh;
  for (const auto& [a, b, c, d] : subdivision.quads) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  for (int round = 0; round < kApproachRounds; ++round) {
    mesh.vertices = pointsOf(subdivision.matrix * points);
    const TriangleTree tree(cornersOf(mesh));
    std::vector<TriangleTree::Hit> hits(samples.size());
    parallelFor(samples.size(), 512, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) hits[i] = tree.nearest(samples[i]);
    });
    // Each data point follows the farthest of the samples that are nearest to its triangles.
    std::vector<Vec3> pulls(mesh.vertices.size(), Vec3::Zero());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (hits[i].distance <= tolerance_m) continue;
      const Vec3 pull = samples[i] - hits[i].point;
      for (const int corner : mesh.triangles[std::size_t(tree.originalIndex(hits[i].triangle))])
        if (pull.squaredNorm() > pulls[std::size_t(corner)].squaredNorm()) pulls[std::size_t(corner)] = pull;
    }
    // The surface moves only around the distant samples: the others need no search again.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (hits[i].distance > tolerance_m / 2) samples[kept++] = samples[i];
    samples.resize(kept);
    for (Eigen::Index j = 0; j < by_control_point.rows(); ++j) {
      Vec3 sum = Vec3::Zero();
      double weights = 0;
      for (StencilMatrix::InnerIterator entry(by_control_point, j); entry; ++entry) {
        sum += entry.value() * pulls[std::size_t(entry.col())];
        weights += entry.value();
      }
      points.row(j) += kApproach / weights * sum.transpose();
    }
  }
  control_points = pointsOf(points);
  moveToVolume(subdivision, points, volume_m3, std::numeric_limits<double>::infinity(), control_points);
}

double hausdorffDistance(const std::vector<Triangle>& surface, const TriangleMesh& mesh, double step_m) {
  std::vector<Vec3> samples;
  for (const Triangle& triangle : surface) addSamples(triangle, step_m, samples);
  const double from_surface = farthestFrom(TriangleTree(cornersOf(mesh)), samples);
  return std::max(from_surface, farthestFrom(TriangleTree(surface), mesh.vertices));
}

}  // namespace airclay
