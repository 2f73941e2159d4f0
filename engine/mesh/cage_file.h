// SPDX-License-Identifier: MIT
// Control cages in the files that people have: OBJ, PLY, STL and glTF, repaired where the meaning is certain.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/mesh/mesh.h"

namespace airclay {

enum class LengthUnit { kMetre, kCentimetre, kMillimetre, kInch };
enum class UpAxis { kZ, kY };

/// m, cm, mm or in; empty for any other text.
std::optional<LengthUnit> lengthUnitNamed(std::string_view name);

struct CageReadOptions {
  /// Of the file's numbers. Empty: metres; for STL millimetres, which slicers assume.
  std::optional<LengthUnit> units;
  /// Empty: z; for glTF y, which its specification demands.
  std::optional<UpAxis> up;
  /// What a hint about the size names before the unit.
  std::string units_option = "--units";
};

/// The extensions that readCage() reads, in lower case: .obj .ply .stl .gltf .glb.
const std::vector<std::string>& cageExtensions();
/// Whether the file has one of these extensions, in any case.
bool isCageFile(const std::filesystem::path& file);

/// A cage, and what was found and repaired on the way.
struct CageReading {
  PolygonMesh cage;                   ///< metres, z up; an orientable 2-manifold unless there are problems
  std::string format;                 ///< for people: "PLY, binary little endian"
  std::vector<std::string> repairs;   ///< one line per kind of repair, with its count
  std::vector<std::string> hints;     ///< what is read, but is probably not meant
  std::vector<std::string> problems;  ///< why the file is not a cage; each names up to ten places
  bool is_closed = false;             ///< no edge has one face only

  /// Repairs, then hints.
  std::vector<std::string> notes() const;
};

/// Reads and repairs a cage:
/// - loose vertices and edges are dropped;
/// - vertices within 1e-6 of the size of the bounding box are welded;
/// - a corner that follows itself in a face is removed;
/// - faces are turned over so that neighbours agree; closed parts face outwards by their signed volume, open
///   parts as most of their faces do.
/// Problems: edges of more than two faces, vertices where fans of faces touch, duplicate faces, faces without
/// area, one-sided surfaces.
/// \throw Error naming the line or byte if the file cannot be parsed
CageReading inspectCage(const std::filesystem::path& file, const CageReadOptions& options = {});

/// The same. \throw Error also for problems
CageReading readCage(const std::filesystem::path& file, const CageReadOptions& options = {});

}  // namespace airclay
