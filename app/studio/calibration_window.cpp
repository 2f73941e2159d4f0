// SPDX-License-Identifier: MIT
#include "app/studio/calibration_window.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "app/command.h"
#include "app/studio/look.h"
#include "app/studio/window.h"
#include "engine/gpu/graphics.h"
#include "engine/gpu/recorder.h"

namespace airclay {
namespace {

constexpr double kQuietS = 0.2;  // between pictures when no set comes
// In letters' heights.
constexpr float kPanelWidth = 22, kGap = 0.9f, kLabelHeight = 3.4f;
constexpr double kLargestScale = 2;
constexpr ImU32 kVeil = IM_COL32(250, 248, 245, 105), kLabel = IM_COL32(250, 248, 245, 240);

/// Where a camera's picture lies in the window, pixels.
struct Place {
  int left = 0, top = 0, width = 0, height = 0;
  double scale = 1;  ///< window's pixels a picture's

  ImVec2 at(const Vec2& pixel) const {
    return {static_cast<float>(left + (pixel.x() + 0.5) * scale),
            static_cast<float>(top + (pixel.y() + 0.5) * scale)};
  }
};

/// All in one grid, of as many columns as let the pictures be largest.
std::vector<Place> placesFor(const std::vector<CollectedCamera>& cameras, double width, double height,
                             double em) {
  const double gap = kGap * em, label = kLabelHeight * em;
  const auto count = static_cast<int>(cameras.size());
  double best = 0;
  int columns = 1;
  double widest = 1, highest = 1;
  for (const CollectedCamera& camera : cameras) {
    widest = std::max(widest, double(camera.size.width));
    highest = std::max(highest, double(camera.size.height));
  }
  const auto scaleWith = [&](int across) {
    const int down = (count + across - 1) / across;
    return std::min((width - gap * (across + 1)) / across / widest,
                    ((height - gap * (down + 1)) / down - label) / highest);
  };
  for (int across = 1; across <= count; ++across)
    if (scaleWith(across) > best) {
      best = scaleWith(across);
      columns = across;
    }
  best = std::clamp(best, 0.05, kLargestScale);
  const int rows = (count + columns - 1) / columns;
  const double cell_width = widest * best + gap, cell_height = highest * best + label + gap;
  const double first_left = (width - columns * cell_width + gap) / 2,
               first_top = (height - rows * cell_height + gap) / 2;
  std::vector<Place> places;
  for (int i = 0; i < count; ++i) {
    Place place;
    place.scale = best;
    place.left = static_cast<int>(first_left + (i % columns) * cell_width);
    place.top = static_cast<int>(first_top + (i / columns) * cell_height);
    place.width = static_cast<int>(cameras[std::size_t(i)].size.width * best);
    place.height = static_cast<int>(cameras[std::size_t(i)].size.height * best);
    places.push_back(place);
  }
  return places;
}

/// Bilinear; grey where there is no picture.
void drawPicture(const LivePicture* picture, const Place& place, std::uint32_t* out) {
  const bool missing = !picture || picture->bgr.empty();
  for (int row = 0; row < place.height; ++row)
    for (int column = 0; column < place.width; ++column) {
      if (missing) {
        *out++ = 0xFFB8B2ACu;
        continue;
      }
      const double x = std::clamp((column + 0.5) / place.scale - 0.5, 0.0, picture->size.width - 1.001),
                   y = std::clamp((row + 0.5) / place.scale - 0.5, 0.0, picture->size.height - 1.001);
      const auto left = static_cast<std::size_t>(x), top = static_cast<std::size_t>(y);
      const double u = x - double(left), v = y - double(top);
      const std::size_t stride = 3 * static_cast<std::size_t>(picture->size.width);
      const std::uint8_t* upper = picture->bgr.data() + top * stride + 3 * left;
      const std::uint8_t* lower = upper + stride;
      std::uint32_t word = 0xFF000000u;
      for (int channel = 0; channel < 3; ++channel) {
        const double value = (1 - v) * ((1 - u) * upper[channel] + u * upper[channel + 3]) +
                             v * ((1 - u) * lower[channel] + u * lower[channel + 3]);
        word |= static_cast<std::uint32_t>(value + 0.5) << (8 * channel);
      }
      *out++ = word;
    }
}

class CalibrationWindow {
 public:
  CalibrationWindow(Gpu& gpu, LiveCalibration& calibration)
      : gpu_(gpu),
        calibration_(calibration),
        window_(gpu, {.title = "Airclay: calibrating", .width = 1280, .height = 800}),
        recorder_(gpu) {}

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
    places_ = placesFor(state_.cameras, double(width) - panel, height, em);
    layPictures();
    for (std::size_t c = 0; c < places_.size(); ++c)
      drawOver(state_.cameras[c], state_.status[c], places_[c]);
    drawPanel(float(width) - panel, panel, float(height));

    recorder_.begin(Timing::kNone);
    render(recorder_, {.color = &paper_, .clear_color = vec4(0.72f, 0.69f, 0.65f, 1)}, {});
    window_.draw(recorder_, paper_, insets_);
    window_.show(recorder_);
  }

  void layPictures() {
    std::size_t pixels = 0;
    for (const Place& place : places_) pixels += std::size_t(place.width) * std::size_t(place.height);
    const bool new_layout = pixels > 0 && pixels != pictures_.count();
    if (new_layout) pictures_ = Buffer<std::uint32_t>(gpu_, pixels, Memory::kHost);
    if (!new_layout && state_.serial == drawn_serial_) return;
    drawn_serial_ = state_.serial;
    insets_.clear();
    std::size_t first = 0;
    for (std::size_t c = 0; c < places_.size(); ++c) {
      const Place& place = places_[c];
      drawPicture(state_.set ? &state_.set->pictures[c] : nullptr, place, pictures_.host().data() + first);
      insets_.push_back({&pictures_, first, place.width, place.height, place.left, place.top});
      first += std::size_t(place.width) * std::size_t(place.height);
    }
  }

  /// Over a camera's picture: a veil where it has not seen the board, the corners that it sees, and below it
  /// how far it is.
  void drawOver(const CollectedCamera& camera, const CameraStatus& status, const Place& place) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float em = ImGui::GetFontSize();
    const auto left = float(place.left), top = float(place.top), right = left + float(place.width),
               bottom = top + float(place.height);
    const double cell = camera.coverage.cellPixels() * place.scale;
    for (int row = 0; row < camera.coverage.rows(); ++row)
      for (int column = 0; column < BoardCoverage::kColumns; ++column)
        if (!camera.coverage.covered(column, row))
          list.AddRectFilled(
              {float(left + column * cell), float(top + row * cell)},
              {float(left + (column + 1) * cell), std::min(bottom, float(top + (row + 1) * cell))}, kVeil);
    if (camera.seen)
      for (const Vec2& pixel : camera.seen->pixels) {
        list.AddCircleFilled(place.at(pixel), 0.26f * em, IM_COL32_WHITE);
        list.AddCircleFilled(place.at(pixel), 0.17f * em, look::kClay);
      }
    const bool done = camera.share >= 1;
    const float foot = bottom + kLabelHeight * em;
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
  std::uint64_t drawn_serial_ = UINT64_MAX;
  Image paper_;
  Buffer<std::uint32_t> pictures_;
  std::vector<Place> places_;
  std::vector<Inset> insets_;
};

}  // namespace

LiveCalibration::State showCalibration(Gpu& gpu, LiveCalibration& calibration) {
  return CalibrationWindow(gpu, calibration).run();
}

void wakeCalibrationWindow() {
  glfwPostEmptyEvent();
}

}  // namespace airclay
