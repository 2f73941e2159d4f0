// SPDX-License-Identifier: MIT
#include "app/studio/keys.h"

#include <imgui/imgui.h>

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
  if (ImGui::BeginTable("groups", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const KeyGroup& group : groups) {
      ImGui::TableNextColumn();
      ImGui::TextDisabled("%s", group.title.c_str());
      if (ImGui::BeginTable(group.title.c_str(), 2, ImGuiTableFlags_SizingFixedFit)) {
        for (const KeyBinding& binding : group.bindings) {
          ImGui::TableNextRow();
          ImGui::TableNextColumn();
          ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(look::kClay), "%s", binding.shown.c_str());
          ImGui::TableNextColumn();
          ImGui::TextUnformatted((binding.does + "    ").c_str());
        }
        ImGui::EndTable();
      }
      ImGui::Spacing();
    }
    ImGui::EndTable();
  }
  ImGui::Separator();
  ImGui::TextDisabled("Esc or F1 closes this");
  const bool clicked_away = ImGui::IsMouseClicked(0) && !ImGui::IsWindowHovered();
  ImGui::End();
  return open && !clicked_away && !ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
}

}  // namespace airclay
