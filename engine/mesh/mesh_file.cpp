// SPDX-License-Identifier: MIT
// Wavefront OBJ (Wavefront's Advanced Visualizer manual, appendix B1: `v` and `f` statements, relative
// indices, line continuation), PLY, and files that appear whole or not at all.
#include "engine/mesh/mesh_file.h"

#include <algorithm>
#include <bit>
#include <charconv>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/manifold.h"

namespace airclay {
namespace {

constexpr size_t kMaxObjBytes = size_t(256) << 20;  // text of 5 million points and their faces
constexpr size_t kMaxObjPoints = 5'000'000;
constexpr size_t kMaxObjCorners = 20'000'000;  // as many quads as points

/// Takes words off the front of a line.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  /// Empty at the end of the line.
  std::string_view next() {
    const size_t begin = std::min(rest_.find_first_not_of(kSpace), rest_.size());
    const size_t end = std::min(rest_.find_first_of(kSpace, begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }

 private:
  static constexpr const char* kSpace = " \t\r\v\f";
  std::string_view rest_;
};

/// Takes the lines off a text, a line that ends in a backslash together with the next. Comments are cut off
/// first, as one may end in the path of a folder.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);  // a byte-order mark
  }
  /// False at the end of the text.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    number_ = lines_taken_ + 1;
    line = takeLine();
    if (!line.ends_with('\\')) return true;
    joined_.clear();
    while (line.ends_with('\\')) {
      joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
      line = rest_.empty() ? std::string_view() : takeLine();
    }
    line = joined_.append(line);
    return true;
  }
  /// Of the line taken last, counted from 1; of several, the first.
  long number() const { return number_; }
  /// Characters not looked at yet.
  std::size_t left() const { return rest_.size(); }

 private:
  std::string_view takeLine() {
    const size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++lines_taken_;
    if (const size_t comment = line.find('#'); comment != std::string_view::npos)
      return line.substr(0, comment);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  std::string_view rest_;
  std::string joined_;
  long lines_taken_ = 0, number_ = 0;
};

/// The `v` and `f` statements of an OBJ.
class ObjReader {
 public:
  ObjReader(const std::filesystem::path& file, std::string_view text) : file_(file.string()) {
    ObjLines lines(text);
    std::string_view line;
    for (std::size_t taken = 0; lines.next(line); ++taken) {
      if (taken % 4096 == 0) reportProgress(1 - double(lines.left()) / double(text.size()));
      line_number_ = lines.number();
      Words words(line);
      const std::string_view keyword = words.next();
      if (keyword == "v") readPoint(words);
      if (keyword == "f") readFace(words);
    }
    if (mesh_.points.empty()) throw Error(file_ + ": there is no vertex; a cage needs `v x y z` lines");
    if (mesh_.faces.empty()) throw Error(file_ + ": there is no face; a cage needs `f a b c …` lines");
    checkForwardIndices();
  }

  PolygonMesh take() { return std::move(mesh_); }

 private:
  [[noreturn]] void fail(const std::string& what) const { failAt(line_number_, what); }
  [[noreturn]] void failAt(long line, const std::string& what) const {
    throw Error(file_ + ":" + std::to_string(line) + ": " + what);
  }

  void readPoint(Words& words) {
    Vec3 point = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = words.next();
      if (word.empty()) fail("a vertex has " + std::to_string(axis) + " coordinates; it needs x, y and z");
      const std::optional<double> number = parseNumber(word);
      if (!number) fail("coordinate '" + printable(word) + "' is no finite number");
      point[axis] = *number;
    }
    if (mesh_.points.size() == kMaxObjPoints)
      fail("more than " + std::to_string(kMaxObjPoints) + " vertices");
    mesh_.points.push_back(point);
  }

  void readFace(Words& words) {
    std::vector<int> face;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      face.push_back(readCorner(word));
      if (++corner_count_ > kMaxObjCorners)
        fail("more than " + std::to_string(kMaxObjCorners) + " face corners");
    }
    std::vector<int> sorted = face;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (face.size() < 3 || twice != sorted.end())
      fail("a face needs three or more different corners; this one has " +
           (face.size() < 3 ? std::to_string(face.size())
                            : "vertex " + std::to_string(*twice + 1) + " twice"));
    mesh_.faces.push_back(std::move(face));
  }

  /// `point`, `point/texture`, `point//normal` or `point/texture/normal`; negative ones count back from here.
  int readCorner(std::string_view word) {
    const std::string_view texture_and_normal = word.substr(std::min(word.find('/'), word.size()));
    const std::string_view digits = word.substr(0, word.size() - texture_and_normal.size());
    long index = 0;
    const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    const bool is_number = !digits.empty() && end == digits.data() + digits.size();
    if (!is_number || texture_and_normal.find_first_not_of("/-0123456789") != std::string_view::npos)
      fail("'" + printable(word) + "' is no face corner; a corner is a vertex's number, as in 3 or 3/1/2");
    const long known = long(mesh_.points.size());
    if (index < 0) index += known + 1;
    if (fault != std::errc() || index < 1 || index > long(kMaxObjPoints)) failRange(line_number_, digits);
    if (index > known) forward_.push_back({int(index - 1), line_number_});
    return int(index - 1);
  }

  [[noreturn]] void failRange(long line, std::string_view index) const {
    failAt(line, "face index " + printable(index) + " is out of range; there are vertices 1 to " +
                     std::to_string(mesh_.points.size()) + " here");
  }

  /// A face may stand before its vertices.
  void checkForwardIndices() const {
    for (const ForwardIndex& forward : forward_)
      if (size_t(forward.point) >= mesh_.points.size())
        failRange(forward.line, std::to_string(forward.point + 1));
  }

  struct ForwardIndex {
    int point;
    long line;
  };

  std::string file_;
  PolygonMesh mesh_;
  std::vector<ForwardIndex> forward_;
  size_t corner_count_ = 0;
  long line_number_ = 0;
};

void append(std::string& text, double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number, std::chars_format::general, 9).ptr;
  text.append(digits, end);
}

}  // namespace

PolygonMesh readObj(const std::filesystem::path& file) {
  PolygonMesh mesh = ObjReader(file, readWhole(file, kMaxObjBytes)).take();
  checkCage(mesh, file.string());
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
