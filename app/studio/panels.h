// SPDX-License-Identifier: MIT
// The studio's panels: tools on the left, what is seen and how well on the right, the document above.
#pragma once

#include <deque>

struct ImVec2;

#include "app/studio/settings.h"
#include "app/studio/viewport.h"
#include "app/studio/window.h"

namespace airclay {

/// Figures of the last seconds, for the graph and the log.
class Meter {
 public:
  /// An image was shown; `latency_ms` since its frame was captured, when it shows a new one.
  void shown(std::optional<double> latency_ms);
  double frameHz() const { return frame_hz_; }
  double latencyMs() const { return latency_ms_; }  ///< median of the last two seconds
  /// Of every new frame, the oldest first.
  const std::deque<float>& history() const { return history_; }

 private:
  std::deque<Clock::time_point> times_;
  std::deque<std::pair<Clock::time_point, double>> latencies_;
  std::deque<float> history_;
  double frame_hz_ = 0, latency_ms_ = 0;
};

/// What the panels ask the studio for, beyond the settings.
struct PanelRequests {
  bool open = false, save_as = false, import = false, export_surface = false, export_cage = false,
       help = false;
  bool record = false;   ///< begin a recording, or end the one under way
  std::string new_clay;  ///< a preset's name
  int clutch_key = 0;    ///< GLFW's number of the key that was pressed when one was asked for
};

/// The number keys 1 to 4 choose tools; 5 and up choose views.
inline constexpr std::size_t kToolKeys = 4;

class Panels {
 public:
  Panels(Session& session, StudioSettings& settings) : session_(session), settings_(settings) {}

  PanelRequests draw(const Snapshot& snapshot, const Viewport& viewport, const Meter& meter);
  /// Where the cameras' images lie, of the panels drawn last.
  std::span<const Inset> insets() const { return insets_; }
  /// The next key that is pressed is to be the clutch: it means nothing else.
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
  float menu_height_ = 0, status_bottom_ = 0;  ///< pixels, of the last image
  bool asks_for_key_ = false;
  int first_camera_row_ = 0;  ///< of more cameras than there is room for
};

}  // namespace airclay
