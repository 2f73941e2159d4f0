// SPDX-License-Identifier: MIT
#include "app/studio/icon.h"

#include <imgui/imgui.h>
#include <sstream>

namespace airclay {

void drawIcon(ImDrawList& list, const char* path, const ImVec2& corner, float size, float thickness,
              unsigned color) {
  std::istringstream commands(path);
  const auto point = [&] {
    float x = 0, y = 0;
    commands >> x >> y;
    return ImVec2(corner.x + x * size / 24, corner.y + y * size / 24);
  };
  char command = 0;
  while (commands >> command) {
    if (command == 'M') {
      if (list._Path.Size > 0) list.PathStroke(color, 0, thickness);
      list.PathLineTo(point());
    } else if (command == 'L') {
      list.PathLineTo(point());
    } else if (command == 'C') {
      const ImVec2 a = point(), b = point(), end = point();
      list.PathBezierCubicCurveTo(a, b, end);
    } else {
      break;
    }
  }
  list.PathStroke(color, 0, thickness);
}

}  // namespace airclay
