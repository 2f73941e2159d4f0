// SPDX-License-Identifier: MIT
#include "app/studio/keys.h"

#include <imgui/imgui.h>

#include <algorithm>

#include "app/studio/look.h"

namespace airclay {

void obeyKeys(const std::vector<KeyGroup>& groups) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return;
  for (const KeyGroup& group : groups)
    for (const KeyBinding& binding : group.bindings)
      if (binding.act && io.KeyCtrl == binding.ctrl && io.KeyShift == binding.shift &&
          ImGui::IsKeyPressed(binding.key, binding.repeats))
        binding.act();
}

bool drawHelp(const std::vector<KeyGroup>& groups) {
  bool open = true;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowFocus();
  ImGui::Begin(
      "##help", &open,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushFont(titleFont());
  ImGui::TextUnformatted("Keys and mouse");
  ImGui::PopFont();
  ImGui::Spacing();
  const float key_width = 8.5f * ImGui::GetFontSize(), column = 27 * ImGui::GetFontSize();
  const float left = ImGui::GetCursorPosX(), top = ImGui::GetCursorPosY();
  float bottoms[2] = {top, top};
  for (const KeyGroup& group : groups) {
    const std::size_t side = bottoms[1] < bottoms[0];  // the shorter column
    const float x = left + static_cast<float>(side) * column;
    ImGui::SetCursorPos(ImVec2(x, bottoms[side]));
    ImGui::TextDisabled("%s", group.title.c_str());
    for (const KeyBinding& binding : group.bindings) {
      ImGui::SetCursorPosX(x);
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(look::kClay), "%s", binding.shown.c_str());
      ImGui::SameLine(x + key_width);
      ImGui::TextUnformatted(binding.does.c_str());
    }
    bottoms[side] = ImGui::GetCursorPosY() + ImGui::GetFontSize() / 2;
  }
  ImGui::SetCursorPos(ImVec2(left, std::max(bottoms[0], bottoms[1])));
  ImGui::Separator();
  ImGui::TextDisabled("Esc or F1 closes this");
  const bool clicked_away = ImGui::IsMouseClicked(0) && !ImGui::IsWindowHovered();
  ImGui::End();
  return open && !clicked_away && !ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
}

}  // namespace airclay
