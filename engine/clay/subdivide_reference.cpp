// SPDX-License-Identifier: MIT
// The CPU twins of the kernels `subdivide` and `normals`: eq. (5) and the polyhedron's normals, serial, in
// double.
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
    // Twice the quad's vector area is the cross product of its diagonals, whether it is flat or not.
    const Vec3 diagonal_02 = data_points[size_t(quad[2])] - data_points[size_t(quad[0])];
    const Vec3 diagonal_13 = data_points[size_t(quad[3])] - data_points[size_t(quad[1])];
    const Vec3 area = diagonal_02.cross(diagonal_13);
    for (const int corner : quad) normals[size_t(corner)] += area;
  }
  for (Vec3& normal : normals) normal.normalize();  // zero stays zero
  return normals;
}

}  // namespace airclay
