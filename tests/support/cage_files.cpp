// SPDX-License-Identifier: MIT
#include "tests/support/cage_files.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "engine/core/file_io.h"

namespace airclay {
namespace {

template <typename T>
void append(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string spaced(const Vec3& point) {
  return exactNumber(point.x()) + " " + exactNumber(point.y()) + " " + exactNumber(point.z());
}

/// Fans.
std::vector<std::array<int, 3>> trianglesOf(const PolygonMesh& mesh) {
  std::vector<std::array<int, 3>> triangles;
  for (const std::vector<int>& face : mesh.faces)
    for (std::size_t k = 2; k < face.size(); ++k) triangles.push_back({face[0], face[k - 1], face[k]});
  return triangles;
}

std::string base64(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

/// `buffer` is the buffer's uri with its key, or empty.
std::string gltfJson(const PolygonMesh& mesh, const std::string& buffer) {
  std::size_t corners = 0;
  for (const std::vector<int>& face : mesh.faces) corners += face.size();
  const std::size_t indices = 3 * trianglesOf(mesh).size(), point_bytes = 12 * corners;
  const auto text = [](std::size_t number) { return std::to_string(number); };
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
         text(corners) + R"(},{"bufferView":1,"componentType":5123,"type":"SCALAR","count":)" +
         text(indices) + R"(}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" + text(point_bytes) +
         R"(},{"buffer":0,"byteOffset":)" + text(point_bytes) + R"(,"byteLength":)" + text(2 * indices) +
         R"(}],"buffers":[{)" + buffer + R"("byteLength":)" + text(gltfBuffer(mesh).size()) + "}]}";
}

}  // namespace

PolygonMesh cubeCage(double size) {
  PolygonMesh cube;
  for (int p = 0; p < 8; ++p) cube.points.emplace_back(p & 1 ? size : 0, p & 2 ? size : 0, p & 4 ? size : 0);
  cube.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}};
  return cube;
}

std::string objOf(const PolygonMesh& mesh) {
  std::string text = "# a cage\n";
  for (const Vec3& point : mesh.points) text += "v " + spaced(point) + "\n";
  for (const std::vector<int>& face : mesh.faces) {
    text += "f";
    for (const int corner : face) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

std::string plyOf(const PolygonMesh& mesh, PlyEncoding encoding) {
  const bool is_text = encoding == PlyEncoding::kText, big_endian = encoding == PlyEncoding::kBigEndian;
  std::string file = "ply\nformat ";
  file += is_text ? "ascii" : big_endian ? "binary_big_endian" : "binary_little_endian";
  file +=
      " 1.0\ncomment a cage\nelement material 1\nproperty uchar red\nproperty list uchar short steps\n"
      "element vertex " +
      std::to_string(mesh.points.size()) +
      "\nproperty double x\nproperty float nx\nproperty double y\nproperty double z\nproperty uchar red\n"
      "element face " +
      std::to_string(mesh.faces.size()) +
      "\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
      "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n";
  if (is_text) {
    file += "200 3 -1 0 1\n";
    for (const Vec3& point : mesh.points)
      file +=
          exactNumber(point.x()) + " nan " + exactNumber(point.y()) + " " + exactNumber(point.z()) + " 255\n";
    for (const std::vector<int>& face : mesh.faces) {
      file += "0 " + std::to_string(face.size());
      for (const int corner : face) file += " " + std::to_string(corner);
      file += "\n";
    }
    return file + "0 1\n";
  }
  append(file, std::uint8_t(200));
  append(file, std::uint8_t(3));
  for (const std::int16_t step : {-1, 0, 1}) append(file, step, big_endian);
  for (const Vec3& point : mesh.points) {
    append(file, point.x(), big_endian);
    append(file, 0.5f, big_endian);
    append(file, point.y(), big_endian);
    append(file, point.z(), big_endian);
    append(file, std::uint8_t(255));
  }
  for (const std::vector<int>& face : mesh.faces) {
    append(file, std::uint8_t(0));
    append(file, std::uint8_t(face.size()));
    for (const int corner : face) append(file, std::int32_t(corner), big_endian);
  }
  append(file, std::int32_t(0), big_endian);
  append(file, std::int32_t(1), big_endian);
  return file;
}

std::string stlTextOf(const PolygonMesh& mesh) {
  std::string text = "solid a cage # of clay\n";
  for (const std::array<int, 3>& triangle : trianglesOf(mesh)) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const int corner : triangle) text += "   vertex " + spaced(mesh.points[std::size_t(corner)]) + "\n";
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a cage\n";
}

std::string stlBinaryOf(const PolygonMesh& mesh, const std::string& header) {
  std::string file = header;
  file.resize(80);
  const std::vector<std::array<int, 3>> triangles = trianglesOf(mesh);
  append(file, std::uint32_t(triangles.size()));
  for (const std::array<int, 3>& triangle : triangles) {
    for (int axis = 0; axis < 3; ++axis) append(file, 0.f);
    for (const int corner : triangle)
      for (int axis = 0; axis < 3; ++axis) append(file, float(mesh.points[std::size_t(corner)][axis]));
    append(file, std::uint16_t(0));
  }
  return file;
}

std::string gltfBuffer(const PolygonMesh& mesh) {
  std::string bytes;
  for (const std::vector<int>& face : mesh.faces)
    for (const int corner : face)
      for (int axis = 0; axis < 3; ++axis) append(bytes, float(mesh.points[std::size_t(corner)][axis]));
  std::size_t first = 0;
  for (const std::vector<int>& face : mesh.faces) {
    for (std::size_t k = 2; k < face.size(); ++k)
      for (const std::size_t corner : {first, first + k - 1, first + k}) append(bytes, std::uint16_t(corner));
    first += face.size();
  }
  return bytes;
}

std::string gltfOf(const PolygonMesh& mesh, const std::string& buffer_uri) {
  const std::string uri =
      buffer_uri.empty() ? "data:application/octet-stream;base64," + base64(gltfBuffer(mesh)) : buffer_uri;
  return gltfJson(mesh, "\"uri\":\"" + uri + "\",");
}

std::string glbOf(const PolygonMesh& mesh) {
  std::string json = gltfJson(mesh, ""), buffer = gltfBuffer(mesh), file = "glTF";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  buffer.resize((buffer.size() + 3) / 4 * 4);
  append(file, std::uint32_t(2));
  append(file, std::uint32_t(12 + 8 + json.size() + 8 + buffer.size()));
  append(file, std::uint32_t(json.size()));
  file += "JSON" + json;
  append(file, std::uint32_t(buffer.size()));
  return file + std::string("BIN\0", 4) + buffer;
}

std::vector<std::pair<std::string, std::string>> cageFiles(const PolygonMesh& mesh) {
  return {{"cage.obj", objOf(mesh)},
          {"text.ply", plyOf(mesh, PlyEncoding::kText)},
          {"little.ply", plyOf(mesh, PlyEncoding::kLittleEndian)},
          {"big.ply", plyOf(mesh, PlyEncoding::kBigEndian)},
          {"text.stl", stlTextOf(mesh)},
          {"binary.stl", stlBinaryOf(mesh)},
          {"cage.gltf", gltfOf(mesh)},
          {"cage.glb", glbOf(mesh)}};
}

}  // namespace airclay
