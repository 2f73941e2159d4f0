// SPDX-License-Identifier: MIT
#include "app/studio/shortcuts.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include <algorithm>
#include <cctype>

#include "app/studio/theme.h"

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

std::string keyName(int key) {
  constexpr struct {
    int key;
    const char* name;
  } kNames[] = {{GLFW_KEY_SPACE, "Space"},
                {GLFW_KEY_ENTER, "Enter"},
                {GLFW_KEY_BACKSPACE, "Backspace"},
                {GLFW_KEY_INSERT, "Insert"},
                {GLFW_KEY_DELETE, "Delete"},
                {GLFW_KEY_PAGE_UP, "Page Up"},
                {GLFW_KEY_PAGE_DOWN, "Page Down"},
                {GLFW_KEY_END, "End"},
                {GLFW_KEY_CAPS_LOCK, "Caps Lock"},
                {GLFW_KEY_SCROLL_LOCK, "Scroll Lock"},
                {GLFW_KEY_NUM_LOCK, "Num Lock"},
                {GLFW_KEY_PRINT_SCREEN, "Print"},
                {GLFW_KEY_PAUSE, "Pause"},
                {GLFW_KEY_KP_ENTER, "Enter on the keypad"},
                {GLFW_KEY_LEFT_SHIFT, "Left Shift"},
                {GLFW_KEY_RIGHT_SHIFT, "Right Shift"},
                {GLFW_KEY_LEFT_ALT, "Left Alt"},
                {GLFW_KEY_RIGHT_ALT, "Right Alt"},
                {GLFW_KEY_MENU, "Menu"}};
  for (const auto& [code, name] : kNames)
    if (code == key) return name;
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F25) return "F" + std::to_string(key - GLFW_KEY_F1 + 1);
  if (const char* name = glfwGetKeyName(key, 0)) {
    std::string upper = name;
    if (upper.size() == 1) upper[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(upper[0])));
    return key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_EQUAL ? upper + " on the keypad" : upper;
  }
  return "key " + std::to_string(key);
}

int keyPressed() {
  for (int key = GLFW_KEY_SPACE; key <= GLFW_KEY_LAST; ++key)
    if (ImGui::IsKeyPressed(key, false)) return key;
  return 0;
}

std::optional<std::string> meaningOf(const std::vector<KeyGroup>& groups, int key) {
  if (key == GLFW_KEY_ESCAPE) return "Close or cancel";
  for (const int modifier :
       {GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT})
    if (key == modifier) return "Modifier key";
  for (const KeyGroup& group : groups)
    for (const KeyBinding& binding : group.bindings) {
      const bool pressed = binding.act && binding.key == key && !binding.ctrl && !binding.shift;
      const bool held = std::find(binding.held.begin(), binding.held.end(), key) != binding.held.end();
      if (pressed || held) return binding.does;
    }
  return std::nullopt;
}

bool drawHelp(const std::vector<KeyGroup>& groups) {
  bool open = true;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowFocus();
  ImGui::SetNextWindowBgAlpha(1);  // or the panels' text would show through
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
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(theme::kClay), "%s", binding.shown.c_str());
      ImGui::SameLine(x + key_width);
      ImGui::TextUnformatted(binding.does.c_str());
    }
    bottoms[side] = ImGui::GetCursorPosY() + ImGui::GetFontSize() / 2;
  }
  ImGui::SetCursorPos(ImVec2(left, std::max(bottoms[0], bottoms[1])));
  ImGui::Separator();
  ImGui::TextDisabled("Esc or F1: close");
  const bool clicked_away = ImGui::IsMouseClicked(0) && !ImGui::IsWindowHovered();
  ImGui::End();
  return open && !clicked_away && !ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
}

}  // namespace airclay
