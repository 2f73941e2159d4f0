// SPDX-License-Identifier: MIT
#include "app/cli/cage_options.h"

#include <CLI/CLI.hpp>

#include "app/cli/command.h"
#include "engine/core/error.h"

namespace airclay {

CageReadOptions CageOptions::reading() const {
  CageReadOptions options;
  options.units = lengthUnitNamed(units);
  if (!up.empty()) options.up = up == "y" ? UpAxis::kY : UpAxis::kZ;
  options.units_option = units_option;
  options.is_surface = is_surface;
  return options;
}

void addCageOptions(CLI::App& command, CageOptions& options) {
  command
      .add_option(options.units_option, options.units, "unit of a cage's file: m, cm, mm or in [m; STL: mm]")
      ->check(CLI::IsMember({"m", "cm", "mm", "in"}).description(""))
      ->type_name("UNIT");
  command.add_option(options.up_option, options.up, "up axis of a cage's file: z or y [z; glTF: y]")
      ->check(CLI::IsMember({"z", "y"}).description(""))
      ->type_name("AXIS");
}

PolygonMesh CageOptions::load(const std::string& preset_or_file) const {
  CageReading reading = loadCage(preset_or_file, this->reading());
  for (const std::string& note : reading.notes()) printWarning(oneLine(preset_or_file + ": " + note));
  return std::move(reading.cage);
}

void CageOptions::refuse(const std::string& reason) const {
  if (units.empty() && up.empty()) return;
  throw Error((units.empty() ? up_option : units_option) + " applies to a cage's file; " + reason,
              Fault::kUsage);
}

}  // namespace airclay
