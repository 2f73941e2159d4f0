// SPDX-License-Identifier: MIT
#include "app/studio/panels.h"

#include <imgui/imgui.h>

#include <algorithm>
#include <cmath>

#include "app/cli/command.h"
#include "app/session/tracking_summary.h"
#include "app/studio/icon.h"
#include "app/studio/shortcuts.h"
#include "app/studio/theme.h"
#include "engine/clay/presets.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                                    ImGuiWindowFlags_NoNav;
constexpr float kMargin = 12;
constexpr double kWorkShownAfterMs = 300;
constexpr std::size_t kHistory = 150;  // five seconds at 30 Hz

ImVec4 colorOf(std::uint32_t packed) {
  return ImGui::ColorConvertU32ToFloat4(packed);
}

struct TrustLabel {
  const char* text;
  std::uint32_t color;
};
TrustLabel labelOf(TrackingState trust) {
  switch (trust) {
    case TrackingState::kTracking:
      return {"Tracking", theme::kGood};
    case TrackingState::kUncertain:
      return {"Uncertain: sculpting paused", theme::kDoubt};
    case TrackingState::kLost:
      return {"Hand lost: sculpting paused", theme::kBad};
    case TrackingState::kNoHand:
      break;
  }
  return {"No hand", theme::kFaint};
}

/// A toggle button.
bool toggle(const char* label, bool on, const ImVec2& size) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, colorOf(theme::kClay));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, colorOf(theme::kClay));
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1, 1, 1, 1));
  }
  const bool pressed = ImGui::Button(label, size);
  if (on) ImGui::PopStyleColor(3);
  return pressed;
}

/// A toggle with an icon above its name.
bool iconToggle(const Tool& tool, bool on, const ImVec2& size) {
  const std::string id = std::string("##tool ") + tool.id;
  const bool pressed = toggle(id.c_str(), on, size);
  const ImVec2 low = ImGui::GetItemRectMin(), text = ImGui::CalcTextSize(tool.name);
  const float icon = size.y - text.y - 0.6f * ImGui::GetFontSize(), middle = low.x + size.x / 2;
  const ImU32 color = on ? IM_COL32_WHITE : ImGui::GetColorU32(ImGuiCol_Text);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  drawIcon(list, tool.icon, ImVec2(middle - icon / 2, low.y + 0.2f * ImGui::GetFontSize()), icon,
           0.1f * ImGui::GetFontSize(), color);
  list.AddText(ImVec2(middle - text.x / 2, low.y + size.y - text.y - 0.2f * ImGui::GetFontSize()), color,
               tool.name);
  return pressed;
}

void tip(const char* text) {
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", text);
}

}  // namespace

void Meter::shown(std::optional<double> latency_ms) {
  const auto now = Clock::now();
  times_.push_back(now);
  while (now - times_.front() > std::chrono::seconds(2)) times_.pop_front();
  const double span_s = std::chrono::duration<double>(now - times_.front()).count();
  frame_hz_ = span_s > 0 ? static_cast<double>(times_.size() - 1) / span_s : 0;
  if (latency_ms) {
    latencies_.emplace_back(now, *latency_ms);
    history_.push_back(static_cast<float>(*latency_ms));
    if (history_.size() > kHistory) history_.pop_front();
  }
  while (!latencies_.empty() && now - latencies_.front().first > std::chrono::seconds(2))
    latencies_.pop_front();
  std::vector<double> values;
  for (const auto& [time, ms] : latencies_) values.push_back(ms);
  latency_ms_ = median(values);
}

PanelRequests Panels::draw(const Snapshot& snapshot, const Viewport& viewport, const Meter& meter) {
  PanelRequests requests;
  insets_.clear();
  const DocumentView document = session_.documentView();
  drawMenu(document, requests);
  if (settings_.show_panels) {
    drawTools(document, requests);
    drawStatus(snapshot, viewport, meter);
  }
  drawHint(snapshot, viewport);
  drawTask();
  return requests;
}

