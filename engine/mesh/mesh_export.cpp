// SPDX-License-Identifier: MIT
// Exports meshes. PLY: Turk 1994, "The PLY Polygon File Format". STL: 3D Systems 1988, "StereoLithography
// Interface Specification", binary format. gltf_export.cpp writes glTF; triangulate.cpp splits faces.
#include "engine/mesh/mesh_export.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/mesh_file.h"

namespace airclay {
namespace {

static_assert(std::endian::native == std::endian::little);  // numbers are copied to files byte by byte

constexpr double kMaxCoordinate_m = 1e6;  // more indicates a damaged file; also keeps products finite
constexpr double kMillimetres = 1000;     // per metre

/// A mesh as slicers interpret it: coincident points are merged, triangles without area dropped.
struct Solid {
  std::vector<Eigen::Vector3f> points_mm;
  std::vector<std::array<int, 3>> triangles;
};

void checkExportable(const PolygonMesh& mesh, const std::string& where) {
  if (mesh.faces.empty()) throw Error(where + ": the mesh has no faces");
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (!(mesh.points[i].array().abs() <= kMaxCoordinate_m).all())
      throw Error(where + ": point " + std::to_string(i + 1) +
                  " is beyond 1,000 km or not finite; expected coordinates in metres");
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    for (const int corner : mesh.faces[i])
      if (corner < 0 || std::size_t(corner) >= mesh.points.size())
        throw Error(where + ": face " + std::to_string(i + 1) + " has a corner " +
                    std::to_string(corner + 1) + "; expected points 1 to " +
                    std::to_string(mesh.points.size()));
}

Eigen::Vector3d areaVector(const std::array<Eigen::Vector3f, 3>& corners) {
  const Vec3 a = corners[0].cast<double>();
  return (corners[1].cast<double>() - a).cross(corners[2].cast<double>() - a) / 2;
}

/// For each point, the index of the first point with the same coordinates.
std::vector<int> firstOfEqual(const std::vector<Eigen::Vector3f>& points) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int i) { return std::array{points[i].x(), points[i].y(), points[i].z(), float()}; };
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const auto key_a = key(a), key_b = key(b);
    return key_a != key_b ? key_a < key_b : a < b;
  });
  std::vector<int> first(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && points[order[i]] == points[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

Solid solidOf(const PolygonMesh& mesh, const std::vector<std::array<int, 3>>& triangles) {
  Solid solid;
  solid.points_mm.reserve(mesh.points.size());
  for (const Vec3& point : mesh.points) solid.points_mm.push_back((kMillimetres * point).cast<float>());
  const std::vector<int> first = firstOfEqual(solid.points_mm);
  solid.triangles.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) {
    const Vec3 area = areaVector({solid.points_mm[a], solid.points_mm[b], solid.points_mm[c]});
    if (area != Vec3::Zero()) solid.triangles.push_back({first[a], first[b], first[c]});
  }
  return solid;
}

/// The number of edges whose triangles do not match in opposite directions.
std::size_t countOpenEdges(const std::vector<std::array<int, 3>>& triangles) {
  struct Side {
    std::uint64_t edge;
    int direction;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (const auto& triangle : triangles)
    for (int i = 0; i < 3; ++i) {
      const auto a = std::uint64_t(triangle[i]), b = std::uint64_t(triangle[(i + 1) % 3]);
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), a < b ? 1 : -1});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  std::size_t open = 0;
  for (std::size_t i = 0; i < sides.size();) {
    const std::uint64_t edge = sides[i].edge;
    int surplus = 0;
    for (; i < sides.size() && sides[i].edge == edge; ++i) surplus += sides[i].direction;
    open += std::size_t(std::abs(surplus));
  }
  return open;
}

template <class Number>
void put(std::string& bytes, Number number) {
  char copy[sizeof number];
  std::memcpy(copy, &number, sizeof number);
  bytes.append(copy, sizeof number);
}

void put(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float number : vector) put(bytes, number);
}

