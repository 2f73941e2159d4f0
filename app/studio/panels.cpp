// SPDX-License-Identifier: MIT
#include "app/studio/panels.h"

#include <imgui/imgui.h>

#include <algorithm>

#include "app/command.h"
#include "app/studio/look.h"
#include "app/tracking.h"
#include "engine/presets.h"

namespace airclay {
namespace {

constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                                    ImGuiWindowFlags_NoNav;
constexpr float kMargin = 12;
constexpr std::size_t kHistory = 150;  // five seconds at 30 Hz

ImVec4 colorOf(std::uint32_t packed) {
  return ImGui::ColorConvertU32ToFloat4(packed);
}

struct TrustWords {
  const char* word;
  std::uint32_t color;
};
TrustWords wordsFor(HandTrust trust) {
  switch (trust) {
    case HandTrust::kTracking:
      return {"tracking", look::kGood};
    case HandTrust::kUncertain:
      return {"uncertain: the clay rests", look::kDoubt};
    case HandTrust::kLost:
      return {"lost: the clay rests", look::kBad};
    case HandTrust::kNobody:
      break;
  }
  return {"nobody there", look::kFaint};
}

/// A button that stays down.
bool toggle(const char* label, bool on, const ImVec2& size) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, colorOf(look::kClay));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, colorOf(look::kClay));
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1, 1, 1, 1));
  }
  const bool pressed = ImGui::Button(label, size);
  if (on) ImGui::PopStyleColor(3);
  return pressed;
}

void tip(const char* words) {
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", words);
}

}  // namespace