void Panels::drawMenu(const DocumentView& document, PanelRequests& requests) {
  if (!ImGui::BeginMainMenuBar()) return;
  menu_height_ = ImGui::GetWindowHeight();
  if (ImGui::BeginMenu("File")) {
    if (ImGui::BeginMenu("New clay")) {
      for (const std::string& preset : presetNames())
        if (ImGui::MenuItem(preset.c_str())) requests.new_clay = preset;
      ImGui::EndMenu();
    }
    requests.open = ImGui::MenuItem("Open...", "Ctrl O");
    requests.save_as = ImGui::MenuItem("Save as...", "Ctrl S");
    requests.record = ImGui::MenuItem(session_.recorderView().recording ? "Stop recording" : "Record",
                                      "Ctrl R", false, !session_.replaying());
    ImGui::Separator();
    requests.import = ImGui::MenuItem("Import cage...");
    requests.export_surface = ImGui::MenuItem("Export surface...", "Ctrl E");
    requests.export_cage = ImGui::MenuItem("Export cage...");
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Edit")) {
    const std::string undo = "Undo " + document.undo.value_or(""),
                      redo = "Redo " + document.redo.value_or("");
    if (ImGui::MenuItem(undo.c_str(), "Ctrl Z", false, document.undo.has_value())) session_.undo();
    if (ImGui::MenuItem(redo.c_str(), "Ctrl Shift Z", false, document.redo.has_value())) session_.redo();
    if (ImGui::MenuItem("Refine", "R")) session_.refineClay();
    if (ImGui::MenuItem("Remesh", "M")) session_.remeshClay();
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("View")) {
    ImGui::MenuItem("Panels", "Tab", &settings_.show_panels);
    ImGui::MenuItem("Control cage", "G", &settings_.show_cage);
    ImGui::MenuItem("Data points", "P", &settings_.show_points);
    ImGui::MenuItem("Voxels", "V", &settings_.show_voxels, session_.hasRecording());
    ImGui::MenuItem("Skeleton", "B", &settings_.show_skeleton);
    ImGui::MenuItem("Cameras", "C", &settings_.show_cameras);
    ImGui::EndMenu();
  }
  requests.help = ImGui::MenuItem("Help  F1");
  const std::string name = document.file.stem().string();
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  ImGui::SameLine((ImGui::GetIO().DisplaySize.x - width) / 2);
  ImGui::TextDisabled("%s", name.c_str());
  ImGui::EndMainMenuBar();
}

void Panels::drawTools(const DocumentView& document, PanelRequests& requests) {
  ImGui::SetNextWindowPos(ImVec2(kMargin, menu_height_ + kMargin));
  ImGui::Begin("Sculpt", nullptr, kPanel);
  const float em = ImGui::GetFontSize();
  const ImVec2 third(em * 4.2f, em * 3.6f);
  for (std::size_t i = 0; i < settings_.tools.size(); ++i) {
    const Tool& tool = settings_.tools[i].tool();
    if (i % 3 != 0) ImGui::SameLine();
    if (iconToggle(tool, settings_.tool == i, third)) settings_.tool = i;
    const std::string key = i < kToolKeys ? "  (" + std::to_string(i + 1) + ")" : "";
    tip((tool.description + key).c_str());
  }
  drawToolSettings(settings_.tools[settings_.tool], 3 * third.x + 2 * ImGui::GetStyle().ItemSpacing.x);
  ImGui::TextDisabled("Symmetry");
  const struct {
    bool& on;
    const char *label, *tip;
  } planes[] = {{settings_.symmetry.x, "x", "Mirror left and right  (X)"},
                {settings_.symmetry.y, "y", "Mirror front and back  (Y)"},
                {settings_.symmetry.z, "z", "Mirror top and bottom"}};
  for (const auto& [on, label, text] : planes) {
    if (&on != &settings_.symmetry.x) ImGui::SameLine();
    if (toggle(label, on, ImVec2(third.x, em * 1.8f))) on = !on;
    tip(text);
  }
  const float half = (3 * third.x + ImGui::GetStyle().ItemSpacing.x) / 2;
  drawClutch(half, requests);
  ImGui::Checkbox("Filter hand motion", &settings_.filtered);
  tip("Steady the hand at rest; adds a few milliseconds of latency");
  ImGui::Separator();
  const ImVec2 pair(half, em * 1.9f);
  if (ImGui::Button("Undo", pair)) session_.undo();
  tip(document.undo ? document.undo->c_str() : "Nothing to undo");
  ImGui::SameLine();
  if (ImGui::Button("Redo", pair)) session_.redo();
  tip(document.redo ? document.redo->c_str() : "Nothing to redo");
  drawRecorder(ImVec2(2 * half + ImGui::GetStyle().ItemSpacing.x, em * 1.9f), requests);
  drawSurface(document);
  if (ImGui::CollapsingHeader("View")) drawShown();
  ImGui::End();
}

