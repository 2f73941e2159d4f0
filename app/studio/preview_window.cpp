// SPDX-License-Identifier: MIT
#include "app/studio/preview_window.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include "app/cli/command.h"
#include "app/studio/camera_window.h"
#include "app/studio/theme.h"

namespace airclay {
namespace {

constexpr double kLookUpS = 0.05;

ImU32 colorOf(CameraState state) {
  if (state == CameraState::kLive) return theme::kGood;
  return state == CameraState::kLate || state == CameraState::kEnded ? theme::kDoubt : theme::kBad;
}

CameraLabel labelOf(const CameraStatus& camera) {
  std::string how = std::string(nameOf(camera.state)) + ", " + fixed(camera.measured_hz, 1) + " of " +
                    fixed(camera.rate_hz, 1) + " Hz, " + std::to_string(camera.drops) + " drops, " +
                    fixed(1000 * camera.skew_s, 1) + " ms skew";
  if (camera.state != CameraState::kLive && !camera.fault.empty()) how += ": " + oneLine(camera.fault);
  return {camera.name, std::to_string(camera.size.width) + " x " + std::to_string(camera.size.height), how,
          colorOf(camera.state)};
}

}  // namespace

void watchCameras(Gpu& gpu, LiveCameras& cameras, const std::function<bool(const LiveSet*)>& goes_on) {
  CameraWindow shown(gpu, "Airclay: cameras");
  LiveSet last;
  while (!shown.window().closing()) {
    std::optional<LiveSet> set = cameras.next(kLookUpS);
    if (!goes_on(set ? &*set : nullptr)) return;
    if (set) last = std::move(*set);
    shown.window().poll(0);
    if (!shown.begin()) continue;  // minimised
    if (ImGui::IsKeyPressed(GLFW_KEY_ESCAPE, false)) shown.window().close();
    const std::vector<CameraStatus> all = cameras.status();
    std::vector<ImageSize> sizes;
    for (const CameraStatus& camera : all) sizes.push_back(camera.size);
    shown.lay(sizes, last.images);
    for (std::size_t c = 0; c < all.size(); ++c) shown.drawLabel(c, labelOf(all[c]));
    shown.show();
  }
}

}  // namespace airclay
