// SPDX-License-Identifier: MIT
// The registry of tools.
#pragma once

#include <string_view>

#include "engine/sculpt/tool.h"

namespace airclay {

/// All tools, in the order of the panels and number keys; the first is the default.
std::span<const Tool* const> tools();
/// nullptr if there is no such tool.
const Tool* findTool(std::string_view id);
/// "push, pull or smooth"
std::string toolIds();

/// "push, pull:reach=2..40 or smooth:reach=2..40,strength=0.1..4": every tool with its settings' ranges.
std::string toolUsage();

/// A tool with the settings that differ from their initial values: `pull:reach=12`, `smooth`.
std::string formatTool(const ToolChoice& choice);
/// The inverse of formatTool(). \throw Error naming what is wrong and what is expected
ToolChoice parseTool(std::string_view text);

}  // namespace airclay
