// SPDX-License-Identifier: MIT
// PLY, text and binary (Turk 1994, "The PLY polygon file format"): the elements `vertex` and `face`. Edges
// are counted; other elements and properties are skipped.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/mesh_source.h"

namespace airclay {
namespace {

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

std::optional<Scalar> scalarNamed(std::string_view name) {
  if (name == "char" || name == "int8") return Scalar::kInt8;
  if (name == "uchar" || name == "uint8") return Scalar::kUint8;
  if (name == "short" || name == "int16") return Scalar::kInt16;
  if (name == "ushort" || name == "uint16") return Scalar::kUint16;
  if (name == "int" || name == "int32") return Scalar::kInt32;
  if (name == "uint" || name == "uint32") return Scalar::kUint32;
  if (name == "float" || name == "float32") return Scalar::kFloat;
  if (name == "double" || name == "float64") return Scalar::kDouble;
  return std::nullopt;
}

std::size_t bytesOf(Scalar type) {
  switch (type) {
    case Scalar::kInt8:
    case Scalar::kUint8:
      return 1;
    case Scalar::kInt16:
    case Scalar::kUint16:
      return 2;
    case Scalar::kInt32:
    case Scalar::kUint32:
    case Scalar::kFloat:
      return 4;
    case Scalar::kDouble:
      return 8;
  }
  return 0;
}

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat;
  std::optional<Scalar> count_type;  ///< of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { kText, kLittleEndian, kBigEndian };

/// The values after the header, in text or binary.
class Values {
 public:
  Values(const MeshFileContent& file, Encoding encoding, std::size_t begin, long line)
      : file_(file), encoding_(encoding), at_(begin), line_(line) {}

  bool isText() const { return encoding_ == Encoding::kText; }
  std::size_t remaining() const { return file_.bytes.size() - at_; }
  /// An upper bound on the values of a type in the rest of the file.
  std::size_t maxCount(Scalar type) const {
    return isText() ? remaining() / 2 + 1 : remaining() / bytesOf(type);
  }
  double progress() const { return double(at_) / double(file_.bytes.size()); }
  /// The line of the last value read.
  long line() const { return line_; }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(file_.name +
                (isText() ? ":" + std::to_string(line_) : ": byte " + std::to_string(value_at_)) + ": " +
                what);
  }

  /// The next value; not finite if the text is not a number. \throw Error at the end of the file
  double next(Scalar type) { return isText() ? nextInText() : nextInBinary(type); }
  void skip(Scalar type) {
    if (isText())
      takeToken();
    else
      takeBytes(bytesOf(type));
  }

  /// A whole number from 0 to `max`.
  std::size_t nextIndex(Scalar type, std::size_t max, const std::string& what) {
    const double value = next(type);
    if (!(value >= 0 && value <= double(max)) || value != std::floor(value))
      fail(what + (std::isfinite(value) ? " " + shortNumber(value) : "") +
           " is out of range; expected 0 to " + std::to_string(max));
    return std::size_t(value);
  }

 private:
  static std::string shortNumber(double value) {
    const std::string text = exactNumber(value);
    return text.size() > 24 ? text.substr(0, 24) + "..." : text;
  }

  [[noreturn]] void failEnd() const {
    throw Error(file_.name + ": the file ends before its last element; it is truncated");
  }

  std::string_view takeToken() {
    const std::string_view bytes = file_.bytes;
    for (; at_ < bytes.size() && isSpace(bytes[at_]); ++at_) line_ += bytes[at_] == '\n';
    if (at_ == bytes.size()) failEnd();
    const std::size_t begin = at_;
    while (at_ < bytes.size() && !isSpace(bytes[at_])) ++at_;
    return bytes.substr(begin, at_ - begin);
  }
  static bool isSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  double nextInText() { return parseNumber(takeToken()).value_or(std::nan("")); }

  std::string_view takeBytes(std::size_t count) {
    value_at_ = at_;
    if (remaining() < count) failEnd();
    at_ += count;
    return file_.bytes.substr(value_at_, count);
  }

  double nextInBinary(Scalar type) {
    const std::string_view bytes = takeBytes(bytesOf(type));
    switch (type) {
      case Scalar::kInt8:
        return numberIn<std::int8_t>(bytes);
      case Scalar::kUint8:
        return numberIn<std::uint8_t>(bytes);
      case Scalar::kInt16:
        return numberIn<std::int16_t>(bytes);
      case Scalar::kUint16:
        return numberIn<std::uint16_t>(bytes);
      case Scalar::kInt32:
        return numberIn<std::int32_t>(bytes);
      case Scalar::kUint32:
        return numberIn<std::uint32_t>(bytes);
      case Scalar::kFloat:
        return double(numberIn<float>(bytes));
      case Scalar::kDouble:
        return numberIn<double>(bytes);
    }
    return 0;
  }

