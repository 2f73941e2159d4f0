// SPDX-License-Identifier: MIT
#include "tests/support/coverage.h"

#include <cmath>

namespace airclay {
namespace {

constexpr int kFine = 6;  // samples per pixel, along each axis

}  // namespace

Shape shapeOf(const std::vector<double>& coverages, int width) {
  Shape shape;
  for (std::size_t i = 0; i < coverages.size(); ++i) {
    const auto w = static_cast<std::size_t>(width);
    shape.area += coverages[i];
    shape.center += coverages[i] * Vec2(static_cast<double>(i % w), static_cast<double>(i / w));
  }
  if (shape.area > 0) shape.center /= shape.area;
  return shape;
}

std::vector<double> projectedCoverage(const Camera& camera, const TriangleMesh& mesh,
                                      const Pose& world_from_mesh) {
  const int width = camera.width * kFine, height = camera.height * kFine;
  std::vector<char> covered(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& vertex = mesh.vertices[static_cast<std::size_t>(triangle[k])];
      const Vec2 pixel =
          *projectThroughLens(camera.lens, camera.camera_from_world * (world_from_mesh * vertex));
      p[k] = kFine * (pixel + Vec2(0.5, 0.5)) - Vec2(0.5, 0.5);
    }
    const auto side = [](const Vec2& a, const Vec2& b, const Vec2& c) {
      return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    };
    const double area = side(p[0], p[1], p[2]);
    const Vec2 low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    for (int y = std::max(0, int(std::ceil(low.y()))); y <= std::min(height - 1.0, high.y()); ++y)
      for (int x = std::max(0, int(std::ceil(low.x()))); x <= std::min(width - 1.0, high.x()); ++x) {
        const Vec2 at(x, y);
        if (area * side(p[0], p[1], at) >= 0 && area * side(p[1], p[2], at) >= 0 &&
            area * side(p[2], p[0], at) >= 0)
          covered[std::size_t(y) * std::size_t(width) + std::size_t(x)] = 1;
      }
  }
  std::vector<double> coverages(static_cast<std::size_t>(camera.width) *
                                static_cast<std::size_t>(camera.height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      coverages[std::size_t(y / kFine) * std::size_t(camera.width) + std::size_t(x / kFine)] +=
          covered[std::size_t(y) * std::size_t(width) + std::size_t(x)] / double(kFine * kFine);
  return coverages;
}

}  // namespace airclay
