// SPDX-License-Identifier: MIT
// The presets' control cages: quads, counterclockwise seen from outside, about 0.2 m in size.
#include "engine/clay/presets.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "engine/core/error.h"

namespace airclay {
namespace {

/// One ring of a surface of revolution.
struct Ring {
  double radius_m, height_m;
};

/// A surface of revolution about z: consecutive rings of `around` points, connected by quads. Rings that
/// ascend form the outside.
PolygonMesh lathe(const std::vector<Ring>& rings, int around) {
  PolygonMesh mesh;
  for (const Ring& ring : rings)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.points.emplace_back(ring.radius_m * std::cos(angle), ring.radius_m * std::sin(angle),
                               ring.height_m);
    }
  for (int r = 0; r + 1 < int(rings.size()); ++r)
    for (int i = 0; i < around; ++i) {
      const int low = r * around, high = low + around, next = (i + 1) % around;
      mesh.faces.push_back({low + i, low + next, high + next, high + i});
    }
  return mesh;
}

/// Closes the ring that starts at point `first` with a fan of quads around a new centre point. \pre `around`
/// is even
void closeRing(PolygonMesh& mesh, int first, int around, bool ring_runs_outwards) {
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < around; ++i) middle += mesh.points[size_t(first + i)] / around;
  const int centre = int(mesh.points.size());
  mesh.points.push_back(middle);
  for (int i = 0; i < around; i += 2) {
    const int a = first + i, b = first + i + 1, c = first + (i + 2) % around;
    if (ring_runs_outwards)
      mesh.faces.push_back({centre, a, b, c});
    else
      mesh.faces.push_back({centre, c, b, a});
  }
}

/// The surface of the box [-1, 1]³ as a grid of quads, `cells` along each axis; corners are shared.
PolygonMesh boxGrid(const std::array<int, 3>& cells) {
  PolygonMesh mesh;
  std::map<std::array<int, 3>, int> point_at;
  const auto point = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = point_at.try_emplace(at, int(mesh.points.size()));
    if (is_new)
      mesh.points.emplace_back(2.0 * at[0] / cells[0] - 1, 2.0 * at[1] / cells[1] - 1,
                               2.0 * at[2] / cells[2] - 1);
    return found->second;
  };
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;  // u x v points along the axis
    for (const bool high : {false, true})
      for (int i = 0; i < cells[u]; ++i)
        for (int j = 0; j < cells[v]; ++j) {
          const auto corner = [&](int du, int dv) {
            std::array<int, 3> at{};
            at[axis] = high ? cells[axis] : 0;
            at[u] = i + du;
            at[v] = j + dv;
            return point(at);
          };
          if (high)
            mesh.faces.push_back({corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
          else
            mesh.faces.push_back({corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)});
        }
  }
  return mesh;
}

PolygonMesh scaled(PolygonMesh mesh, const Vec3& half_size_m) {
  for (Vec3& point : mesh.points) point = point.cwiseProduct(half_size_m);
  return mesh;
}

PolygonMesh tube() {
  constexpr double radius_m = 0.08;
  return lathe({{radius_m, -0.1}, {radius_m, -0.1 / 3}, {radius_m, 0.1 / 3}, {radius_m, 0.1}}, 7);
}

PolygonMesh cube() {
  return scaled(boxGrid({1, 1, 1}), Vec3::Constant(0.1));
}

PolygonMesh ball() {
  constexpr double radius_m = 0.108;  // the surface is 7 % smaller: a ball 0.2 m in diameter
  PolygonMesh mesh = boxGrid({3, 3, 3});
  for (Vec3& point : mesh.points) {
    // Equal angles, not equal lengths, along the cube's edges give quads of similar size on the sphere.
    point = (point.array() * (std::numbers::pi / 4)).tan().matrix().normalized() * radius_m;
  }
  return mesh;
}

PolygonMesh slab() {
  return scaled(boxGrid({5, 5, 1}), {0.1, 0.1, 0.02});
}

/// A hollow vase with walls about 2 cm thick: up the outside, over the lip, down the inside.
PolygonMesh vase() {
  constexpr int around = 8;
  const std::vector<Ring> profile = {{0.045, -0.100}, {0.070, -0.070}, {0.082, -0.030}, {0.074, 0.015},
                                     {0.052, 0.050},  {0.050, 0.080},  {0.064, 0.100},  // lip
                                     {0.044, 0.096},  {0.031, 0.076},  {0.033, 0.050},  {0.053, 0.010},
                                     {0.060, -0.030}, {0.046, -0.066}};
  PolygonMesh mesh = lathe(profile, around);
  closeRing(mesh, 0, around, false);
  closeRing(mesh, int(profile.size() - 1) * around, around, true);
  return mesh;
}

}  // namespace

const std::vector<std::string>& presetNames() {
  static const std::vector<std::string> names = {"tube", "cube", "ball", "slab", "vase"};
  return names;
}

PolygonMesh presetCage(const std::string& name) {
  if (name == "tube") return tube();
  if (name == "cube") return cube();
  if (name == "ball") return ball();
  if (name == "slab") return slab();
  if (name == "vase") return vase();
  std::string list;
  for (const std::string& preset : presetNames()) list += (list.empty() ? "" : ", ") + preset;
  throw Error("there is no clay preset '" + name + "'; expected one of " + list);
}

CageReading loadCage(const std::string& preset_or_file, const CageReadOptions& options) {
  const std::vector<std::string>& names = presetNames();
  const bool is_preset = std::find(names.begin(), names.end(), preset_or_file) != names.end();
  const bool is_path =
      std::filesystem::exists(preset_or_file) || preset_or_file.find_first_of("./") != std::string::npos;
  if (!is_preset && is_path) return readCage(preset_or_file, options);
  CageReading reading;
  reading.cage = presetCage(preset_or_file);  // a mistyped preset: the error lists the presets
  reading.format = "preset";
  if (options.units || options.up)
    throw Error(preset_or_file + " is a preset, in metres and z up; units and an up axis apply to files",
                Fault::kUsage);
  return reading;
}

}  // namespace airclay
