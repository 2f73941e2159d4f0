// SPDX-License-Identifier: MIT
// Line icons.
#pragma once

struct ImDrawList;
struct ImVec2;

namespace airclay {

/// Strokes an icon in SVG path syntax (M, L and C, absolute coordinates, 24 x 24) into a square. `corner`:
/// upper left, `size`: edge, `thickness`: of the strokes, all in pixels; `color`: Dear ImGui's packed color.
/// Stops at the first command that it does not know.
void drawIcon(ImDrawList& list, const char* path, const ImVec2& corner, float size, float thickness,
              unsigned color);

}  // namespace airclay
