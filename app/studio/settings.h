// SPDX-License-Identifier: MIT
// The studio's settings, stored in XDG_CONFIG_HOME/airclay/studio.toml.
#pragma once

#include <filesystem>

#include "app/session/session.h"

namespace airclay {

/// Every registered tool with its initial settings.
std::vector<ToolChoice> defaultTools();

struct StudioSettings {
  int window_width = 1280, window_height = 800;    ///< screen units
  std::vector<ToolChoice> tools = defaultTools();  ///< every tool, with its settings
  std::size_t tool = 0;                            ///< the current one of `tools`
  Symmetry symmetry;
  Clutch clutch = Clutch::kContact;
  bool filtered = true;
  bool show_panels = true, show_voxels = false, show_cage = false, show_points = false, show_skeleton = false,
       show_cameras = false, show_graph = true;
  int clutch_key = 32;           ///< GLFW code: Space; a foot pedal sends a key
  std::filesystem::path folder;  ///< folder of the last document or export
  bool first_run = true;
  bool operator==(const StudioSettings&) const = default;
};

/// XDG_CONFIG_HOME/airclay and XDG_STATE_HOME/airclay, with the specification's defaults under HOME.
std::filesystem::path configFolder();
std::filesystem::path stateFolder();

/// Prints a warning and uses the defaults for anything that cannot be read.
StudioSettings loadSettings();
/// Prints a warning on failure; never throws.
void saveSettings(const StudioSettings& settings);

}  // namespace airclay