void Meter::shown(std::optional<double> latency_ms) {
  const auto now = Clock::now();
  times_.push_back(now);
  while (now - times_.front() > std::chrono::seconds(2)) times_.pop_front();
  const double span_s = std::chrono::duration<double>(now - times_.front()).count();
  picture_hz_ = span_s > 0 ? static_cast<double>(times_.size() - 1) / span_s : 0;
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

PanelWishes Panels::draw(const Snapshot& snapshot, const Stage& stage, const Meter& meter) {
  PanelWishes wishes;
  insets_.clear();
  const DocumentView document = session_.documentView();
  drawMenu(document, wishes);
  if (settings_.show_panels) {
    drawTools(document);
    drawStatus(snapshot, stage, meter);
  }
  drawHint(snapshot, stage);
  return wishes;
}

void Panels::drawMenu(const DocumentView& document, PanelWishes& wishes) {
  if (!ImGui::BeginMainMenuBar()) return;
  menu_height_ = ImGui::GetWindowHeight();
  if (ImGui::BeginMenu("File")) {
    if (ImGui::BeginMenu("New clay")) {
      for (const std::string& preset : presetNames())
        if (ImGui::MenuItem(preset.c_str())) wishes.new_clay = preset;
      ImGui::EndMenu();
    }
    wishes.open = ImGui::MenuItem("Open...", "Ctrl O");
    wishes.save_as = ImGui::MenuItem("Save as...", "Ctrl S");
    ImGui::Separator();
    wishes.import = ImGui::MenuItem("Import a cage (OBJ)...");
    wishes.export_surface = ImGui::MenuItem("Export the surface...", "Ctrl E");
    wishes.export_cage = ImGui::MenuItem("Export the cage...");
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Edit")) {
    const std::string undo = "Undo " + document.undo.value_or(""),
                      redo = "Redo " + document.redo.value_or("");
    if (ImGui::MenuItem(undo.c_str(), "Ctrl Z", false, document.undo.has_value())) session_.undo();
    if (ImGui::MenuItem(redo.c_str(), "Ctrl Shift Z", false, document.redo.has_value())) session_.redo();
    if (ImGui::MenuItem("Refine", "R")) session_.refineClay();
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Show")) {
    ImGui::MenuItem("Panels", "Tab", &settings_.show_panels);
    ImGui::MenuItem("Control cage", "G", &settings_.show_cage);
    ImGui::MenuItem("Data points", "P", &settings_.show_points);
    ImGui::MenuItem("Voxels", "V", &settings_.show_voxels, session_.hasRecording());
    ImGui::MenuItem("Skeleton", "B", &settings_.show_skeleton);
    ImGui::MenuItem("Cameras", "C", &settings_.show_cameras);
    ImGui::EndMenu();
  }
  wishes.help = ImGui::MenuItem("Help  F1");
  const std::string name = document.file.stem().string();
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  ImGui::SameLine((ImGui::GetIO().DisplaySize.x - width) / 2);
  ImGui::TextDisabled("%s", name.c_str());
  ImGui::EndMainMenuBar();
}

void Panels::drawTools(const DocumentView& document) {
  ImGui::SetNextWindowPos(ImVec2(kMargin, menu_height_ + kMargin));
  ImGui::Begin("Sculpt", nullptr, kPanel);
  const float em = ImGui::GetFontSize();
  const ImVec2 third(em * 4.2f, em * 2.4f);
  const struct {
    Tool tool;
    const char *label, *tip;
  } tools[] = {{Tool::kPush, "Push", "The clay gives way to the hand  (1)"},
               {Tool::kPull, "Pull", "Touched clay sticks to the hand and follows it  (2)"},
               {Tool::kSmooth, "Smooth", "Clay near the hand relaxes  (3)"}};
  for (const auto& [tool, label, words] : tools) {
    if (tool != Tool::kPush) ImGui::SameLine();
    if (toggle(label, settings_.tool == tool, third)) settings_.tool = tool;
    tip(words);
  }
  ImGui::TextDisabled("Symmetry");
  const struct {
    bool& on;
    const char *label, *tip;
  } planes[] = {{settings_.symmetry.x, "x", "Left and right alike  (X)"},
                {settings_.symmetry.y, "y", "Front and back alike  (Y)"},
                {settings_.symmetry.z, "z", "Top and bottom alike"}};
  for (const auto& [on, label, words] : planes) {
    if (&on != &settings_.symmetry.x) ImGui::SameLine();
    if (toggle(label, on, ImVec2(third.x, em * 1.8f))) on = !on;
    tip(words);
  }
  ImGui::TextDisabled("Clutch");
  const float half = (3 * third.x + ImGui::GetStyle().ItemSpacing.x) / 2;
  if (toggle("On touch", settings_.clutch == Clutch::kContact, ImVec2(half, em * 1.8f)))
    settings_.clutch = Clutch::kContact;
  tip("Whatever the hand touches, it shapes");
  ImGui::SameLine();
  if (toggle("Hold a key", settings_.clutch == Clutch::kHold, ImVec2(half, em * 1.8f)))
    settings_.clutch = Clutch::kHold;
  tip("Only while the space bar or a pedal is down");
  ImGui::Checkbox("Steady hand", &settings_.steady);
  tip("A hand at rest does not tremble; costs a few milliseconds");
  ImGui::Separator();
  const ImVec2 pair(half, em * 1.9f);
  if (ImGui::Button("Undo", pair)) session_.undo();
  tip(document.undo ? document.undo->c_str() : "nothing to undo");
  ImGui::SameLine();
  if (ImGui::Button("Redo", pair)) session_.redo();
  tip(document.redo ? document.redo->c_str() : "nothing to redo");
  drawForm(document);
  if (ImGui::CollapsingHeader("Show")) drawShown();
  ImGui::End();
}

void Panels::drawForm(const DocumentView& document) {
  if (!ImGui::CollapsingHeader("Clay")) return;
  ImGui::Text("%d control points, %d on the surface", document.control_points, document.data_points);
  int levels = document.levels;
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 6);
  if (ImGui::InputInt("level", &levels, 1, 1)) {
    levels = std::clamp(levels, 1, 6);
    if (levels != document.levels) session_.setForm(levels, document.rule, document.solve);
  }
  tip("How often the cage is subdivided");
  int rule = document.rule == SubdivisionRule::kPrinted, solve = document.solve == SolveRows::kTouched;
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9);
  if (ImGui::Combo("rule", &rule, "Catmull-Clark\0as printed\0"))
    session_.setForm(document.levels, rule ? SubdivisionRule::kPrinted : SubdivisionRule::kCatmullClark,
                     document.solve);
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9);
  if (ImGui::Combo("solve", &solve, "all points\0touched points\0"))
    session_.setForm(document.levels, document.rule, solve ? SolveRows::kTouched : SolveRows::kAll);
  if (ImGui::Button("Refine")) session_.refineClay();
  tip("A finer cage under the same surface, to add detail  (R)");
}

void Panels::drawShown() {
  ImGui::Checkbox("control cage", &settings_.show_cage);
  ImGui::Checkbox("data points", &settings_.show_points);
  if (session_.hasRecording()) ImGui::Checkbox("voxels", &settings_.show_voxels);
  ImGui::Checkbox("skeleton", &settings_.show_skeleton);
  ImGui::Checkbox("cameras", &settings_.show_cameras);
}

