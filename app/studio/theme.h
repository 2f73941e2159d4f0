// SPDX-License-Identifier: MIT
// The style of the studio's interface: fonts and colors.
#pragma once

#include <cstdint>

#include "shaders/core/io.h"

struct ImFont;

namespace airclay {

/// Sets Dear ImGui's style and fonts. `scale`: pixels per point.
void applyTheme(double scale);

/// The larger font for titles. \pre applyTheme()
ImFont* titleFont();

/// Colors in Dear ImGui's packed format.
namespace theme {
inline constexpr std::uint32_t kInk = 0xFF2E3238;    ///< text
inline constexpr std::uint32_t kFaint = 0xFF7C848E;  ///< less important text
inline constexpr std::uint32_t kClay = 0xFF3F6BB4;   ///< terracotta: selection
inline constexpr std::uint32_t kGood = 0xFF5A9A4A;   ///< tracking
inline constexpr std::uint32_t kDoubt = 0xFF2D9BE0;  ///< uncertain
inline constexpr std::uint32_t kBad = 0xFF3A3AD0;    ///< lost
/// Background of camera images, linear.
inline vec4 paper() {
  return vec4(0.72f, 0.69f, 0.65f, 1);
}
}  // namespace theme

}  // namespace airclay
