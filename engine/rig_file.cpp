// SPDX-License-Identifier: MIT
// Rigs in files: Anipose's calibration TOML (a table a camera, [cam_0] …) with the unit spelled out, and
// Caliscope's camera_array.toml ([cameras.0] …, always metres).
#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "engine/error.h"
#include "engine/mesh_file.h"
#include "engine/rig.h"

namespace airclay {
namespace {

// A rig of 32 cameras takes some 20 kB.
constexpr std::uintmax_t kMaxFileBytes = 4 << 20;

toml::table parse(const std::filesystem::path& file) {
  std::error_code fault;
  const std::uintmax_t size = std::filesystem::file_size(file, fault);
  if (fault) throw Error(file.string() + ": the rig's file is missing or no readable file");
  if (size > kMaxFileBytes)
    throw Error(file.string() + ": it is larger than 4 MB; a rig's TOML would be right");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file.string() + ": the rig's file cannot be opened for reading");
  const std::string content{std::istreambuf_iterator<char>(in), {}};
  try {
    return toml::parse(content, file.string());
  } catch (const toml::parse_error& error) {
    std::ostringstream message;
    message << file.string() << ':' << error.source().begin.line << ": " << error.description()
            << "; a rig in TOML would be right";
    std::string line = message.str();
    std::replace(line.begin(), line.end(), '\n', ' ');
    throw Error(line);
  }
}

/// One table of the file, and how to speak of it. Every getter throws an Error that names file, table and
/// key.
struct Entry {
  const toml::table& table;
  std::string where;  // "FILE: [cam_0] "

  [[noreturn]] void fail(const std::string& key, const std::string& right) const {
    const toml::node* node = table.get(key);
    std::string line = node ? " (line " + std::to_string(node->source().begin.line) + ")" : "";
    throw Error(where + key + line + (node ? " must be " : " is missing; it must be ") + right);
  }

  /// The finite numbers of an array, flattened when it is an array of rows.
  std::vector<double> numbers(const std::string& key, const std::string& right) const {
    std::vector<double> values;
    const toml::array* array = table[key].as_array();
    if (!array) fail(key, right);
    append(*array, values, key, right);
    return values;
  }

  Vec3 vector(const std::string& key, const std::string& right) const {
    const std::vector<double> values = numbers(key, right);
    if (values.size() != 3) fail(key, right);
    return {values[0], values[1], values[2]};
  }

 private:
  void append(const toml::array& array, std::vector<double>& values, const std::string& key,
              const std::string& right) const {
    for (const toml::node& node : array) {
      if (const toml::array* row = node.as_array(); row && &array == table[key].as_array()) {
        append(*row, values, key, right);
        continue;
      }
      const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
      if (!value || !std::isfinite(*value)) fail(key, right + ", finite numbers all");
      values.push_back(*value);
    }
  }
};

std::string cameraName(const Entry& entry, const std::string& fallback) {
  if (!entry.table.contains("name")) return fallback;
  const std::optional<std::string> name = entry.table["name"].value<std::string>();
  if (!name) entry.fail("name", "a text that names the camera's video");
  return *name;
}

Camera readCamera(const Entry& entry, const std::string& name, double metres, const std::string& file) {
  CameraEntry camera;
  camera.name = name;
  const std::string size_form = "[width, height] in pixels, 16 to 16384 each";
  const std::vector<double> size = entry.numbers("size", size_form);
  if (size.size() != 2) entry.fail("size", size_form);
  for (const double side : size)
    if (side != std::floor(side) || side < kMinPictureSide || side > kMaxPictureSide)
      entry.fail("size", size_form);
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);

  const std::string matrix_form = "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]";
  const std::vector<double> matrix = entry.numbers("matrix", matrix_form);
  if (matrix.size() != 9) entry.fail("matrix", matrix_form);
  camera.matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.data());
  if (entry.table.contains("fisheye")) {
    const toml::value<bool>* fisheye = entry.table["fisheye"].as_boolean();
    if (!fisheye) entry.fail("fisheye", "true or false");
    camera.fisheye = fisheye->get();
  }
  camera.distortions = entry.numbers("distortions", "4, 5 or 8 numbers in OpenCV's order (4 with fisheye)");
  camera.rotation = entry.numbers("rotation", "3 numbers (Rodrigues) or a 3 x 3 matrix");
  camera.translation_m = metres * entry.vector("translation", "[tx, ty, tz]");
  return cameraFromEntry(camera, file);
}

/// The length of one of the file's units.
double metresPerUnit(const toml::table& root, RigUnits units, const std::string& file) {
  if (const toml::node_view<const toml::node> written = root["metadata"]["units"]) {
    const std::optional<std::string> unit = written.value<std::string>();
    if (unit == "m") return 1;
    if (unit == "mm") return 1e-3;
    throw Error(file + ": [metadata] units must be \"m\" or \"mm\"");
  }
  if (units == RigUnits::kAsWritten)
    throw Error(file + ": [metadata] units is missing; units = \"m\" or \"mm\", or --units, would be right");
  return units == RigUnits::kMillimetres ? 1e-3 : 1;
}

struct NamedTable {
  std::string name;
  const toml::table* table;
};

/// Tables of `parent` whose name starts with `prefix`, in the order of the file (TOML's own is alphabetical:
/// cam_10 before cam_2).
std::vector<NamedTable> tablesInOrder(const toml::table& parent, const std::string& prefix) {
  std::vector<NamedTable> found;
  for (const auto& [key, node] : parent)
    if (const toml::table* table = node.as_table(); table && key.str().substr(0, prefix.size()) == prefix)
      found.push_back({std::string(key.str()), table});
  std::stable_sort(found.begin(), found.end(), [](const NamedTable& a, const NamedTable& b) {
    const toml::source_position a_begin = a.table->source().begin, b_begin = b.table->source().begin;
    return a_begin < b_begin;
  });
  return found;
}

