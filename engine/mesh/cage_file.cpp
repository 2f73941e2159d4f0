// SPDX-License-Identifier: MIT
#include "engine/mesh/cage_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/mesh/cage_repair.h"
#include "engine/mesh/manifold.h"

namespace airclay {
namespace {

constexpr double kMaxCoordinateM = 1e6;  // beyond 1,000 km a file is damaged; it also keeps products finite
// A cage for a workspace of 0.6 m: three times as large, or a hundredth.
constexpr double kLargestPlausibleM = 2, kSmallestPlausibleM = 0.005;
constexpr double kUsualM = 0.2;  // as the presets

struct NamedUnit {
  LengthUnit unit;
  const char* name;
  double metres;
};
constexpr std::array<NamedUnit, 4> kUnits = {{{LengthUnit::kMetre, "m", 1},
                                              {LengthUnit::kCentimetre, "cm", 0.01},
                                              {LengthUnit::kMillimetre, "mm", 0.001},
                                              {LengthUnit::kInch, "in", 0.0254}}};

const NamedUnit& named(LengthUnit unit) {
  return *std::find_if(kUnits.begin(), kUnits.end(), [&](const NamedUnit& one) { return one.unit == unit; });
}

[[noreturn]] void failExtension(const std::filesystem::path& file) {
  std::string list;
  for (const std::string& extension : cageExtensions())
    list += (list.empty() ? "" : extension == cageExtensions().back() ? " or " : ", ") + extension;
  throw Error(file.string() + ": not a cage file by its extension; expected " + list, Fault::kUsage);
}

MeshSource parse(const std::filesystem::path& file, const std::string& extension) {
  const std::string name = file.string(), bytes = readWhole(file, kMaxMeshFileBytes);
  const MeshFileContent content{name, bytes};
  if (bytes.empty()) throw Error(name + ": the file is empty");
  if (extension == ".ply") return parsePly(content);
  if (extension == ".stl") return parseStl(content);
  if (extension == ".gltf" || extension == ".glb") return parseGltf(content, file.parent_path());
  return parseObj(content, RepeatedCorners::kKeep);
}

std::string metresText(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %s", metres < 0.01 ? 1000 * metres : metres,
                metres < 0.01 ? "mm" : "m");
  return text;
}

/// The unit in which `size` is closest to a typical cage's.
const NamedUnit* fittingUnit(double size) {
  const NamedUnit* best = nullptr;
  for (const NamedUnit& unit : kUnits) {
    const double metres = size * unit.metres;
    if (metres > kLargestPlausibleM || metres < kSmallestPlausibleM) continue;
    const auto distance = [&](const NamedUnit& one) {
      return std::abs(std::log(size * one.metres / kUsualM));
    };
    // Inches are rare: only if no other unit fits.
    if (!best || (unit.unit != LengthUnit::kInch && distance(unit) < distance(*best))) best = &unit;
  }
  return best;
}

void hintAtSize(double size, const NamedUnit& unit, const CageReadOptions& options, CageReading& reading) {
  const double metres = size * unit.metres;
  if (options.units || (metres <= kLargestPlausibleM && metres >= kSmallestPlausibleM)) return;
  std::string hint = "its longest side is " + metresText(metres) + " if its numbers are in " + unit.name;
  if (const NamedUnit* fitting = fittingUnit(size))
    hint += "; they look like " + std::string(fitting->name) + " (" + metresText(size * fitting->metres) +
            "): " + options.units_option + " " + fitting->name;
  else
    hint += "; " + options.units_option + " names another unit";
  reading.hints.push_back(hint);
}

void hintAtTriangles(CageReading& reading) {
  const std::vector<std::vector<int>>& faces = reading.cage.faces;
  const auto is_triangle = [](const std::vector<int>& face) { return face.size() == 3; };
  const std::size_t triangles = std::size_t(std::count_if(faces.begin(), faces.end(), is_triangle));
  if (2 * triangles <= faces.size()) return;
  reading.hints.push_back(std::to_string(triangles) + " of " + std::to_string(faces.size()) +
                          " faces are triangles; quads subdivide into a smoother surface: `airclay remesh` "
                          "makes a cage of quads");
}

/// Converts to metres and z up.
void transform(PolygonMesh& cage, double metres_per_unit, UpAxis up) {
  for (Vec3& point : cage.points) {
    point *= metres_per_unit;
    if (up == UpAxis::kY) point = Vec3(point.x(), -point.z(), point.y());
  }
}

void checkCoordinates(const MeshSource& source, const std::string& name, const NamedUnit& unit) {
  for (std::size_t p = 0; p < source.points.size(); ++p)
    if (!(source.points[p].cwiseAbs().maxCoeff() <= kMaxCoordinateM / unit.metres))
      throw Error(name + ": vertex " + std::to_string(p + 1) + " is more than 1,000 km from the origin, in " +
                  unit.name + "; the file is damaged or in another unit");
}

}  // namespace

std::optional<LengthUnit> lengthUnitNamed(std::string_view name) {
  for (const NamedUnit& unit : kUnits)
    if (name == unit.name) return unit.unit;
  return std::nullopt;
}

const std::vector<std::string>& cageExtensions() {
  static const std::vector<std::string> extensions = {".obj", ".ply", ".stl", ".gltf", ".glb"};
  return extensions;
}

bool isCageFile(const std::filesystem::path& file) {
  const std::vector<std::string>& known = cageExtensions();
  return std::find(known.begin(), known.end(), lowerCaseExtension(file)) != known.end();
}

std::vector<std::string> CageReading::notes() const {
  std::vector<std::string> notes = repairs;
  notes.insert(notes.end(), hints.begin(), hints.end());
  return notes;
}

CageReading inspectCage(const std::filesystem::path& file, const CageReadOptions& options) {
  if (!isCageFile(file)) failExtension(file);
  const std::string extension = lowerCaseExtension(file);
  const bool is_gltf = extension == ".gltf" || extension == ".glb";
  const NamedUnit& unit =
      named(options.units.value_or(extension == ".stl" ? LengthUnit::kMillimetre : LengthUnit::kMetre));
  MeshSource source = parse(file, extension);
  checkCoordinates(source, file.string(), unit);
  std::string format = source.format;
  CageReading reading = repairCage(std::move(source));
  reading.format = std::move(format);
  Eigen::AlignedBox3d box;
  for (const Vec3& point : reading.cage.points) box.extend(point);
  hintAtSize(box.sizes().maxCoeff(), unit, options, reading);
  if (!options.is_surface) hintAtTriangles(reading);
  transform(reading.cage, unit.metres, options.up.value_or(is_gltf ? UpAxis::kY : UpAxis::kZ));
  return reading;
}

CageReading readCage(const std::filesystem::path& file, const CageReadOptions& options) {
  CageReading reading = inspectCage(file, options);
  if (options.is_surface) {
    reading.repairs.insert(reading.repairs.end(), reading.problems.begin(), reading.problems.end());
    return reading;
  }
  std::string problems;
  for (const std::string& problem : reading.problems) problems += (problems.empty() ? "" : "; ") + problem;
  if (!problems.empty()) throw Error(file.string() + ": " + problems);
  checkCage(reading.cage, file.string());
  return reading;
}

}  // namespace airclay