/// A slider per setting; Ctrl click types a value, a right click restores the initial one.
void Panels::drawToolSettings(ToolChoice& choice, float width) {
  for (std::size_t i = 0; i < choice.values().size(); ++i) {
    const ToolSetting& setting = choice.tool().settings[i];
    const std::string format = *setting.unit ? "%.0f " + std::string(setting.unit) : "%.1f";
    ImGui::TextDisabled("%s", setting.name);
    float value = static_cast<float>(choice.values()[i]);
    ImGui::SetNextItemWidth(width);
    if (ImGui::SliderFloat((std::string("##") + choice.tool().id + setting.id).c_str(), &value,
                           static_cast<float>(setting.minimum), static_cast<float>(setting.maximum),
                           format.c_str(), ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
      choice.setValue(i, *setting.unit ? std::round(value) : std::round(10 * value) / 10);
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) choice.setValue(i, setting.initial);
    tip("Drag; Ctrl click to type; right click for the default");
  }
}

void Panels::drawClutch(float half, PanelRequests& requests) {
  const ImVec2 size(half, ImGui::GetFontSize() * 1.8f);
  ImGui::TextDisabled("Clutch");
  if (toggle("On contact", settings_.clutch == Clutch::kContact, size)) settings_.clutch = Clutch::kContact;
  tip("Sculpt whenever the hand touches the clay");
  ImGui::SameLine();
  if (toggle("Hold key", settings_.clutch == Clutch::kHold, size)) settings_.clutch = Clutch::kHold;
  tip("Sculpt only while the clutch key is down; a foot pedal also sends a key");
  if (settings_.clutch != Clutch::kHold) asks_for_key_ = false;
  if (settings_.clutch != Clutch::kHold) return;
  const std::string label =
      asks_for_key_ ? "Press a key or the pedal" : "Key: " + keyName(settings_.clutch_key);
  if (toggle((label + "##clutch key").c_str(), asks_for_key_,
             ImVec2(2 * half + ImGui::GetStyle().ItemSpacing.x, size.y)))
    asks_for_key_ = !asks_for_key_;
  tip("Change the key");
  if (!asks_for_key_) return;
  requests.clutch_key = keyPressed();
  if (requests.clutch_key != 0) asks_for_key_ = false;
}

void Panels::drawRecorder(const ImVec2& size, PanelRequests& requests) {
  const RecorderView recorder = session_.recorderView();
  const std::string label =
      recorder.recording ? "Stop  (" + std::to_string(recorder.frames) + " frames)" : "Record";
  ImGui::BeginDisabled(session_.replaying());
  if (toggle((label + "##record").c_str(), recorder.recording, size)) requests.record = true;
  ImGui::EndDisabled();
  tip("Record images and actions to a folder, for replay  (Ctrl R)");
  if (recorder.waited_s > 0.05)
    ImGui::TextColored(colorOf(theme::kDoubt), "Slow disk: waited %.1f s", recorder.waited_s);
}

/// Shows a task of the session's thread that takes a while.
void Panels::drawTask() {
  const TaskStatus work = session_.taskStatus();
  if (work.what.empty() || millisecondsSince(work.since) < kWorkShownAfterMs) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  ImGui::Begin("##work", nullptr, kPanel | ImGuiWindowFlags_NoDecoration);
  ImGui::Text("%s, %.0f s", work.what.c_str(), 1e-3 * millisecondsSince(work.since));
  ImGui::ProgressBar(static_cast<float>(work.share), ImVec2(em * 18, 0), "");
  if (ImGui::Button("Cancel  (Esc)") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false))
    session_.cancelTask();
  ImGui::End();
}

