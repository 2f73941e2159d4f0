// SPDX-License-Identifier: MIT
// Wavefront OBJ (Wavefront's Advanced Visualizer manual, appendix B1: `v` and `f` statements, relative
// indices, line continuation).
#include <algorithm>
#include <charconv>
#include <optional>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/mesh_source.h"

namespace airclay {
namespace {

/// Splits a line at white space.
class Tokens {
 public:
  explicit Tokens(std::string_view line) : rest_(line) {}
  /// The next token; empty at the end of the line.
  std::string_view next() {
    const size_t begin = std::min(rest_.find_first_not_of(kSpace), rest_.size());
    const size_t end = std::min(rest_.find_first_of(kSpace, begin), rest_.size());
    const std::string_view token = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return token;
  }

 private:
  static constexpr const char* kSpace = " \t\r\v\f";
  std::string_view rest_;
};

/// Splits text into lines; a line that ends in a backslash continues on the next. Comments are removed first,
/// because they may end in a backslash, for example in a Windows path.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);  // a byte-order mark
  }
  /// False at the end of the text.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    number_ = lines_read_ + 1;
    line = readLine();
    if (!line.ends_with('\\')) return true;
    joined_.clear();
    while (line.ends_with('\\')) {
      joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
      line = rest_.empty() ? std::string_view() : readLine();
    }
    line = joined_.append(line);
    return true;
  }
  /// The number of the last line read, from 1; the first one of a continued line.
  long number() const { return number_; }
  /// Characters not yet read.
  std::size_t remaining() const { return rest_.size(); }

 private:
  std::string_view readLine() {
    const size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++lines_read_;
    if (const size_t comment = line.find('#'); comment != std::string_view::npos)
      return line.substr(0, comment);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  std::string_view rest_;
  std::string joined_;
  long lines_read_ = 0, number_ = 0;
};

/// Reads `v` and `f` statements and counts the edges of `l` statements.
class ObjReader {
 public:
  ObjReader(const MeshFileContent& file, RepeatedCorners repeated) : file_(file.name), repeated_(repeated) {
    ObjLines lines(file.bytes);
    std::string_view line;
    for (std::size_t line_count = 0; lines.next(line); ++line_count) {
      if (line_count % 4096 == 0) reportProgress(1 - double(lines.remaining()) / double(file.bytes.size()));
      line_number_ = lines.number();
      Tokens tokens(line);
      const std::string_view keyword = tokens.next();
      if (keyword == "v") readPoint(tokens);
      if (keyword == "f") readFace(tokens);
      if (keyword == "l") countEdges(tokens);
    }
    if (mesh_.points.empty()) throw Error(file_ + ": no vertices; expected `v x y z` lines");
    if (mesh_.faces.empty()) throw Error(file_ + ": no faces; expected `f a b c …` lines");
    checkForwardIndices();
    mesh_.format = "OBJ";
  }

  MeshSource take() { return std::move(mesh_); }

 private:
  [[noreturn]] void fail(const std::string& what) const { failAt(line_number_, what); }
  [[noreturn]] void failAt(long line, const std::string& what) const {
    throw Error(file_ + ":" + std::to_string(line) + ": " + what);
  }

  void readPoint(Tokens& tokens) {
    Vec3 point = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view token = tokens.next();
      if (token.empty()) fail("a vertex has " + std::to_string(axis) + " coordinates; it needs x, y and z");
      const std::optional<double> number = parseNumber(token);
      if (!number) fail("coordinate '" + printable(token) + "' is not a finite number");
      point[axis] = *number;
    }
    if (mesh_.points.size() == kMaxMeshPoints)
      fail("more than " + std::to_string(kMaxMeshPoints) + " vertices");
    mesh_.points.push_back(point);
  }

  void readFace(Tokens& tokens) {
    std::vector<int> face;
    for (std::string_view token = tokens.next(); !token.empty(); token = tokens.next()) {
      face.push_back(readCorner(token));
      if (++corner_count_ > kMaxMeshCorners)
        fail("more than " + std::to_string(kMaxMeshCorners) + " face corners");
    }
    if (face.size() < 3)
      fail("a face needs three or more different corners; this one has " + std::to_string(face.size()));
    if (repeated_ == RepeatedCorners::kRefuse) refuseRepeatedCorners(face);
    mesh_.faces.push_back(std::move(face));
    mesh_.face_lines.push_back(line_number_);
  }

  void refuseRepeatedCorners(std::vector<int> face) const {
    std::sort(face.begin(), face.end());
    const auto twice = std::adjacent_find(face.begin(), face.end());
    if (twice != face.end())
      fail("a face needs three or more different corners; this one has vertex " + std::to_string(*twice + 1) +
           " twice");
  }

  void countEdges(Tokens& tokens) {
    std::size_t vertices = 0;
    while (!tokens.next().empty()) ++vertices;
    mesh_.loose_edges += vertices > 0 ? vertices - 1 : 0;
  }

  /// `point`, `point/texture`, `point//normal` or `point/texture/normal`; negative indices count backwards
  /// from the last vertex read.
  int readCorner(std::string_view token) {
    const std::string_view texture_and_normal = token.substr(std::min(token.find('/'), token.size()));
    const std::string_view digits = token.substr(0, token.size() - texture_and_normal.size());
    long index = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    const bool is_number = !digits.empty() && end == digits.data() + digits.size();
    if (!is_number || texture_and_normal.find_first_not_of("/-0123456789") != std::string_view::npos)
      fail("'" + printable(token) + "' is not a face corner; expected a vertex index, as in 3 or 3/1/2");
    const long known = long(mesh_.points.size());
    if (index < 0) index += known + 1;
    if (error != std::errc() || index < 1 || index > long(kMaxMeshPoints)) failRange(line_number_, digits);
    if (index > known) forward_.push_back({int(index - 1), line_number_});
    return int(index - 1);
  }

  [[noreturn]] void failRange(long line, std::string_view index) const {
    failAt(line, "face index " + printable(index) + " is out of range; there are vertices 1 to " +
                     std::to_string(mesh_.points.size()) + " here");
  }

  /// A face may come before its vertices.
  void checkForwardIndices() const {
    for (const ForwardIndex& forward : forward_)
      if (size_t(forward.point) >= mesh_.points.size())
        failRange(forward.line, std::to_string(forward.point + 1));
  }

  struct ForwardIndex {
    int point;
    long line;
  };

  const std::string& file_;
  const RepeatedCorners repeated_;
  MeshSource mesh_;
  std::vector<ForwardIndex> forward_;
  size_t corner_count_ = 0;
  long line_number_ = 0;
};

}  // namespace

MeshSource parseObj(const MeshFileContent& file, RepeatedCorners repeated) {
  return ObjReader(file, repeated).take();
}

}  // namespace airclay
