// SPDX-License-Identifier: MIT
#include "app/studio/calibration_window.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include <algorithm>
#include <cctype>

#include "app/cli/command.h"
#include "app/studio/camera_window.h"
#include "app/studio/theme.h"

namespace airclay {
namespace {

constexpr double kQuietS = 0.2;  // between images without a new set
// In units of the font size.
constexpr float kPanelWidth = 22;
constexpr ImU32 kVeil = IM_COL32(250, 248, 245, 105);

ImVec2 at(const ImagePlacement& place, const Vec2& pixel) {
  return {static_cast<float>(place.left + (pixel.x() + 0.5) * place.scale),
          static_cast<float>(place.top + (pixel.y() + 0.5) * place.scale)};
}

class CalibrationWindow {
 public:
  CalibrationWindow(Gpu& gpu, LiveCameras& cameras, LiveCalibration::Options options)
      : shown_(gpu, "Airclay: calibrating"), calibration_(cameras, waking(std::move(options))) {}

  LiveCalibration::State run() {
    while (!shown_.window().closing()) {
      shown_.window().poll(kQuietS);
      state_ = calibration_.state();
      if (shown_.begin())
        draw();
      else
        shown_.window().poll(kQuietS);  // minimised
    }
    return calibration_.state();
  }

 private:
  /// Wakes the window when the state changes.
  static LiveCalibration::Options waking(LiveCalibration::Options options) {
    options.wake = [] { glfwPostEmptyEvent(); };
    return options;
  }

  void draw() {
    const auto width = static_cast<float>(shown_.window().width());
    const float panel = std::min(kPanelWidth * ImGui::GetFontSize(), 0.45f * width);
    std::vector<ImageSize> sizes;
    for (const CollectedCamera& camera : state_.cameras) sizes.push_back(camera.size);
    shown_.lay(sizes, state_.set ? state_.set->images : std::vector<LiveImage>(), panel);
    for (std::size_t c = 0; c < sizes.size(); ++c) drawOver(c);
    drawPanel(width - panel, panel, static_cast<float>(shown_.window().height()));
    shown_.show();
  }

  /// Draws over a camera's image: a veil over areas without board views, the detected corners, and a progress
  /// bar below.
  void drawOver(std::size_t index) {
    const CollectedCamera& camera = state_.cameras[index];
    const ImagePlacement& place = shown_.places()[index];
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float em = ImGui::GetFontSize();
    const auto left = float(place.left), top = float(place.top), bottom = float(place.bottom());
    const double cell = camera.coverage.cellPixels() * place.scale;
    for (int row = 0; row < camera.coverage.rows(); ++row)
      for (int column = 0; column < BoardCoverage::kColumns; ++column)
        if (!camera.coverage.covered(column, row))
          list.AddRectFilled(
              {float(left + column * cell), float(top + row * cell)},
              {float(left + (column + 1) * cell), std::min(bottom, float(top + (row + 1) * cell))}, kVeil);
    if (camera.seen)
      for (const Vec2& pixel : camera.seen->pixels) {
        list.AddCircleFilled(at(place, pixel), 0.26f * em, IM_COL32_WHITE);
        list.AddCircleFilled(at(place, pixel), 0.17f * em, theme::kClay);
      }
    const auto [text, color] = describeState(camera, state_.status[index]);
    shown_.drawLabel(index, {camera.name,
                             std::to_string(camera.views) + " views, " + std::to_string(camera.shared_views) +
                                 " shared, " + fixed(100 * camera.coverage.fraction(), 0) + " % covered",
                             text, color});
    list.AddRectFilled({left, bottom}, {left + float(camera.progress * place.width), bottom + 0.25f * em},
                       camera.progress >= 1 ? theme::kGood : theme::kClay);
  }