void Panels::drawSurface(const DocumentView& document) {
  if (!ImGui::CollapsingHeader("Clay")) return;
  ImGui::Text("%d control points, %d data points", document.control_points, document.data_points);
  int levels = document.levels;
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 6);
  if (ImGui::InputInt("Level", &levels, 1, 1)) {
    levels = std::clamp(levels, 1, 6);
    if (levels != document.levels) session_.setSurface(levels, document.rule, document.solve);
  }
  tip("Number of subdivisions of the cage");
  int rule = document.rule == SubdivisionRule::kPrinted;
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9);
  if (ImGui::Combo("Rule", &rule, "Catmull-Clark\0As printed\0"))
    session_.setSurface(document.levels, rule ? SubdivisionRule::kPrinted : SubdivisionRule::kCatmullClark,
                        document.solve);
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9);
  if (ImGui::BeginCombo("Solve", document.solve->name)) {
    for (const SolveMethod* method : solveMethods())
      if (ImGui::Selectable(method->name, method == document.solve) && method != document.solve)
        session_.setSurface(document.levels, document.rule, method);
    ImGui::EndCombo();
  }
  if (ImGui::Button("Refine")) session_.refineClay();
  tip("Refine the cage without changing the surface, to add detail  (R)");
  ImGui::SameLine();
  if (ImGui::Button("Remesh")) session_.remeshClay();
  tip("New cage of even quads for the same surface; overlapping lobes fuse  (M)");
}

void Panels::drawShown() {
  ImGui::Checkbox("Control cage", &settings_.show_cage);
  ImGui::Checkbox("Data points", &settings_.show_points);
  if (session_.hasRecording()) ImGui::Checkbox("Voxels", &settings_.show_voxels);
  ImGui::Checkbox("Skeleton", &settings_.show_skeleton);
  ImGui::Checkbox("Cameras", &settings_.show_cameras);
}

void Panels::drawStatus(const Snapshot& snapshot, const Viewport& viewport, const Meter& meter) {
  const float width = ImGui::GetIO().DisplaySize.x;
  ImGui::SetNextWindowPos(ImVec2(width - kMargin, menu_height_ + kMargin), ImGuiCond_Always, ImVec2(1, 0));
  ImGui::Begin("Hand", nullptr, kPanel);
  const TrustLabel trust = snapshot.learning ? TrustLabel{"Learning the background", theme::kFaint}
                           : snapshot.ended  ? TrustLabel{"End of the recording", theme::kFaint}
                           : snapshot.silent ? TrustLabel{"No images", theme::kFaint}
                                             : labelOf(snapshot.trust);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float em = ImGui::GetFontSize();
  ImGui::GetWindowDrawList()->AddCircleFilled(ImVec2(at.x + em * 0.4f, at.y + em * 0.55f), em * 0.34f,
                                              trust.color);
  ImGui::Dummy(ImVec2(em * 0.9f, em));
  ImGui::SameLine();
  ImGui::TextUnformatted(trust.text);
  ImGui::Text("%.0f images/s drawn, %.0f frames/s tracked", meter.frameHz(), snapshot.rate_hz);
  ImGui::Text("Latency: %.0f ms", meter.latencyMs());
  if (session_.hasRecording()) {
    if (const HandFit* fit = snapshot.result.trackedHand())
      ImGui::Text("Skin outside the hull: %.0f %%", 100 * fit->outside_fraction);
    if (snapshot.skew_s)
      ImGui::Text("Camera skew: %.1f ms", 1000 * *snapshot.skew_s);
    else
      ImGui::TextDisabled("Cameras without timestamps");
    for (const std::string& camera_problem : snapshot.camera_problems)
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(theme::kClay), "%s", camera_problem.c_str());
    drawStages(snapshot);
  }
  if (settings_.show_graph && meter.history().size() > 1) {
    const std::vector<float> values(meter.history().begin(), meter.history().end());
    const float highest = std::max(120.0f, 1.1f * *std::max_element(values.begin(), values.end()));
    ImGui::PlotLines("##latency", values.data(), static_cast<int>(values.size()), 0, nullptr, 0, highest,
                     ImVec2(Session::kThumbnailWidth - 2 * ImGui::GetStyle().WindowPadding.x, em * 3.5f));
    tip("Latency from camera to display in milliseconds, last frames");
  }
  status_bottom_ = ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
  ImGui::End();
  if (session_.hasRecording()) drawCameras(snapshot, viewport);
}

void Panels::drawStages(const Snapshot& snapshot) {
  std::string text = "Decode " + fixed(snapshot.decode_ms, 1);
  for (const auto& [name, ms] : snapshot.stage_ms) text += ", " + name + " " + fixed(ms, 1);
  if (snapshot.filter_lag_ms) text += ", filter " + fixed(*snapshot.filter_lag_ms, 0);
  const float top = ImGui::GetCursorPosY();
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + Session::kThumbnailWidth -
                         2 * ImGui::GetStyle().WindowPadding.x);
  ImGui::TextDisabled("%s ms", text.c_str());
  ImGui::PopTextWrapPos();
  // constant height of three lines, so that the panels below do not move
  ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(),
                                top + 3 * ImGui::GetTextLineHeight() + ImGui::GetStyle().ItemSpacing.y));
}

