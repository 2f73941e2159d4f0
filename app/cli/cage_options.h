// SPDX-License-Identifier: MIT
// The options of the commands that read a control cage from a file.
#pragma once

#include <string>

#include "engine/clay/presets.h"

namespace CLI {
class App;
}

namespace airclay {

/// Unit and up axis of a cage's file, as given.
struct CageOptions {
  std::string units, up;                 ///< empty: the format's own
  std::string units_option = "--units";  ///< the options' names
  std::string up_option = "--up";
  bool is_surface = false;  ///< as CageReadOptions::is_surface

  CageReadOptions reading() const;
  /// The cage of a preset or a file; prints what was repaired, and hints, as warnings.
  PolygonMesh load(const std::string& preset_or_file) const;
  /// \throw Error (Fault::kUsage) that ends in `reason` if an option is given, for clay that is not a cage's
  /// file
  void refuse(const std::string& reason) const;
};

/// --units and --up. Before, `options` may give them other names.
void addCageOptions(CLI::App& command, CageOptions& options);

}  // namespace airclay