  template <typename T>
  T numberIn(std::string_view bytes) const {
    static_assert(std::endian::native == std::endian::little);
    char ordered[sizeof(T)];
    std::copy(bytes.begin(), bytes.end(), ordered);
    if (encoding_ == Encoding::kBigEndian) std::reverse(ordered, ordered + sizeof(T));
    T value;
    std::memcpy(&value, ordered, sizeof value);
    return value;
  }

  const MeshFileContent& file_;
  const Encoding encoding_;
  std::size_t at_, value_at_ = 0;
  long line_;
};

class PlyReader {
 public:
  explicit PlyReader(const MeshFileContent& file) : file_(file) {
    readHeader();
    Values values(file_, encoding_, header_end_, line_ + 1);
    for (const Element& element : elements_) {
      checkRoom(element, values);
      if (element.name == "vertex")
        readVertices(element, values);
      else if (element.name == "face")
        readFaces(element, values);
      else
        skipElement(element, values);
    }
    if (mesh_.points.empty()) throw Error(file_.name + ": no vertices; expected `element vertex`");
    if (mesh_.faces.empty()) throw Error(file_.name + ": no faces; expected `element face`");
    mesh_.format = encoding_ == Encoding::kText           ? "PLY, text"
                   : encoding_ == Encoding::kLittleEndian ? "PLY, binary little endian"
                                                          : "PLY, binary big endian";
    if (encoding_ != Encoding::kText) mesh_.face_lines.clear();
  }

  MeshSource take() { return std::move(mesh_); }

 private:
  [[noreturn]] void failHeader(const std::string& what) const {
    throw Error(file_.name + ":" + std::to_string(line_) + ": " + what);
  }