/// Caliscope's camera_array.toml: no unit is written, it is metres.
bool isCameraArray(const toml::table& root) {
  const toml::table* cameras = root["cameras"].as_table();
  return cameras && std::all_of(cameras->begin(), cameras->end(),
                                [](const auto& item) { return item.second.is_table(); });
}

std::vector<Camera> readCameraArray(const toml::table& root, RigUnits units, const std::string& file) {
  const double metres = units == RigUnits::kMillimetres ? 1e-3 : 1;
  std::vector<Camera> cameras;
  for (const auto& [key, table] : tablesInOrder(*root["cameras"].as_table(), "")) {
    const Entry entry{*table, file + ": [cameras." + key + "] "};
    const bool is_placed = table->contains("rotation") && table->contains("translation");
    if ((*table)["ignore"].value_or(false) || !is_placed) continue;
    const std::int64_t id = (*table)["cam_id"].value_or(std::int64_t{-1});
    const std::string number = id >= 0 ? std::to_string(id) : key;
    cameras.push_back(readCamera(entry, cameraName(entry, "cam_" + number), metres, file));
  }
  return cameras;
}

std::vector<Camera> readAnipose(const toml::table& root, RigUnits units, const std::string& file) {
  const std::vector<NamedTable> tables = tablesInOrder(root, "cam");
  if (tables.empty()) throw Error(file + ": it has no camera; a table [cam_0] a camera would be right");
  const double metres = metresPerUnit(root, units, file);
  std::vector<Camera> cameras;
  for (const auto& [key, table] : tables) {
    if ((*table)["ignore"].value_or(false)) continue;  // Caliscope's older form has it too
    const Entry entry{*table, file + ": [" + key + "] "};
    cameras.push_back(readCamera(entry, cameraName(entry, key), metres, file));
  }
  return cameras;
}

Workspace readWorkspace(const toml::table& root, const std::string& file) {
  Workspace workspace;
  if (!root.contains("workspace")) return workspace;
  const toml::table* table = root["workspace"].as_table();
  if (!table) throw Error(file + ": workspace must be a table with center and edge");
  const Entry entry{*table, file + ": [workspace] "};
  if (table->contains("center")) workspace.center = entry.vector("center", "[x, y, z] in metres");
  if (table->contains("edge")) {
    const std::optional<double> edge = (*table)["edge"].value<double>();
    if (!edge || !(*edge > 0) || !std::isfinite(*edge)) entry.fail("edge", "a length in metres, above 0");
    workspace.edge_m = *edge;
  }
  return workspace;
}

std::string quoted(const std::string& name) {
  std::string result = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

/// Every distortion coefficient that the model has, k3 and k4..k6 only where one of them is set.
std::vector<double> writtenDistortions(const Lens& lens) {
  const std::array<double, 8>& k = lens.distortion;
  if (lens.model == LensModel::kFisheye) return {k.begin(), k.begin() + 4};
  const bool is_rational = k[5] != 0 || k[6] != 0 || k[7] != 0;
  return {k.begin(), k.begin() + (is_rational ? 8 : 5)};
}

void writeMatrix(std::ostream& out, const char* key, const Mat3& matrix) {
  out << key << " = [";
  for (int row = 0; row < 3; ++row)
    out << (row ? ", [" : "[") << matrix(row, 0) << ", " << matrix(row, 1) << ", " << matrix(row, 2) << "]";
  out << "]\n";
}

void writeList(std::ostream& out, const std::string& key, const std::vector<double>& values) {
  out << key << " = [";
  for (size_t i = 0; i < values.size(); ++i) out << (i ? ", " : "") << values[i];
  out << "]\n";
}

}  // namespace

Rig readRig(const std::filesystem::path& file, RigUnits units) {
  const toml::table root = parse(file);
  Rig rig;
  rig.cameras = isCameraArray(root) ? readCameraArray(root, units, file.string())
                                    : readAnipose(root, units, file.string());
  rig.workspace = readWorkspace(root, file.string());
  checkRig(rig, file);
  return rig;
}

void writeRig(const std::filesystem::path& file, const Rig& rig, WrittenRotations rotations) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);  // a double comes back as it was
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    const Lens& lens = camera.lens;
    const Mat3 matrix = camera.camera_from_world.linear();
    const Eigen::AngleAxisd turn(matrix);
    const Vec3 rotation = turn.angle() * turn.axis();
    const Vec3 translation = camera.camera_from_world.translation();
    out << "[cam_" << i << "]\nname = " << quoted(camera.name) << "\nsize = [" << camera.width << ", "
        << camera.height << "]\nmatrix = [[" << lens.fx << ", 0, " << lens.cx << "], [0, " << lens.fy << ", "
        << lens.cy << "], [0, 0, 1]]\n";
    writeList(out, "distortions", writtenDistortions(lens));
    if (lens.model == LensModel::kFisheye) out << "fisheye = true\n";
    if (rotations == WrittenRotations::kMatrices)
      writeMatrix(out, "rotation", matrix);
    else
      writeList(out, "rotation", {rotation.begin(), rotation.end()});
    writeList(out, "translation", {translation.begin(), translation.end()});
    out << '\n';
  }
  const Vec3& center = rig.workspace.center;
  out << "[workspace]\n";
  writeList(out, "center", {center.begin(), center.end()});
  out << "edge = " << rig.workspace.edge_m << "\n\n[metadata]\nunits = \"m\"\n";
  writeWhole(file, out.str());
}

}  // namespace airclay
