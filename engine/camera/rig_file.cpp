// SPDX-License-Identifier: MIT
// Reads rigs in TOML, as these programs write them:
//   Anipose, FreeMoCap   one table per camera, [cam_0] …; [metadata]; the unit is that of the board's squares
//   Pose2Sim             one table per camera, any name; sizes with a decimal point; [metadata]
//   Caliscope            [cameras.0] …, always metres; before 2023 [cam_0] … in config.toml
// The common rule: every table that contains a `matrix` is a camera.
#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "engine/camera/rig_diagnostics.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// A rig of 32 cameras takes about 20 kB.
constexpr std::uintmax_t kMaxFileBytes = 4 << 20;

toml::table parse(const std::filesystem::path& file) {
  std::error_code status;
  const std::uintmax_t size = std::filesystem::file_size(file, status);
  if (status) throw Error(file.string() + ": the rig file is missing or is not a readable file");
  if (size > kMaxFileBytes)
    throw Error(file.string() + ": the file is larger than 4 MB; expected a rig in TOML");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file.string() + ": the rig file cannot be opened for reading");
  const std::string content{std::istreambuf_iterator<char>(in), {}};
  try {
    return toml::parse(content, file.string());
  } catch (const toml::parse_error& error) {
    std::ostringstream message;
    message << file.string() << ':' << error.source().begin.line << ": " << error.description()
            << "; expected a rig in TOML";
    std::string line = message.str();
    std::replace(line.begin(), line.end(), '\n', ' ');
    throw Error(line);
  }
}

/// One table of the file and its place for messages. Every getter throws an Error that names file, table and
/// key.
struct Entry {
  const toml::table& table;
  std::string where;  // "FILE: [cam_0] "

  [[noreturn]] void fail(const std::string& key, const std::string& expected) const {
    const toml::node* node = table.get(key);
    std::string line = node ? " (line " + std::to_string(node->source().begin.line) + ")" : "";
    throw Error(where + key + line + (node ? " must be " : " is missing; it must be ") + expected);
  }

  /// Whether the key has a value: some writers use the string "null" for none.
  bool has(const std::string& key) const {
    return table.contains(key) && table[key].value<std::string>() != "null";
  }

  /// The finite numbers of an array, row by row if it is an array of arrays.
  std::vector<double> numbers(const std::string& key, const std::string& expected) const {
    std::vector<double> values;
    const toml::array* array = table[key].as_array();
    if (!array) fail(key, expected);
    append(*array, values, key, expected);
    return values;
  }

  Vec3 vector(const std::string& key, const std::string& expected) const {
    const std::vector<double> values = numbers(key, expected);
    if (values.size() != 3) fail(key, expected);
    return {values[0], values[1], values[2]};
  }

 private:
  void append(const toml::array& array, std::vector<double>& values, const std::string& key,
              const std::string& expected) const {
    for (const toml::node& node : array) {
      if (const toml::array* row = node.as_array(); row && &array == table[key].as_array()) {
        append(*row, values, key, expected);
        continue;
      }
      const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
      if (!value || !std::isfinite(*value)) fail(key, expected + ", all finite");
      values.push_back(*value);
    }
  }
};

bool isIgnored(const Entry& entry) {
  return entry.table["ignore"].value_or(false);
}

/// The `name`, or `fallback` without one. Caliscope names its videos after the camera's number.
std::string cameraName(const Entry& entry, const std::string& fallback) {
  if (!entry.has("name")) return fallback;
  if (const toml::value<std::int64_t>* number = entry.table["name"].as_integer())
    return std::to_string(number->get());
  const std::optional<std::string> name = entry.table["name"].value<std::string>();
  if (!name) entry.fail("name", "a string, the name of the camera's video");
  return *name;
}

/// Without a size it stays 0 x 0. Pose2Sim writes integers with a decimal point.
void readSize(const Entry& entry, CameraEntry& camera) {
  if (!entry.has("size")) return;
  const std::string expected = "[width, height] in pixels, 16 to 16384 each";
  const std::vector<double> size = entry.numbers("size", expected);
  if (size.size() != 2) entry.fail("size", expected);
  for (const double side : size)
    if (side != std::floor(side) || side < kMinImageSide || side > kMaxImageSide)
      entry.fail("size", expected);
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
}

