// SPDX-License-Identifier: MIT
#include "app/studio/calibration_window.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "app/command.h"
#include "app/studio/camera_grid.h"
#include "app/studio/look.h"
#include "engine/gpu/graphics.h"
#include "engine/gpu/recorder.h"

namespace airclay {
namespace {

constexpr double kQuietS = 0.2;  // between pictures when no set comes
// In letters' heights.
constexpr float kPanelWidth = 22;
constexpr ImU32 kVeil = IM_COL32(250, 248, 245, 105), kLabel = IM_COL32(250, 248, 245, 240);

ImVec2 at(const PicturePlace& place, const Vec2& pixel) {
  return {static_cast<float>(place.left + (pixel.x() + 0.5) * place.scale),
          static_cast<float>(place.top + (pixel.y() + 0.5) * place.scale)};
}

class CalibrationWindow {
 public:
  CalibrationWindow(Gpu& gpu, LiveCalibration& calibration)
      : gpu_(gpu),
        calibration_(calibration),
        window_(gpu, {.title = "Airclay: calibrating", .width = 1280, .height = 800}),
        recorder_(gpu),
        grid_(gpu) {}

  LiveCalibration::State run() {
    while (!window_.closing()) {
      window_.poll(kQuietS);
      state_ = calibration_.state();
      if (window_.begin(false) == Window::Begun::kNothing) {  // minimised
        window_.poll(kQuietS);
        continue;
      }
      draw();
    }
    return calibration_.state();
  }

 private:
  void draw() {
    const auto width = static_cast<std::uint32_t>(window_.width()),
               height = static_cast<std::uint32_t>(window_.height());
    if (paper_.width() != width || paper_.height() != height)
      paper_ = Image(gpu_, ImageKind::kScreen, width, height);
    const float em = ImGui::GetFontSize();
    const float panel = std::min(kPanelWidth * em, 0.45f * float(width));
    std::vector<PictureSize> sizes;
    for (const CollectedCamera& camera : state_.cameras) sizes.push_back(camera.size);
    grid_.place(sizes, double(width) - panel, height, em);
    grid_.draw(state_.set ? state_.set->pictures : std::vector<LivePicture>());
    for (std::size_t c = 0; c < sizes.size(); ++c)
      drawOver(state_.cameras[c], state_.status[c], grid_.places()[c]);
    drawPanel(float(width) - panel, panel, float(height));

    recorder_.begin(Timing::kNone);
    render(recorder_, {.color = &paper_, .clear_color = look::paper()}, {});
    window_.draw(recorder_, paper_, grid_.insets());
    window_.show(recorder_);
  }

  /// Over a camera's picture: a veil where it has not seen the board, the corners that it sees, and below it
  /// how far it is.
  void drawOver(const CollectedCamera& camera, const CameraStatus& status, const PicturePlace& place) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float em = ImGui::GetFontSize();
    const auto left = float(place.left), top = float(place.top), right = float(place.right()),
               bottom = float(place.bottom());
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
        list.AddCircleFilled(at(place, pixel), 0.17f * em, look::kClay);
      }
    const bool done = camera.share >= 1;
    const float foot = bottom + float(CameraGrid::kLabelHeight) * em;
    list.AddRectFilled({left, bottom}, {right, foot}, kLabel);
    list.AddRectFilled({left, bottom}, {left + float(camera.share) * (right - left), bottom + 0.25f * em},
                       done ? look::kGood : look::kClay);
    list.AddText({left + 0.6f * em, bottom + 0.5f * em}, look::kInk, camera.name.c_str());
    const std::string counts = std::to_string(camera.views) + " views, " +
                               std::to_string(camera.shared_views) + " shared, " +
                               fixed(100 * camera.coverage.share(), 0) + " % covered";
    const float counts_width = ImGui::CalcTextSize(counts.c_str()).x;
    list.AddText({right - counts_width - 0.6f * em, bottom + 0.5f * em}, look::kFaint, counts.c_str());
    const auto [words, color] = stateWords(camera, status);
    list.AddText({left + 0.6f * em, bottom + 1.8f * em}, color, words.c_str());
  }

