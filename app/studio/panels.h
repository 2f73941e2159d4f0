// SPDX-License-Identifier: MIT
// The studio's panels: tools on the left, tracking status and cameras on the right, the menu bar above.
#pragma once

#include <deque>

struct ImVec2;

#include "app/studio/settings.h"
#include "app/studio/viewport.h"
#include "app/studio/window.h"

namespace airclay {

/// Rates and latencies of the last seconds, for the graph and the log.
class Meter {
 public:
  /// Call it after showing an image; `latency_ms` since the capture of its frame, if the frame is new.
  void shown(std::optional<double> latency_ms);
  double frameHz() const { return frame_hz_; }
  double latencyMs() const { return latency_ms_; }  ///< median of the last two seconds
  /// Latency of every new frame, oldest first.
  const std::deque<float>& history() const { return history_; }

 private:
  std::deque<Clock::time_point> times_;
  std::deque<std::pair<Clock::time_point, double>> latencies_;
  std::deque<float> history_;
  double frame_hz_ = 0, latency_ms_ = 0;
};

/// Actions that the panels request from the studio.
struct PanelRequests {
  bool open = false, save_as = false, import = false, export_surface = false, export_cage = false,
       help = false;
  bool record = false;   ///< start or stop recording
  std::string new_clay;  ///< a preset's name
  int clutch_key = 0;    ///< GLFW code of the chosen clutch key; 0: none
};

/// The number keys 1 to 4 choose tools; 5 and up choose views.
inline constexpr std::size_t kToolKeys = 4;

class Panels {
 public:
  Panels(Session& session, StudioSettings& settings) : session_(session), settings_(settings) {}

  PanelRequests draw(const Snapshot& snapshot, const Viewport& viewport, const Meter& meter);
  /// The cameras' images, as last drawn.
  std::span<const Inset> insets() const { return insets_; }
  /// True while the next key press chooses the clutch key.
  bool asksForKey() const { return asks_for_key_; }

 private:
  void drawMenu(const DocumentView& document, PanelRequests& requests);
  void drawTools(const DocumentView& document, PanelRequests& requests);
  void drawToolSettings(ToolChoice& choice, float width);
  void drawClutch(float half, PanelRequests& requests);
  void drawRecorder(const ImVec2& size, PanelRequests& requests);
  void drawTask();
  void drawSurface(const DocumentView& document);
  void drawShown();
  void drawStatus(const Snapshot& snapshot, const Viewport& viewport, const Meter& meter);
  void drawStages(const Snapshot& snapshot);
  void drawCameras(const Snapshot& snapshot, const Viewport& viewport);
  std::size_t scrollCameras(std::size_t rows, std::size_t shown, const ImVec2& right_top, float room);
  void drawCamera(std::size_t camera, const Session::Thumbnail& image, const ImVec2& at,
                  const Snapshot& snapshot, const Viewport& viewport);
  void drawHint(const Snapshot& snapshot, const Viewport& viewport);

  Session& session_;
  StudioSettings& settings_;
  std::vector<Inset> insets_;
  float menu_height_ = 0, status_bottom_ = 0;  ///< pixels, from the last image
  bool asks_for_key_ = false;
  int first_camera_row_ = 0;  ///< scroll position, if not all cameras fit
};

}  // namespace airclay
