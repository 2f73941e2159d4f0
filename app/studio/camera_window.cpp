// SPDX-License-Identifier: MIT
#include "app/studio/camera_window.h"

#include <imgui/imgui.h>

#include <algorithm>

#include "app/studio/theme.h"
#include "engine/gpu/graphics.h"

namespace airclay {
namespace {

// In units of the font size.
constexpr float kGap = 0.9f, kLabelHeight = 3.4f, kMargin = 0.6f, kNameAt = 0.5f, kLineAt = 1.8f;
constexpr double kSmallestScale = 0.05, kLargestScale = 2;
constexpr std::uint32_t kMissing = 0xFFB8B2ACu;

/// Bilinear; B G R A.
void drawImage(const LiveImage& image, const ImagePlacement& place, std::uint32_t* out) {
  if (image.bgr.empty()) {
    std::fill_n(out, std::size_t(place.width) * std::size_t(place.height), kMissing);
    return;
  }
  const auto within = [&](int at, int most) {
    return std::clamp((at + 0.5) / place.scale - 0.5, 0.0, most - 1.001);
  };
  const std::size_t stride = 3 * static_cast<std::size_t>(image.size.width);
  for (int row = 0; row < place.height; ++row)
    for (int column = 0; column < place.width; ++column) {
      const double x = within(column, image.size.width), y = within(row, image.size.height);
      const auto left = static_cast<std::size_t>(x), top = static_cast<std::size_t>(y);
      const double u = x - double(left), v = y - double(top);
      const std::uint8_t* upper = image.bgr.data() + top * stride + 3 * left;
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

}  // namespace

CameraWindow::CameraWindow(Gpu& gpu, const std::string& title)
    : gpu_(gpu), window_(gpu, {.title = title, .width = 1280, .height = 800}), recorder_(gpu) {}

void CameraWindow::lay(const std::vector<ImageSize>& sizes, const std::vector<LiveImage>& images,
                       double beside_px) {
  place(sizes, window_.width() - beside_px, window_.height());
  drawImages(images);
}

void CameraWindow::place(const std::vector<ImageSize>& sizes, double width, double height) {
  const double em = ImGui::GetFontSize();
  const double gap = kGap * em, label = kLabelHeight * em;
  const auto count = static_cast<int>(sizes.size());
  double widest = 1, highest = 1;
  for (const ImageSize& size : sizes) {
    widest = std::max(widest, double(size.width));
    highest = std::max(highest, double(size.height));
  }
  const auto rowsOf = [&](int columns) { return (count + columns - 1) / columns; };
  const auto scaleWith = [&](int columns) {
    return std::min((width - gap * (columns + 1)) / columns / widest,
                    ((height - gap * (rowsOf(columns) + 1)) / rowsOf(columns) - label) / highest);
  };
  int columns = 1;
  for (int more = 2; more <= count; ++more)
    if (scaleWith(more) > scaleWith(columns)) columns = more;
  const double scale = std::clamp(scaleWith(columns), kSmallestScale, kLargestScale);
  const double cell_width = widest * scale + gap, cell_height = highest * scale + label + gap;
  const double first_left = std::max(0.0, (width - columns * cell_width + gap) / 2),
               first_top = std::max(0.0, (height - rowsOf(columns) * cell_height + gap) / 2);
  places_.clear();
  for (int i = 0; i < count; ++i) {
    const ImageSize& size = sizes[static_cast<std::size_t>(i)];
    places_.push_back({static_cast<int>(first_left + (i % columns) * cell_width),
                       static_cast<int>(first_top + (i / columns) * cell_height),
                       std::max(1, static_cast<int>(size.width * scale)),
                       std::max(1, static_cast<int>(size.height * scale)), scale});
  }
}

void CameraWindow::drawImages(const std::vector<LiveImage>& images) {
  std::size_t pixels = 0;
  for (const ImagePlacement& place : places_) pixels += std::size_t(place.width) * std::size_t(place.height);
  if (pixels > pixels_.count()) pixels_ = Buffer<std::uint32_t>(gpu_, pixels, Memory::kHost);
  insets_.clear();
  std::size_t first = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const ImagePlacement& place = places_[i];
    const LiveImage none;
    drawImage(i < images.size() ? images[i] : none, place, pixels_.host().data() + first);
    insets_.push_back({&pixels_, first, place.width, place.height, place.left, place.top});
    first += std::size_t(place.width) * std::size_t(place.height);
  }
}

void CameraWindow::drawLabel(std::size_t camera, const CameraLabel& label) const {
  constexpr ImU32 kLabelPaper = IM_COL32(250, 248, 245, 240);
  const ImagePlacement& place = places_[camera];
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float em = ImGui::GetFontSize();
  const auto left = float(place.left), top = float(place.bottom()), right = float(place.right());
  const float bottom = top + kLabelHeight * em, margin = kMargin * em;
  list.AddRectFilled({left, top}, {right, bottom}, kLabelPaper);
  list.PushClipRect({left, top}, {right, bottom}, true);
  list.AddText({left + margin, top + kNameAt * em}, theme::kInk, label.name.c_str());
  list.AddText({right - ImGui::CalcTextSize(label.right.c_str()).x - margin, top + kNameAt * em},
               theme::kFaint, label.right.c_str());
  list.AddText({left + margin, top + kLineAt * em}, label.line_color, label.line.c_str());
  list.PopClipRect();
}

void CameraWindow::show() {
  const auto width = static_cast<std::uint32_t>(window_.width()),
             height = static_cast<std::uint32_t>(window_.height());
  if (paper_.width() != width || paper_.height() != height)
    paper_ = Image(gpu_, ImageKind::kScreen, width, height);
  recorder_.begin(Timing::kNone);
  render(recorder_, {.color = &paper_, .clear_color = theme::paper()}, {});
  window_.draw(recorder_, paper_, insets_);
  window_.show(recorder_);
}

}  // namespace airclay
