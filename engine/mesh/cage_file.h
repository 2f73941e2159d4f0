// SPDX-License-Identifier: MIT
// Reads control cages from OBJ, PLY, STL and glTF files, with unambiguous repairs.
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

/// Parses m, cm, mm or in; empty for any other text.
std::optional<LengthUnit> lengthUnitNamed(std::string_view name);

struct CageReadOptions {
  /// The unit of the file's coordinates. Empty: metres; for STL millimetres, as in slicers.
  std::optional<LengthUnit> units;
  /// Empty: z; for glTF y, as its specification requires.
  std::optional<UpAxis> up;
  /// The file is not used as a cage: no hint recommends quads, and readCage() reports problems as notes.
  bool is_surface = false;
  /// The option that hints about the size recommend.
  std::string units_option = "--units";
};

/// The extensions that readCage() reads, in lower case: .obj .ply .stl .gltf .glb.
const std::vector<std::string>& cageExtensions();
/// Whether the file has one of these extensions, in any case.
bool isCageFile(const std::filesystem::path& file);

/// A cage, with its repairs and problems.
struct CageReading {
  PolygonMesh cage;                   ///< metres, z up; an orientable 2-manifold unless there are problems
  std::string format;                 ///< for display: "PLY, binary little endian"
  std::vector<std::string> repairs;   ///< one line per kind of repair, with its count
  std::vector<std::string> hints;     ///< valid, but probably not intended
  std::vector<std::string> problems;  ///< why the file is not a cage; each names up to ten places
  bool is_closed = false;             ///< every edge has two faces

  /// Repairs, then hints.
  std::vector<std::string> notes() const;
};

/// Reads and repairs a cage:
/// - loose vertices and edges are dropped;
/// - vertices within 1e-6 of the size of the bounding box are welded;
/// - corners that repeat the previous one are removed;
/// - faces are flipped so that neighbours agree; closed parts face outwards by their signed volume, open
///   parts as most of their faces do.
/// Problems: edges of more than two faces, vertices where fans of faces touch, duplicate faces, faces without
/// area, non-orientable surfaces.
/// \throw Error naming the line or byte if the file cannot be parsed
CageReading inspectCage(const std::filesystem::path& file, const CageReadOptions& options = {});

/// Like inspectCage(). \throw Error also for problems, unless options.is_surface
CageReading readCage(const std::filesystem::path& file, const CageReadOptions& options = {});

}  // namespace airclay