void Panels::drawStatus(const Snapshot& snapshot, const Stage& stage, const Meter& meter) {
  const float width = ImGui::GetIO().DisplaySize.x;
  ImGui::SetNextWindowPos(ImVec2(width - kMargin, menu_height_ + kMargin), ImGuiCond_Always, ImVec2(1, 0));
  ImGui::Begin("Hand", nullptr, kPanel);
  const TrustWords trust = snapshot.learning ? TrustWords{"learning the empty workspace", look::kFaint}
                           : snapshot.ended  ? TrustWords{"the recording has ended", look::kFaint}
                                             : wordsFor(snapshot.trust);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float em = ImGui::GetFontSize();
  ImGui::GetWindowDrawList()->AddCircleFilled(ImVec2(at.x + em * 0.4f, at.y + em * 0.55f), em * 0.34f,
                                              trust.color);
  ImGui::Dummy(ImVec2(em * 0.9f, em));
  ImGui::SameLine();
  ImGui::TextUnformatted(trust.word);
  ImGui::Text("%.0f pictures a second, %.0f frames tracked", meter.pictureHz(), snapshot.rate_hz);
  ImGui::Text("%.0f ms from camera to picture", meter.latencyMs());
  if (session_.hasRecording()) {
    const HandFit& fit = snapshot.result.fit;
    if (fit.tracked) ImGui::Text("%.0f %% of the skin outside the hull", 100 * fit.outside_fraction);
    drawStages(snapshot);
  }
  if (settings_.show_graph && meter.history().size() > 1) {
    const std::vector<float> values(meter.history().begin(), meter.history().end());
    const float highest = std::max(120.0f, 1.1f * *std::max_element(values.begin(), values.end()));
    ImGui::PlotLines("##latency", values.data(), static_cast<int>(values.size()), 0, nullptr, 0, highest,
                     ImVec2(Session::kThumbnailWidth - 2 * ImGui::GetStyle().WindowPadding.x, em * 3.5f));
    tip("Milliseconds from camera to picture, over the last frames");
  }
  status_bottom_ = ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
  ImGui::End();
  if (session_.hasRecording()) drawCameras(snapshot, stage);
}

void Panels::drawStages(const Snapshot& snapshot) {
  std::string words = "decode " + fixed(snapshot.decode_ms, 1);
  for (const auto& [name, ms] : snapshot.result.stage_ms) words += ", " + name + " " + fixed(ms, 1);
  if (settings_.steady && snapshot.result.fit.tracked) words += ", steady " + fixed(snapshot.steady_ms, 0);
  const float top = ImGui::GetCursorPosY();
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + Session::kThumbnailWidth -
                         2 * ImGui::GetStyle().WindowPadding.x);
  ImGui::TextDisabled("%s ms", words.c_str());
  ImGui::PopTextWrapPos();
  // always three lines high, or what is below would jump with every digit
  ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(),
                                top + 3 * ImGui::GetTextLineHeight() + ImGui::GetStyle().ItemSpacing.y));
}

/// The pictures themselves lie under the interface, so this panel has no ground of its own.
void Panels::drawCameras(const Snapshot& snapshot, const Stage& stage) {
  const std::vector<Camera>& cameras = session_.rig().cameras;
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  constexpr auto width = static_cast<float>(Session::kThumbnailWidth);
  const float left = window.x - kMargin - width;
  float top = status_bottom_ + kMargin;
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const int height = session_.thumbnailHeight(c);
    if (top + static_cast<float>(height) > window.y - kMargin) break;  // as many as there is room for
    insets_.push_back({&session_.thumbnails(), session_.thumbnailStart(c), Session::kThumbnailWidth, height,
                       static_cast<int>(left), static_cast<int>(top)});
    if (snapshot.result.fit.tracked) {
      const float scale = width / static_cast<float>(cameras[c].width);
      for (const auto& [a, b] : stage.outline(c, snapshot.result.fit.world_from_hand))
        draw->AddLine(ImVec2(left + scale * float(a.x()), top + scale * float(a.y())),
                      ImVec2(left + scale * float(b.x()), top + scale * float(b.y())), 0xFFFFFFFFu, 1.2f);
    }
    draw->AddText(ImVec2(left + 6, top + 3), 0xE0FFFFFFu, cameras[c].name.c_str());
    top += static_cast<float>(height) + 4;
  }
}

void Panels::drawHint(const Snapshot& snapshot, const Stage& stage) {
  std::string words;
  if (stage.gapMetres()) {
    const double gap_mm = 1000 * *stage.gapMetres();
    words = gap_mm > 0.5 ? fixed(gap_mm, 0) + " mm to the clay" : "touching";
  } else if (!session_.hasRecording() && !snapshot.world_from_hand) {
    words = "Drag to bring the hand in; F1 shows all keys";
  }
  if (words.empty()) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y - kMargin), ImGuiCond_Always, ImVec2(0.5f, 1));
  ImGui::Begin("##hint", nullptr, kPanel | ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
  ImGui::TextUnformatted(words.c_str());
  ImGui::End();
}

}  // namespace airclay