  static std::pair<std::string, ImU32> stateWords(const CollectedCamera& camera, const CameraStatus& status) {
    if (status.state != CameraState::kLive && status.state != CameraState::kEnded)
      return {std::string(wordsOn(status.state)) + (status.fault.empty() ? "" : ": " + oneLine(status.fault)),
              look::kBad};
    if (!camera.seen) return {"the board is not seen", look::kFaint};
    const std::string fault = camera.fault();
    const std::string blur = camera.light ? "edges blurred by " + fixed(camera.light->blur_px, 1) + " px, " +
                                                "white at " + fixed(camera.light->white, 0) + " of 255"
                                          : "";
    if (!fault.empty()) return {fault + ": " + blur, look::kBad};
    return {"sharp, well lit: " + blur, look::kGood};
  }

  void drawPanel(float left, float width, float height) {
    ImGui::SetNextWindowPos({left, 0});
    ImGui::SetNextWindowSize({width, height});
    ImGui::Begin("##calibrating", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
    title("Calibrating");
    ImGui::ProgressBar(float(state_.share), {-1, 0.5f * ImGui::GetFontSize()}, "");
    ImGui::TextDisabled("%.0f %% of the views that make a good rig", 100 * state_.share);
    ImGui::Spacing();
    if (!state_.working && state_.result.empty() && !state_.advice.empty()) title(sentence(state_.advice));
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled(
        "%d positions of the board are kept. One is kept when the board rests for a moment "
        "where it was not yet; the veil over each picture goes where it has been.",
        state_.kept_sets);
    ImGui::PopTextWrapPos();
    ImGui::Separator();
    drawWishes();
    drawResult();
    ImGui::End();
  }

  static std::string sentence(std::string words) {
    words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
    return words + ".";
  }

  static void title(const std::string& words) {
    ImGui::PushFont(titleFont());
    ImGui::TextWrapped("%s", words.c_str());
    ImGui::PopFont();
  }

  void drawWishes() {
    const auto wished = [](const char* label, int key, bool possible) {
      ImGui::BeginDisabled(!possible);
      const bool clicked = ImGui::Button(label, {-1, 0});
      ImGui::EndDisabled();
      return possible && (clicked || ImGui::IsKeyPressed(key, false));
    };
    const bool idle = !state_.working;
    ImGui::PushStyleColor(ImGuiCol_Button, state_.enough && idle ? ImVec4(0.71f, 0.42f, 0.25f, 0.55f)
                                                                 : ImGui::GetStyleColorVec4(ImGuiCol_Button));
    if (wished("Make the rig   Enter", GLFW_KEY_ENTER, idle && state_.kept_sets > 0)) calibration_.finish();
    ImGui::PopStyleColor();
    if (wished("The world is where the board lies   W", GLFW_KEY_W, idle)) calibration_.takeWorld();
    if (wished("Begin again   Backspace", GLFW_KEY_BACKSPACE, idle)) calibration_.beginAgain();
    if (wished("Close   Esc", GLFW_KEY_ESCAPE, true)) window_.close();
    ImGui::PushTextWrapPos(0);
    if (state_.world)
      ImGui::TextDisabled("The world is the board's of set %d: the cube stands on it.", *state_.world);
    else
      ImGui::TextDisabled("Without a board for the world, it is that of the first one that all see best.");
    ImGui::PopTextWrapPos();
  }

  void drawResult() {
    ImGui::Separator();
    if (state_.working) ImGui::ProgressBar(float(state_.work_share), {-1, 0.5f * ImGui::GetFontSize()}, "");
    if (!state_.fault.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, look::kBad);
      ImGui::TextWrapped("%s", state_.fault.c_str());
      ImGui::PopStyleColor();
    }
    for (const std::string& line : state_.result) ImGui::TextWrapped("%s", line.c_str());
  }

  Gpu& gpu_;
  LiveCalibration& calibration_;
  Window window_;
  Recorder recorder_;
  LiveCalibration::State state_;
  Image paper_;
  CameraGrid grid_;
};

}  // namespace

LiveCalibration::State showCalibration(Gpu& gpu, LiveCalibration& calibration) {
  return CalibrationWindow(gpu, calibration).run();
}

void wakeCalibrationWindow() {
  glfwPostEmptyEvent();
}

}  // namespace airclay