Camera readCamera(const Entry& entry, const std::string& name, double metres, const std::string& file) {
  CameraEntry camera;
  camera.name = cameraName(entry, name);
  readSize(entry, camera);
  const std::string expected_matrix = "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]";
  const std::vector<double> matrix = entry.numbers("matrix", expected_matrix);
  if (matrix.size() != 9) entry.fail("matrix", expected_matrix);
  camera.matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.data());
  if (entry.has("fisheye")) {
    const toml::value<bool>* fisheye = entry.table["fisheye"].as_boolean();
    if (!fisheye) entry.fail("fisheye", "true or false");
    camera.fisheye = fisheye->get();
  }
  camera.distortions = entry.numbers("distortions", "4, 5 or 8 numbers in OpenCV's order (4 with fisheye)");
  const auto line = entry.table.get("distortions")->source().begin.line;
  checkDistortions(camera, "distortions (line " + std::to_string(line) + ")", file);
  camera.rotation = entry.numbers("rotation", "3 numbers (Rodrigues) or a 3 x 3 matrix");
  camera.translation_m = metres * entry.vector("translation", "[tx, ty, tz]");
  return cameraFromEntry(camera, file);
}

struct NamedTable {
  std::string name;
  const toml::table* table;
};

/// Tables of `parent` that satisfy `predicate(name, table)`, in file order (toml++ sorts alphabetically:
/// cam_10 before cam_2).
template <class Predicate>
std::vector<NamedTable> tablesInOrder(const toml::table& parent, Predicate predicate) {
  std::vector<NamedTable> found;
  for (const auto& [key, node] : parent)
    if (const toml::table* table = node.as_table(); table && predicate(std::string(key.str()), *table))
      found.push_back({std::string(key.str()), table});
  std::stable_sort(found.begin(), found.end(), [](const NamedTable& a, const NamedTable& b) {
    const toml::source_position a_begin = a.table->source().begin, b_begin = b.table->source().begin;
    return a_begin < b_begin;
  });
  return found;
}

/// Any table with a matrix is a camera; so is one named like a camera that has a pose but lacks its matrix.
bool isCamera(const std::string& name, const toml::table& table) {
  if (name == "metadata" || name == "workspace") return false;
  if (table.contains("matrix")) return true;
  return name.starts_with("cam") && (table.contains("rotation") || table.contains("translation"));
}

/// Whether this is Caliscope's camera_array.toml, which has no units: always metres.
bool isCameraArray(const toml::table& root) {
  const toml::table* cameras = root["cameras"].as_table();
  return cameras && std::all_of(cameras->begin(), cameras->end(),
                                [](const auto& item) { return item.second.is_table(); });
}

/// Reads one file. An error in one part does not hide errors in the others.
class RigReader {
 public:
  RigReader(const toml::table& root, const std::string& file, RigUnits units)
      : root_(root), file_(file), units_(units) {
    result_.where = file;
  }

  ParsedRig read() {
    if (isCameraArray(root_))
      readCameraArray();
    else
      readTables();
    collectError([&] { readWorkspace(); });
    return std::move(result_);
  }

 private:
  /// Runs `read`; an Error becomes an entry of the result's errors.
  template <class Read>
  void collectError(Read read) {
    try {
      read();
    } catch (const Error& error) {
      result_.errors.push_back(diagnosticFromError(error, file_));
    }
  }

  /// The file's unit of length.
  double metresPerUnit() const {
    if (const toml::node_view<const toml::node> written = root_["metadata"]["units"]) {
      const std::optional<std::string> unit = written.value<std::string>();
      if (unit == "m") return 1;
      if (unit == "mm") return 1e-3;
      throw Error(file_ + ": [metadata] units (line " + std::to_string(written.node()->source().begin.line) +
                  ") must be \"m\" or \"mm\"");
    }
    if (units_ == RigUnits::kAsWritten)
      throw Error(file_ +
                  ": [metadata] units is missing; expected units = \"m\" or \"mm\", or the option --units");
    return units_ == RigUnits::kMillimetres ? 1e-3 : 1;
  }

