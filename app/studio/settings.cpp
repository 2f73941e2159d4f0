// SPDX-License-Identifier: MIT
#include "app/studio/settings.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "app/cli/command.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

/// The XDG base directory specification: an absolute path in the variable, or the default under HOME.
std::filesystem::path baseFolder(const char* variable, const char* fallback) {
  const char* value = std::getenv(variable);
  if (value && value[0] == '/') return std::filesystem::path(value) / "airclay";
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home && *home ? home : ".") / fallback / "airclay";
}

std::filesystem::path settingsFile() {
  return configFolder() / "studio.toml";
}

constexpr std::uintmax_t kMostBytes = 1 << 16;

struct Switch {
  const char* key;
  bool& value;
};
std::vector<Switch> switchesOf(StudioSettings& settings) {
  return {{"symmetry_x", settings.symmetry.x},       {"symmetry_y", settings.symmetry.y},
          {"symmetry_z", settings.symmetry.z},       {"steady_hand", settings.filtered},
          {"show_panels", settings.show_panels},     {"show_voxels", settings.show_voxels},
          {"show_cage", settings.show_cage},         {"show_points", settings.show_points},
          {"show_skeleton", settings.show_skeleton}, {"show_cameras", settings.show_cameras},
          {"show_graph", settings.show_graph},       {"first_run", settings.first_run}};
}

/// `tool`: an id, or in files of version 0.1 an index; `tools`: formatTool()'s texts. Unknown ones are
/// skipped.
void readTools(const toml::table& table, StudioSettings& settings) {
  if (const toml::array* texts = table["tools"].as_array())
    for (const toml::node& text : *texts) try {
        const ToolChoice saved = parseTool(text.value_or(std::string()));
        for (ToolChoice& choice : settings.tools)
          if (choice.is(saved.tool())) choice = saved;
      } catch (const Error&) {
      }
  const auto index = table["tool"].value<std::int64_t>();
  const std::string id = table["tool"].value_or(std::string());
  for (std::size_t i = 0; i < settings.tools.size(); ++i)
    if (id == settings.tools[i].tool().id || index == std::int64_t(i)) settings.tool = i;
}

}  // namespace

std::vector<ToolChoice> defaultTools() {
  std::vector<ToolChoice> choices;
  for (const Tool* tool : tools()) choices.emplace_back(*tool);
  return choices;
}

std::filesystem::path configFolder() {
  return baseFolder("XDG_CONFIG_HOME", ".config");
}
std::filesystem::path stateFolder() {
  return baseFolder("XDG_STATE_HOME", ".local/state");
}

StudioSettings loadSettings() {
  StudioSettings settings;
  const std::filesystem::path file = settingsFile();
  std::error_code fault;
  if (!std::filesystem::exists(file, fault)) return settings;
  try {
    const std::string text = readWhole(file, kMostBytes);
    const toml::table table = toml::parse(text, file.string());
    const auto number = [&](const char* key, int low, int high, int& value) {
      value = static_cast<int>(std::clamp<std::int64_t>(table[key].value_or<std::int64_t>(value), low, high));
    };
    number("window_width", 640, 16'384, settings.window_width);
    number("window_height", 400, 16'384, settings.window_height);
    number("clutch_key", 32, 348, settings.clutch_key);
    int clutch = 0;
    readTools(table, settings);
    number("clutch", 0, 1, clutch);
    settings.clutch = static_cast<Clutch>(clutch);
    settings.folder = table["folder"].value_or(std::string());
    for (const Switch& one : switchesOf(settings)) one.value = table[one.key].value_or(one.value);
  } catch (const toml::parse_error& error) {
    printWarning(file.string() + ", line " + std::to_string(error.source().begin.line) + ": " +
                 std::string(error.description()) + "; the studio starts with its defaults");
  } catch (const Error& error) {
    printWarning(error.what());
  }
  return settings;
}

void saveSettings(const StudioSettings& settings) {
  StudioSettings copy = settings;
  toml::table table{
      {"window_width", settings.window_width},       {"window_height", settings.window_height},
      {"clutch_key", settings.clutch_key},           {"tool", settings.tools[settings.tool].tool().id},
      {"clutch", static_cast<int>(settings.clutch)}, {"folder", settings.folder.string()}};
  for (const Switch& one : switchesOf(copy)) table.insert(one.key, one.value);
  toml::array tools;
  for (const ToolChoice& choice : settings.tools) tools.push_back(formatTool(choice));
  table.insert("tools", std::move(tools));
  std::ostringstream text;
  text << table << "\n";
  try {
    std::filesystem::create_directories(configFolder());
    writeWhole(settingsFile(), text.str());
  } catch (const std::exception& error) {
    printWarning(std::string("cannot save the studio's settings: ") + error.what());
  }
}

}  // namespace airclay
