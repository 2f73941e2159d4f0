// SPDX-License-Identifier: MIT
// The strict OBJ reader, and writers of OBJ and PLY.
#include "engine/mesh/mesh_file.h"

#include <algorithm>
#include <bit>
#include <charconv>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/manifold.h"
#include "engine/mesh/mesh_source.h"

namespace airclay {
namespace {

void append(std::string& text, double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number, std::chars_format::general, 9).ptr;
  text.append(digits, end);
}

}  // namespace

PolygonMesh readObj(const std::filesystem::path& file) {
  const std::string name = file.string(), text = readWhole(file, kMaxMeshFileBytes);
  MeshSource source = parseObj({name, text}, RepeatedCorners::kRefuse);
  PolygonMesh mesh{std::move(source.points), std::move(source.faces)};
  checkCage(mesh, name);
  return mesh;
}

void writeObj(const std::filesystem::path& file, const PolygonMesh& mesh) {
  std::string text;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    reportProgress(i, mesh.points.size() + mesh.faces.size());
    const Vec3& point = mesh.points[i];
    text += 'v';
    for (int axis = 0; axis < 3; ++axis) {
      text += ' ';
      append(text, point[axis]);
    }
    text += '\n';
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    reportProgress(mesh.points.size() + f, mesh.points.size() + mesh.faces.size());
    text += 'f';
    for (const int corner : mesh.faces[f]) text.append(" ").append(std::to_string(corner + 1));
    text += '\n';
  }
  writeWhole(file, text);
}

void writeObj(const std::filesystem::path& file, const TriangleMesh& mesh) {
  PolygonMesh polygons{mesh.vertices, {}};
  for (const std::array<int, 3>& triangle : mesh.triangles)
    polygons.faces.emplace_back(triangle.begin(), triangle.end());
  writeObj(file, polygons);
}

void writePly(const std::filesystem::path& file, const std::vector<Eigen::Vector3f>& points) {
  static_assert(std::endian::native == std::endian::little && sizeof(Eigen::Vector3f) == 12);
  std::string content = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                        std::to_string(points.size()) +
                        "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  if (!points.empty()) content.append(reinterpret_cast<const char*>(points.data()), points.size() * 12);
  writeWhole(file, content);
}

}  // namespace airclay
