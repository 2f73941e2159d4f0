// SPDX-License-Identifier: MIT
// STL, text and binary (3D Systems 1989, "Stereolithography interface specification"). Normals are ignored:
// the winding defines the outside.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/mesh_source.h"
#include "engine/mesh/point_merger.h"

namespace airclay {
namespace {

constexpr std::size_t kHeaderBytes = 84;    // 80 of free text, then the triangle count
constexpr std::size_t kTriangleBytes = 50;  // a normal, three corners, two bytes of attributes

char lowerCase(char c) {
  return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

/// Collects faces and merges their corners.
class StlBuilder {
 public:
  explicit StlBuilder(const MeshFileContent& file) : file_(file), merger_(mesh_.points) {}

  int addPoint(const Vec3& point) {
    const int index = merger_.add(point);
    if (mesh_.points.size() > kMaxMeshPoints)
      throw Error(file_.name + ": more than " + std::to_string(kMaxMeshPoints) + " vertices");
    return index;
  }
  void addFace(std::vector<int> face) {
    corner_count_ += face.size();
    if (corner_count_ > kMaxMeshCorners)
      throw Error(file_.name + ": more than " + std::to_string(kMaxMeshCorners) + " face corners");
    mesh_.faces.push_back(std::move(face));
  }
  MeshSource& mesh() { return mesh_; }
  MeshSource take() {
    if (mesh_.faces.empty()) throw Error(file_.name + ": no triangles");
    return std::move(mesh_);
  }

 private:
  const MeshFileContent& file_;
  MeshSource mesh_;
  PointMerger merger_;
  std::size_t corner_count_ = 0;
};

/// One statement per line: facet normal, outer loop, three times vertex, endloop, endfacet.
class TextReader {
 public:
  explicit TextReader(const MeshFileContent& file) : file_(file), rest_(file.bytes), builder_(file) {
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      tokens_left_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      if (++line_ % 4096 == 0) reportProgress(1 - double(rest_.size()) / double(file.bytes.size()));
      readLine();
    }
    if (in_solid_) throw Error(file_.name + ": the file ends without `endsolid`; it is truncated or damaged");
    builder_.mesh().format = "STL, text";
  }

  MeshSource take() { return builder_.take(); }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(file_.name + ":" + std::to_string(line_) + ": " + what);
  }

  std::string_view nextToken() {
    constexpr const char* kSpace = " \t\r\v\f";
    const std::size_t begin = std::min(tokens_left_.find_first_not_of(kSpace), tokens_left_.size());
    const std::size_t end = std::min(tokens_left_.find_first_of(kSpace, begin), tokens_left_.size());
    const std::string_view token = tokens_left_.substr(begin, end - begin);
    tokens_left_.remove_prefix(end);
    return token;
  }

  void readLine() {
    const std::string_view token = nextToken();
    if (token.empty()) return;
    std::string keyword;
    for (const char c : token.substr(0, 16)) keyword += lowerCase(c);
    if (keyword != "vertex" && keyword != "endloop" && !face_.empty())
      fail("`endloop` is missing after a loop's vertices");
    if (keyword == "solid") {
      in_solid_ = true;
    } else if (keyword == "endsolid") {
      in_solid_ = false;
    } else if (keyword == "vertex") {
      readVertex();
    } else if (keyword == "endloop") {
      endFace();
    } else if (keyword != "facet" && keyword != "outer" && keyword != "endfacet") {
      fail("'" + printable(token) +
           "' is not an STL statement; expected facet, outer loop, vertex, endloop or endfacet");
    }
  }

  void readVertex() {
    Vec3 point = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view token = nextToken();
      if (token.empty()) fail("a vertex has " + std::to_string(axis) + " coordinates; it needs x, y and z");
      const std::optional<double> number = parseNumber(token);
      if (!number) fail("coordinate '" + printable(token) + "' is not a finite number");
      point[axis] = *number;
    }
    if (face_.empty()) face_line_ = line_;
    face_.push_back(builder_.addPoint(point));
  }

  void endFace() {
    if (face_.size() < 3)
      fail("a loop has " + std::to_string(face_.size()) + " vertices; a triangle needs three");
    builder_.addFace(std::move(face_));
    builder_.mesh().face_lines.push_back(face_line_);
    face_.clear();
  }

  const MeshFileContent& file_;
  std::string_view rest_, tokens_left_;
  StlBuilder builder_;
  std::vector<int> face_;
  long line_ = 0, face_line_ = 0;
  bool in_solid_ = false;
};

MeshSource readBinary(const MeshFileContent& file, std::size_t count) {
  StlBuilder builder(file);
  for (std::size_t t = 0; t < count; ++t) {
    reportProgress(t, count);
    std::vector<int> face;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t at = kHeaderBytes + t * kTriangleBytes + 12 * (corner + 1);
      static_assert(std::endian::native == std::endian::little);
      float xyz[3];
      std::memcpy(xyz, file.bytes.data() + at, sizeof xyz);
      const Vec3 point{double(xyz[0]), double(xyz[1]), double(xyz[2])};
      if (!point.allFinite())
        throw Error(file.name + ": byte " + std::to_string(at) + ": a coordinate of triangle " +
                    std::to_string(t + 1) + " is not a finite number");
      face.push_back(builder.addPoint(point));
    }
    builder.addFace(std::move(face));
  }
  MeshSource mesh = builder.take();
  mesh.format = "STL, binary";
  return mesh;
}

/// Text files begin with `solid`, but so do some binary files.
bool isText(std::string_view bytes) {
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  std::string keyword;
  for (const char c : bytes.substr(begin, 5)) keyword += lowerCase(c);
  return keyword == "solid" && bytes.substr(0, 1024).find('\0') == std::string_view::npos;
}

}  // namespace

MeshSource parseStl(const MeshFileContent& file) {
  const std::size_t size = file.bytes.size();
  std::uint32_t count = 0;
  if (size >= kHeaderBytes) std::memcpy(&count, file.bytes.data() + kHeaderBytes - 4, sizeof count);
  const std::size_t expected = kHeaderBytes + kTriangleBytes * std::size_t(count);
  if (size != expected && isText(file.bytes)) return TextReader(file).take();
  if (size < kHeaderBytes)
    throw Error(file.name + ": not an STL file; expected text that begins with `solid`, or 84 bytes or more");
  if (size < expected)
    throw Error(file.name + ": the header declares " + std::to_string(count) + " triangles, " +
                std::to_string(expected) + " bytes, but the file has " + std::to_string(size) +
                "; it is truncated, or not an STL file");
  MeshSource mesh = readBinary(file, count);
  if (size > expected)
    mesh.notes.push_back("ignored " + std::to_string(size - expected) + " bytes after the last triangle");
  return mesh;
}

}  // namespace airclay