/// The images are drawn under the interface, so this panel has no background. If not all fit, they are half
/// as large, in two columns; beyond that, the list scrolls.
void Panels::drawCameras(const Snapshot& snapshot, const Viewport& viewport) {
  const std::vector<Camera>& cameras = session_.rig().cameras;
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  constexpr auto gap = static_cast<float>(Session::kThumbnailGap);
  const float top = status_bottom_ + kMargin, room = window.y - kMargin - top;
  const auto heightOf = [&](bool small) {
    int height = 0;
    for (std::size_t c = 0; c < cameras.size(); ++c)
      height = std::max(height, session_.thumbnail(c, small).height);
    return static_cast<float>(height) + gap;
  };
  const bool small = heightOf(false) * static_cast<float>(cameras.size()) > room;
  const std::size_t columns = small ? 2 : 1, rows = (cameras.size() + columns - 1) / columns;
  const auto shown = static_cast<std::size_t>(std::max(1.0f, room / heightOf(small)));
  const std::size_t first = scrollCameras(rows, shown, ImVec2(window.x - kMargin, top), room);
  for (std::size_t c = first * columns; c < std::min(cameras.size(), (first + shown) * columns); ++c) {
    const Session::Thumbnail& image = session_.thumbnail(c, small);
    const float left = window.x - kMargin - static_cast<float>(Session::kThumbnailWidth) +
                       static_cast<float>(c % columns) * (static_cast<float>(image.width) + gap);
    drawCamera(c, image, ImVec2(left, top + static_cast<float>(c / columns - first) * heightOf(small)),
               snapshot, viewport);
  }
}

/// The first visible row.
std::size_t Panels::scrollCameras(std::size_t rows, std::size_t shown, const ImVec2& right_top, float room) {
  if (rows <= shown) return 0;
  constexpr auto width = static_cast<float>(Session::kThumbnailWidth);
  ImGui::SetNextWindowPos(ImVec2(right_top.x - width, right_top.y));
  ImGui::SetNextWindowSize(ImVec2(width, room));
  ImGui::Begin("##cameras", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBackground |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoMove);
  if (ImGui::IsWindowHovered()) first_camera_row_ -= static_cast<int>(ImGui::GetIO().MouseWheel);
  tip("Scroll for more cameras");
  ImGui::End();
  first_camera_row_ = std::clamp(first_camera_row_, 0, static_cast<int>(rows - shown));
  return static_cast<std::size_t>(first_camera_row_);
}

void Panels::drawCamera(std::size_t c, const Session::Thumbnail& image, const ImVec2& at,
                        const Snapshot& snapshot, const Viewport& viewport) {
  const Camera& camera = session_.rig().cameras[c];
  insets_.push_back({&session_.thumbnails(), image.first, image.width, image.height, static_cast<int>(at.x),
                     static_cast<int>(at.y)});
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  if (const HandFit* fit = snapshot.result.trackedHand()) {
    const float scale = static_cast<float>(image.width) / static_cast<float>(camera.width);
    for (const auto& [a, b] : viewport.outline(c, fit->pose.world_from_hand))
      draw->AddLine(ImVec2(at.x + scale * float(a.x()), at.y + scale * float(a.y())),
                    ImVec2(at.x + scale * float(b.x()), at.y + scale * float(b.y())), 0xFFFFFFFFu, 1.2f);
  }
  draw->AddText(ImVec2(at.x + 6, at.y + 3), 0xE0FFFFFFu, camera.name.c_str());
}

void Panels::drawHint(const Snapshot& snapshot, const Viewport& viewport) {
  std::string text;
  if (snapshot.grip_barred) {
    text = "Hand lost: press the clutch again to grip";
  } else if (viewport.gapMetres()) {
    const double gap_mm = 1000 * *viewport.gapMetres();
    text = gap_mm > 0.5 ? fixed(gap_mm, 0) + " mm to the clay" : "Touching";
  } else if (!session_.hasRecording() && snapshot.hands.empty()) {
    text = "Drag to move the hand into view. F1: keys";
  }
  if (text.empty()) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y - kMargin), ImGuiCond_Always, ImVec2(0.5f, 1));
  ImGui::Begin("##hint", nullptr, kPanel | ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
}

}  // namespace airclay