  void add(const Entry& entry, const std::string& name, double metres) {
    collectError([&] {
      const Camera camera = readCamera(entry, name, metres, file_);
      const toml::node* written = entry.table.get("name");
      const auto line = (written ? written->source() : entry.table.source()).begin.line;
      const auto [first, is_new] = line_of_name_.emplace(camera.name, line);
      if (!is_new)
        throw Error(entry.where + "name (line " + std::to_string(line) + "): two cameras are named \"" +
                    camera.name + "\", the first in line " + std::to_string(first->second) +
                    "; expected unique names");
      result_.rig.cameras.push_back(camera);
    });
  }

  /// Skips cameras without a pose, which Caliscope could not calibrate.
  void readCameraArray() {
    const double metres = units_ == RigUnits::kMillimetres ? 1e-3 : 1;
    const auto any = [](const std::string&, const toml::table&) { return true; };
    for (const auto& [key, table] : tablesInOrder(*root_["cameras"].as_table(), any)) {
      const Entry entry{*table, file_ + ": [cameras." + key + "] "};
      if (isIgnored(entry) || !entry.has("rotation") || !entry.has("translation")) continue;
      const auto numbered = [&](const char* id_key, const std::string& prefix) {
        const std::int64_t id = (*table)[id_key].value_or(std::int64_t{-1});
        return id >= 0 ? prefix + std::to_string(id) : "";
      };
      std::string name = numbered("cam_id", "cam_");
      if (name.empty()) name = numbered("port", "port_");  // the key's name until 2025
      add(entry, name.empty() ? "cam_" + key : name, metres);
    }
  }

  void readTables() {
    const std::vector<NamedTable> tables = tablesInOrder(root_, isCamera);
    if (tables.empty())
      throw Error(file_ + ": it has no camera; expected one table with a matrix per camera, such as [cam_0]");
    double metres = 1;
    collectError([&] { metres = metresPerUnit(); });
    for (const auto& [key, table] : tables) {
      const Entry entry{*table, file_ + ": [" + key + "] "};
      if (!isIgnored(entry)) add(entry, key, metres);  // Caliscope's older format has `ignore` too
    }
  }

  /// Reads [workspace], or [metadata.workspace] in files of programs that treat every other table as a
  /// camera.
  void readWorkspace() {
    const bool in_metadata = !root_.contains("workspace");
    const toml::node_view<const toml::node> node =
        in_metadata ? root_["metadata"]["workspace"] : root_["workspace"];
    if (!node) return;
    const toml::table* table = node.as_table();
    if (!table) throw Error(file_ + ": workspace must be a table with center and edge");
    const Entry entry{*table, file_ + (in_metadata ? ": [metadata.workspace] " : ": [workspace] ")};
    Workspace& workspace = result_.rig.workspace;
    if (table->contains("center")) workspace.center = entry.vector("center", "[x, y, z] in metres");
    if (!table->contains("edge")) return;
    const std::optional<double> edge = (*table)["edge"].value<double>();
    if (!edge || !(*edge > 0) || !std::isfinite(*edge)) entry.fail("edge", "a length in metres, above 0");
    workspace.edge_m = *edge;
  }

  const toml::table& root_;
  const std::string file_;
  const RigUnits units_;
  ParsedRig result_;
  std::map<std::string, toml::source_index> line_of_name_;
};

}  // namespace

ParsedRig parseRig(const std::filesystem::path& file, RigUnits units) {
  const toml::table root = parse(file);
  return RigReader(root, file.string(), units).read();
}

Rig readRig(const std::filesystem::path& file, RigUnits units) {
  const ParsedRig reading = parseRig(file, units);
  Rig rig = reading.validRig();
  checkRig(rig, file);
  return rig;
}

}  // namespace airclay