  static std::pair<std::string, ImU32> describeState(const CollectedCamera& camera,
                                                     const CameraStatus& status) {
    if (status.state != CameraState::kLive && status.state != CameraState::kEnded)
      return {std::string(nameOf(status.state)) + (status.fault.empty() ? "" : ": " + oneLine(status.fault)),
              theme::kBad};
    if (!camera.seen) return {"Board not visible", theme::kFaint};
    const std::string problem = camera.problem();
    const std::string blur = camera.light ? "blur " + fixed(camera.light->blur_px, 1) + " px, " +
                                                "white at " + fixed(camera.light->white, 0) + " of 255"
                                          : "";
    if (!problem.empty()) return {problem + ": " + blur, theme::kBad};
    return {"Sharp, well lit: " + blur, theme::kGood};
  }

  void drawPanel(float left, float width, float height) {
    ImGui::SetNextWindowPos({left, 0});
    ImGui::SetNextWindowSize({width, height});
    ImGui::Begin("##calibrating", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
    title("Calibrating");
    ImGui::ProgressBar(float(state_.share), {-1, 0.5f * ImGui::GetFontSize()}, "");
    ImGui::TextDisabled("%.0f %% of the views for a good calibration", 100 * state_.share);
    ImGui::Spacing();
    if (!state_.working && state_.result.empty() && !state_.advice.empty()) title(sentence(state_.advice));
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled(
        "%d board positions collected. Hold the board still in a new position to add one. Each image clears "
        "where the board has been.",
        state_.kept_sets);
    ImGui::PopTextWrapPos();
    ImGui::Separator();
    drawActions();
    drawResult();
    ImGui::End();
  }

  static std::string sentence(std::string text) {
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return text + ".";
  }

  static void title(const std::string& text) {
    ImGui::PushFont(titleFont());
    ImGui::TextWrapped("%s", text.c_str());
    ImGui::PopFont();
  }

  void drawActions() {
    const auto chosen = [](const char* label, int key, bool possible) {
      ImGui::BeginDisabled(!possible);
      const bool clicked = ImGui::Button(label, {-1, 0});
      ImGui::EndDisabled();
      return possible && (clicked || ImGui::IsKeyPressed(key, false));
    };
    const bool idle = !state_.working;
    ImGui::PushStyleColor(ImGuiCol_Button, state_.enough && idle ? ImVec4(0.71f, 0.42f, 0.25f, 0.55f)
                                                                 : ImGui::GetStyleColorVec4(ImGuiCol_Button));
    if (chosen("Calibrate   Enter", GLFW_KEY_ENTER, idle && state_.kept_sets > 0)) calibration_.finish();
    ImGui::PopStyleColor();
    if (chosen("Set world to the board   W", GLFW_KEY_W, idle)) calibration_.takeWorld();
    if (chosen("Start over   Backspace", GLFW_KEY_BACKSPACE, idle)) calibration_.restart();
    if (chosen("Close   Esc", GLFW_KEY_ESCAPE, true)) shown_.window().close();
    ImGui::PushTextWrapPos(0);
    if (state_.world)
      ImGui::TextDisabled("World: the board of set %d. The workspace stands on it.", *state_.world);
    else
      ImGui::TextDisabled("World: not set. Defaults to the board that all cameras see best.");
    ImGui::PopTextWrapPos();
  }

  void drawResult() {
    ImGui::Separator();
    if (state_.working) ImGui::ProgressBar(float(state_.work_share), {-1, 0.5f * ImGui::GetFontSize()}, "");
    if (!state_.fault.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, theme::kBad);
      ImGui::TextWrapped("%s", state_.fault.c_str());
      ImGui::PopStyleColor();
    }
    for (const std::string& line : state_.result) ImGui::TextWrapped("%s", line.c_str());
  }

  CameraWindow shown_;
  LiveCalibration calibration_;  ///< declared after the window, which its thread wakes
  LiveCalibration::State state_;
};

}  // namespace

LiveCalibration::State showCalibration(Gpu& gpu, LiveCameras& cameras,
                                       const LiveCalibration::Options& options) {
  return CalibrationWindow(gpu, cameras, options).run();
}

}  // namespace airclay