  /// The header's next line.
  std::string_view readLine() {
    ++line_;
    const std::size_t end = file_.bytes.find('\n', header_end_);
    if (end == std::string_view::npos) failHeader("`end_header` is missing");
    std::string_view line = file_.bytes.substr(header_end_, end - header_end_);
    header_end_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  static std::vector<std::string_view> tokensOf(std::string_view line) {
    std::vector<std::string_view> tokens;
    while (true) {
      const std::size_t begin = line.find_first_not_of(" \t");
      if (begin == std::string_view::npos) return tokens;
      const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
      tokens.push_back(line.substr(begin, end - begin));
      line.remove_prefix(end);
    }
  }

  void readHeader() {
    if (!file_.bytes.starts_with("ply")) throw Error(file_.name + ":1: a PLY file begins with `ply`");
    readLine();
    bool has_format = false;
    while (true) {
      const std::vector<std::string_view> tokens = tokensOf(readLine());
      if (tokens.empty() || tokens[0] == "comment" || tokens[0] == "obj_info") continue;
      if (tokens[0] == "end_header") break;
      if (tokens[0] == "format") {
        readFormat(tokens);
        has_format = true;
      } else if (tokens[0] == "element") {
        readElement(tokens);
      } else if (tokens[0] == "property") {
        readProperty(tokens);
      } else {
        failHeader("'" + printable(tokens[0]) +
                   "' is not a statement of a PLY header: format, element, property, comment or end_header");
      }
    }
    if (!has_format) failHeader("the header has no `format` line");
  }

  void readFormat(const std::vector<std::string_view>& tokens) {
    const std::string_view name = tokens.size() > 1 ? tokens[1] : std::string_view();
    if (name == "ascii")
      encoding_ = Encoding::kText;
    else if (name == "binary_little_endian")
      encoding_ = Encoding::kLittleEndian;
    else if (name == "binary_big_endian")
      encoding_ = Encoding::kBigEndian;
    else
      failHeader("format '" + printable(name) +
                 "' is unknown; expected ascii, binary_little_endian or binary_big_endian");
  }

  void readElement(const std::vector<std::string_view>& tokens) {
    const std::optional<double> count = tokens.size() == 3 ? parseNumber(tokens[2]) : std::nullopt;
    if (!count || *count < 0 || *count > 1e15 || *count != std::floor(*count))
      failHeader("an element needs a name and a count, as in `element vertex 8`");
    for (const Element& known : elements_)
      if (known.name == tokens[1]) failHeader("element '" + printable(tokens[1]) + "' occurs twice");
    elements_.push_back({std::string(tokens[1]), std::size_t(*count), {}});
  }

  void readProperty(const std::vector<std::string_view>& tokens) {
    if (elements_.empty()) failHeader("a property before the first element");
    Property property;
    const bool is_list = tokens.size() > 1 && tokens[1] == "list";
    if (tokens.size() != (is_list ? 5u : 3u))
      failHeader(
          "a property needs a type and a name, as in `property float x` or `property list uchar int "
          "vertex_indices`");
    if (is_list) property.count_type = knownScalar(tokens[2]);
    property.type = knownScalar(tokens[tokens.size() - 2]);
    property.name = tokens.back();
    elements_.back().properties.push_back(std::move(property));
  }

  Scalar knownScalar(std::string_view name) const {
    const std::optional<Scalar> type = scalarNamed(name);
    if (!type) failHeader("'" + printable(name) + "' is not a PLY type; expected float, uchar, int …");
    return *type;
  }

  /// Rejects a count that exceeds the rest of the file, before memory is allocated for it.
  void checkRoom(const Element& element, const Values& values) const {
    std::size_t min_bytes = 0;  // bytes of one
    for (const Property& property : element.properties)
      min_bytes += values.isText() ? 2 : bytesOf(property.count_type.value_or(property.type));
    // In text, no space needs to follow the last number.
    const std::size_t room = values.remaining() + (values.isText() ? 1 : 0);
    if (element.count > 0 && min_bytes > 0 && element.count > room / min_bytes)
      throw Error(file_.name + ": the header declares " + std::to_string(element.count) + " of element '" +
                  printable(element.name) + "', but only " + std::to_string(values.remaining()) +
                  " bytes follow; the file is truncated or damaged");
  }

  static const Property* findProperty(const Element& element, std::string_view name) {
    for (const Property& property : element.properties)
      if (property.name == name) return &property;
    return nullptr;
  }

  static void skip(const Property& property, Values& values) {
    std::size_t count = 1;
    if (property.count_type)
      count = values.nextIndex(*property.count_type, values.maxCount(property.type), "a list's length");
    for (std::size_t i = 0; i < count; ++i) values.skip(property.type);
  }

  static void skipProperties(const Element& element, const Property* but, Values& values) {
    for (const Property& property : element.properties)
      if (&property != but) skip(property, values);
  }

  void skipElement(const Element& element, Values& values) {
    if (element.name == "edge") mesh_.loose_edges += element.count;
    if (element.name == "tristrips" && element.count > 0)
      throw Error(file_.name + ": triangle strips (element tristrips) are not supported; export faces");
    if (element.properties.empty()) return;
    for (std::size_t i = 0; i < element.count; ++i) {
      reportRows(i, values);
      skipProperties(element, nullptr, values);
    }
  }

  static void reportRows(std::size_t row, const Values& values) {
    if (row % 4096 == 0) reportProgress(values.progress());
  }

  void readVertices(const Element& element, Values& values) {
    for (const char* axis : {"x", "y", "z"}) {
      const Property* property = findProperty(element, axis);
      if (!property || property->count_type)
        throw Error(file_.name + ": its vertices have no property " + axis + "; they need x, y and z");
    }
    if (element.count > kMaxMeshPoints)
      throw Error(file_.name + ": more than " + std::to_string(kMaxMeshPoints) + " vertices");
    mesh_.points.reserve(element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      reportRows(i, values);
      Vec3 point = Vec3::Zero();
      for (const Property& property : element.properties) {
        const int axis = property.name == "x" ? 0 : property.name == "y" ? 1 : property.name == "z" ? 2 : -1;
        if (axis < 0) {
          skip(property, values);
          continue;
        }
        point[axis] = values.next(property.type);
        if (!std::isfinite(point[axis]))
          values.fail("coordinate " + property.name + " of vertex " + std::to_string(i + 1) +
                      " is not a finite number");
      }
      mesh_.points.push_back(point);
    }
  }

  void readFaces(const Element& element, Values& values) {
    const Property* corners = findProperty(element, "vertex_indices");
    if (!corners) corners = findProperty(element, "vertex_index");
    if (element.count > 0 && (!corners || !corners->count_type))
      throw Error(file_.name + ": its faces have no list vertex_indices");
    if (mesh_.points.empty())
      throw Error(file_.name + ": its faces come before its vertices; expected the vertices first");
    std::size_t corner_count = 0;
    for (std::size_t i = 0; i < element.count; ++i) {
      reportRows(i, values);
      std::vector<int> face;
      for (const Property& property : element.properties) {
        if (&property == corners)
          face = readFace(i, property, values);
        else
          skip(property, values);
      }
      corner_count += face.size();
      if (corner_count > kMaxMeshCorners)
        values.fail("more than " + std::to_string(kMaxMeshCorners) + " face corners");
      mesh_.faces.push_back(std::move(face));
      mesh_.face_lines.push_back(values.line());
    }
  }

  std::vector<int> readFace(std::size_t index, const Property& corners, Values& values) const {
    const std::string face_text = "face " + std::to_string(index + 1);
    const std::size_t size = values.nextIndex(*corners.count_type, values.maxCount(corners.type),
                                              face_text + ": its corner count");
    if (size < 3)
      values.fail(face_text + " has " + std::to_string(size) + " corners; a face needs three or more");
    std::vector<int> face;
    face.reserve(size);
    for (std::size_t k = 0; k < size; ++k)
      face.push_back(
          int(values.nextIndex(corners.type, mesh_.points.size() - 1, face_text + ": vertex index")));
    return face;
  }

  const MeshFileContent& file_;
  Encoding encoding_ = Encoding::kText;
  std::vector<Element> elements_;
  std::size_t header_end_ = 0;
  long line_ = 0;
  MeshSource mesh_;
};

}  // namespace

MeshSource parsePly(const MeshFileContent& file) {
  return PlyReader(file).take();
}

}  // namespace airclay
