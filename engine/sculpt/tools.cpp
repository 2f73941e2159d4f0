// SPDX-License-Identifier: MIT
#include "engine/sculpt/tools.h"

#include <algorithm>
#include <charconv>

#include "engine/core/error.h"
#include "engine/sculpt/contact.h"
#include "engine/sculpt/grip.h"
#include "engine/sculpt/relax.h"

namespace airclay {
namespace {

/// To add a tool, add it here.
constexpr const Tool* kTools[] = {&kPushTool, &kPullTool, &kSmoothTool};

/// The shortest text that reads back as the same number.
std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// "a, b or c" of all tools.
template <class Text>
std::string listOf(Text text) {
  std::string list;
  for (std::size_t i = 0; i < std::size(kTools); ++i)
    list += (i == 0 ? "" : i + 1 < std::size(kTools) ? ", " : " or ") + text(*kTools[i]);
  return list;
}

std::string rangeOf(const ToolSetting& setting) {
  return std::string(setting.id) + " from " + shortest(setting.minimum) + " to " + shortest(setting.maximum) +
         (*setting.unit ? std::string(" ") + setting.unit : "");
}

std::string settingsOf(const Tool& tool) {
  std::string list;
  for (const ToolSetting& setting : tool.settings) list += (list.empty() ? "" : ", ") + rangeOf(setting);
  return list.empty() ? std::string(tool.id) + " has no settings" : std::string(tool.id) + " has " + list;
}

/// `reach=12`
void readSetting(ToolChoice& choice, std::string_view text) {
  const std::span<const ToolSetting> settings = choice.tool().settings;
  const std::size_t equals = text.find('=');
  const auto setting = std::ranges::find(settings, text.substr(0, equals), &ToolSetting::id);
  if (equals == text.npos || setting == settings.end())
    throw Error("the tool setting '" + std::string(text) + "' is unknown; " + settingsOf(choice.tool()));
  const std::string_view number = text.substr(equals + 1);
  double value = 0;
  const auto [end, error] = std::from_chars(number.begin(), number.end(), value);
  if (error != std::errc() || end != number.end() ||
      !(value >= setting->minimum && value <= setting->maximum))
    throw Error("the tool setting '" + std::string(text) + "' is out of range; use " + rangeOf(*setting));
  choice.setValue(static_cast<std::size_t>(setting - settings.begin()), value);
}

}  // namespace

ToolChoice::ToolChoice() : ToolChoice(*kTools[0]) {}

ToolChoice::ToolChoice(const Tool& tool) : tool_(&tool) {
  for (const ToolSetting& setting : tool.settings) values_.push_back(setting.initial);
}

void ToolChoice::setValue(std::size_t setting, double value) {
  values_.at(setting) = std::clamp(value, tool_->settings[setting].minimum, tool_->settings[setting].maximum);
}

std::span<const Tool* const> tools() {
  return kTools;
}

const Tool* findTool(std::string_view id) {
  const auto found =
      std::ranges::find(kTools, id, [](const Tool* tool) { return std::string_view(tool->id); });
  return found == std::end(kTools) ? nullptr : *found;
}

std::string toolIds() {
  return listOf([](const Tool& tool) { return std::string(tool.id); });
}

std::string toolUsage() {
  return listOf([](const Tool& tool) {
    std::string text = tool.id;
    for (const ToolSetting& setting : tool.settings)
      text += (&setting == tool.settings.data() ? ":" : ",") + std::string(setting.id) + "=" +
              shortest(setting.minimum) + ".." + shortest(setting.maximum);
    return text;
  });
}

std::string formatTool(const ToolChoice& choice) {
  std::string text = choice.tool().id;
  char separator = ':';
  for (std::size_t i = 0; i < choice.values().size(); ++i) {
    const ToolSetting& setting = choice.tool().settings[i];
    if (choice.values()[i] == setting.initial) continue;
    text += separator + std::string(setting.id) + '=' + shortest(choice.values()[i]);
    separator = ',';
  }
  return text;
}

ToolChoice parseTool(std::string_view text) {
  const std::size_t colon = text.find(':');
  const Tool* tool = findTool(text.substr(0, colon));
  if (!tool)
    throw Error("the tool '" + std::string(text.substr(0, colon)) + "' is unknown; use " + toolIds());
  ToolChoice choice(*tool);
  if (colon == text.npos) return choice;
  for (std::string_view rest = text.substr(colon + 1);;) {
    const std::size_t comma = rest.find(',');
    readSetting(choice, rest.substr(0, comma));
    if (comma == rest.npos) return choice;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace airclay
