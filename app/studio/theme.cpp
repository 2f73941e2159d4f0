// SPDX-License-Identifier: MIT
#include "app/studio/theme.h"

#include <imgui/imgui.h>

// The Inter font, embedded by font.S
extern "C" {
extern unsigned char airclay_font[];
extern const unsigned char airclay_font_end[];
}

namespace airclay {
namespace {

constexpr float kTextPoints = 16, kTitlePoints = 24;
ImFont* title_font = nullptr;

ImVec4 screen(int red, int green, int blue, double opacity = 1) {
  return ImVec4(float(red) / 255, float(green) / 255, float(blue) / 255, float(opacity));
}

}  // namespace

void applyTheme(double scale) {
  ImGuiIO& io = ImGui::GetIO();
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  const int bytes = static_cast<int>(airclay_font_end - airclay_font);
  const auto points = [&](float size) { return size * static_cast<float>(scale); };
  io.Fonts->AddFontFromMemoryTTF(airclay_font, bytes, points(kTextPoints), &config);
  title_font = io.Fonts->AddFontFromMemoryTTF(airclay_font, bytes, points(kTitlePoints), &config);

  ImGui::StyleColorsLight();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 8;
  style.ChildRounding = style.PopupRounding = 6;
  style.FrameRounding = style.GrabRounding = 5;
  style.WindowBorderSize = 0;
  style.FrameBorderSize = 0;
  style.WindowPadding = ImVec2(14, 12);
  style.FramePadding = ImVec2(10, 5);
  style.ItemSpacing = ImVec2(8, 7);
  style.ScrollbarSize = 12;
  style.WindowTitleAlign = ImVec2(0, 0.5f);
  ImVec4* colors = style.Colors;
  const ImVec4 ink = screen(56, 50, 46), paper = screen(250, 248, 245, 0.94), clay = screen(180, 107, 63),
               shade = screen(120, 105, 95, 0.13), pressed = screen(180, 107, 63, 0.30);
  colors[ImGuiCol_Text] = ink;
  colors[ImGuiCol_TextDisabled] = screen(142, 132, 124);
  colors[ImGuiCol_WindowBg] = colors[ImGuiCol_PopupBg] = paper;
  colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = colors[ImGuiCol_TitleBgCollapsed] =
      screen(240, 236, 231, 0.96);
  colors[ImGuiCol_FrameBg] = colors[ImGuiCol_Button] = colors[ImGuiCol_Header] = shade;
  colors[ImGuiCol_FrameBgHovered] = colors[ImGuiCol_ButtonHovered] = colors[ImGuiCol_HeaderHovered] =
      screen(180, 107, 63, 0.18);
  colors[ImGuiCol_FrameBgActive] = colors[ImGuiCol_ButtonActive] = colors[ImGuiCol_HeaderActive] = pressed;
  colors[ImGuiCol_CheckMark] = colors[ImGuiCol_SliderGrab] = colors[ImGuiCol_SliderGrabActive] = clay;
  colors[ImGuiCol_PlotLines] = colors[ImGuiCol_PlotHistogram] = clay;
  colors[ImGuiCol_Separator] = screen(120, 105, 95, 0.22);
  colors[ImGuiCol_ScrollbarBg] = ImVec4(0, 0, 0, 0);
  style.ScaleAllSizes(static_cast<float>(scale));
}

ImFont* titleFont() {
  return title_font;
}

}  // namespace airclay