std::string plyOf(const PolygonMesh& mesh) {
  std::size_t max_corners = 0;
  for (const std::vector<int>& face : mesh.faces) max_corners = std::max(max_corners, face.size());
  const bool fits_uchar = max_corners <= 255;  // the usual type of the count; some readers support no other
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment Airclay: metres, z up\nelement vertex " +
                      std::to_string(mesh.points.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z"
                      "\nproperty float nx\nproperty float ny\nproperty float nz\nelement face " +
                      std::to_string(mesh.faces.size()) + "\nproperty list " +
                      (fits_uchar ? "uchar" : "uint") + " int vertex_indices\nend_header\n";
  const std::vector<Vec3> normals = smoothNormals(mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    reportProgress(i, mesh.points.size());
    put(bytes, mesh.points[i].cast<float>().eval());
    put(bytes, normals[i].cast<float>().eval());
  }
  for (const std::vector<int>& face : mesh.faces) {
    if (fits_uchar)
      put(bytes, std::uint8_t(face.size()));
    else
      put(bytes, std::uint32_t(face.size()));
    for (const int corner : face) put(bytes, std::int32_t(corner));
  }
  return bytes;
}

std::string stlOf(const Solid& solid) {
  std::string bytes =
      "Airclay: millimetres, z up";  // must not start with `solid`, which marks the text format
  bytes.resize(80, ' ');
  bytes.reserve(84 + 50 * solid.triangles.size());
  put(bytes, std::uint32_t(solid.triangles.size()));
  for (std::size_t i = 0; i < solid.triangles.size(); ++i) {
    reportProgress(i, solid.triangles.size());
    const auto& [a, b, c] = solid.triangles[i];
    const std::array corners = {solid.points_mm[a], solid.points_mm[b], solid.points_mm[c]};
    put(bytes, areaVector(corners).normalized().cast<float>().eval());
    for (const Eigen::Vector3f& corner : corners) put(bytes, corner);
    put(bytes, std::uint16_t(0));  // no attributes
  }
  return bytes;
}

TriangleMesh trianglesOf(const PolygonMesh& mesh, const std::vector<std::array<int, 3>>& triangles) {
  return {mesh.points, triangles};
}

}  // namespace

MeshFormat meshFormatOf(const std::filesystem::path& file) {
  const std::string extension = lowerCaseExtension(file);
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".ply") return MeshFormat::kPly;
  if (extension == ".stl") return MeshFormat::kStl;
  if (extension == ".glb") return MeshFormat::kGlb;
  throw Error(file.string() + ": unknown mesh format; expected the extension .obj, .ply, .stl or .glb",
              Fault::kUsage);
}

MeshExport exportMesh(const std::filesystem::path& file, const PolygonMesh& mesh) {
  MeshExport report;
  report.format = meshFormatOf(file);
  checkExportable(mesh, file.string());
  const std::vector<std::array<int, 3>> triangles = triangulated(mesh);
  const Solid solid = solidOf(mesh, triangles);
  report.vertices = mesh.points.size();
  report.triangles = solid.triangles.size();
  report.open_edges = countOpenEdges(solid.triangles);
  report.volume_m3 = massProperties(trianglesOf(mesh, solid.triangles)).volume_m3;
  Eigen::AlignedBox3d box;
  for (const Vec3& point : mesh.points) box.extend(point);
  report.size_m = box.sizes();
  switch (report.format) {
    case MeshFormat::kObj:
      writeObj(file, mesh);
      report.faces = mesh.faces.size();
      break;
    case MeshFormat::kPly:
      writeWhole(file, plyOf(mesh));
      report.faces = mesh.faces.size();
      break;
    case MeshFormat::kStl:
      writeWhole(file, stlOf(solid));
      report.faces = solid.triangles.size();
      break;
    case MeshFormat::kGlb:
      writeWhole(file, gltfBinary(trianglesOf(mesh, triangles), smoothNormals(mesh), !report.watertight()));
      report.faces = triangles.size();
      break;
  }
  return report;
}

std::vector<Vec3> smoothNormals(const PolygonMesh& mesh) {
  std::vector<Vec3> normals(mesh.points.size(), Vec3::Zero());
  for (const std::vector<int>& face : mesh.faces) {
    // Twice the polygon's vector area (Newell's method), independent of the triangulation.
    const Vec3& hub = mesh.points[face[0]];
    Vec3 twice_area = Vec3::Zero();
    for (std::size_t i = 2; i < face.size(); ++i)
      twice_area += (mesh.points[face[i - 1]] - hub).cross(mesh.points[face[i]] - hub);
    for (const int corner : face) normals[corner] += twice_area;
  }
  for (Vec3& normal : normals) {
    const double length = normal.norm();
    normal = length > 0 ? Vec3(normal / length) : Vec3(Vec3::UnitZ());
  }
  return normals;
}

}  // namespace airclay
