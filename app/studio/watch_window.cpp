// SPDX-License-Identifier: MIT
#include "app/studio/watch_window.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include "app/command.h"
#include "app/studio/camera_grid.h"
#include "app/studio/look.h"
#include "engine/gpu/graphics.h"
#include "engine/gpu/recorder.h"

namespace airclay {
namespace {

constexpr double kLookUpS = 0.05;

ImU32 colorOf(CameraState state) {
  if (state == CameraState::kLive) return look::kGood;
  return state == CameraState::kLate || state == CameraState::kEnded ? look::kDoubt : look::kBad;
}

/// Below a camera's picture: its name, how it runs, and its last fault.
void drawLabel(const CameraStatus& camera, const PicturePlace& place) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float em = ImGui::GetFontSize();
  const auto left = float(place.left), top = float(place.bottom()), right = float(place.right());
  list.AddRectFilled({left, top}, {right, top + float(CameraGrid::kLabelHeight) * em},
                     IM_COL32(250, 248, 245, 240));
  list.AddText({left + 0.6f * em, top + 0.4f * em}, look::kInk, camera.name.c_str());
  const std::string size = std::to_string(camera.size.width) + " x " + std::to_string(camera.size.height);
  list.AddText({right - ImGui::CalcTextSize(size.c_str()).x - 0.6f * em, top + 0.4f * em}, look::kFaint,
               size.c_str());
  std::string how = std::string(wordsOn(camera.state)) + ", " + fixed(camera.measured_hz, 1) + " of " +
                    fixed(camera.rate_hz, 1) + " Hz, " + std::to_string(camera.drops) + " drops, " +
                    fixed(1000 * camera.skew_s, 1) + " ms off";
  if (camera.state != CameraState::kLive && !camera.fault.empty()) how += ": " + oneLine(camera.fault);
  list.PushClipRect({left, top}, {right, top + float(CameraGrid::kLabelHeight) * em}, true);
  list.AddText({left + 0.6f * em, top + 1.8f * em}, colorOf(camera.state), how.c_str());
  list.PopClipRect();
}

}  // namespace

void watchCameras(Gpu& gpu, LiveCameras& cameras, const std::function<bool(const LiveSet*)>& goes_on) {
  Window window(gpu, {.title = "Airclay: cameras", .width = 1280, .height = 800});
  Recorder recorder(gpu);
  CameraGrid grid(gpu);
  Image paper;
  LiveSet last;
  while (!window.closing()) {
    std::optional<LiveSet> set = cameras.next(kLookUpS);
    if (!goes_on(set ? &*set : nullptr)) return;
    if (set) last = std::move(*set);
    window.poll(0);
    if (window.begin(false) == Window::Begun::kNothing) continue;  // minimised
    if (ImGui::IsKeyPressed(GLFW_KEY_ESCAPE, false)) window.close();
    const auto width = static_cast<std::uint32_t>(window.width()),
               height = static_cast<std::uint32_t>(window.height());
    if (paper.width() != width || paper.height() != height)
      paper = Image(gpu, ImageKind::kScreen, width, height);
    const std::vector<CameraStatus> all = cameras.status();
    std::vector<PictureSize> sizes;
    for (const CameraStatus& camera : all) sizes.push_back(camera.size);
    grid.place(sizes, width, height, ImGui::GetFontSize());
    grid.draw(last.pictures);
    for (std::size_t c = 0; c < all.size(); ++c) drawLabel(all[c], grid.places()[c]);
    recorder.begin(Timing::kNone);
    render(recorder, {.color = &paper, .clear_color = look::paper()}, {});
    window.draw(recorder, paper, grid.insets());
    window.show(recorder);
  }
}

}  // namespace airclay
