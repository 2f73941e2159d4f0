// SPDX-License-Identifier: MIT
// The reference implementations of the kernels `subdivide` and `normals`: eq. (5) and the vertex normals,
// serial, in double precision.
#include "engine/clay/subdivide.h"

namespace airclay {

std::vector<Vec3> dataPoints(const StencilMatrix& matrix, const std::vector<Vec3>& control_points) {
  std::vector<Vec3> data_points(size_t(matrix.rows()), Vec3::Zero());
  for (int row = 0; row < matrix.outerSize(); ++row)
    for (StencilMatrix::InnerIterator entry(matrix, row); entry; ++entry)
      data_points[size_t(row)] += entry.value() * control_points[size_t(entry.col())];  // (5)
  return data_points;
}

std::vector<Vec3> dataNormals(const std::vector<std::array<int, 4>>& quads,
                              const std::vector<Vec3>& data_points) {
  std::vector<Vec3> normals(data_points.size(), Vec3::Zero());
  for (const std::array<int, 4>& quad : quads) {
    // The cross product of the diagonals is twice the quad's vector area, even if the quad is not planar.
    const Vec3 diagonal_02 = data_points[size_t(quad[2])] - data_points[size_t(quad[0])];
    const Vec3 diagonal_13 = data_points[size_t(quad[3])] - data_points[size_t(quad[1])];
    const Vec3 area = diagonal_02.cross(diagonal_13);
    for (const int corner : quad) normals[size_t(corner)] += area;
  }
  for (Vec3& normal : normals) normal.normalize();  // zero stays zero
  return normals;
}

}  // namespace airclay
