// SPDX-License-Identifier: MIT
#include "app/studio/studio.h"

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/session/tracking_summary.h"
#include "app/studio/file_chooser.h"
#include "app/studio/panels.h"
#include "app/studio/shortcuts.h"
#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/mesh/cage_file.h"

namespace airclay {
namespace {

constexpr double kNoteSeconds = 4;
constexpr double kSettingsSeconds = 2;  // a crash loses at most this much
constexpr double kTurnRadS = 1.2;       // rotation speed of the clay and the mouse hand
constexpr double kMovingSeconds = 0.5;  // after the last frame, key or mouse
constexpr double kQuietFrameS = 0.2;    // between images without changes
constexpr double kMovingFrameS = 1.0 / 60;
// While frames arrive, each triggers an image; additional images would only delay them.
constexpr double kFlowingS = 0.15, kFlowingFrameS = 0.1;

/// Resident memory of this process.
double residentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  long pages = 0, resident = 0;
  statm >> pages >> resident;
  return static_cast<double>(resident) * 4096 / 1e6;
}

const char* nameOf(TrackingState trust) {
  constexpr const char* kNames[] = {"nobody", "tracking", "uncertain", "lost"};
  return kNames[static_cast<int>(trust)];
}

}  // namespace

class Studio {
 public:
  Studio(Gpu& gpu, const Session::Options& session, Document document, const StudioOptions& options)
      : options_(options),
        settings_(loadSettings()),
        remembered_(settings_),
        gpu_(gpu),
        window_(gpu, {options.title, settings_.window_width, settings_.window_height}),
        session_(gpu, waking(session), std::move(document)),
        viewport_(gpu, session_, options.forearm),
        panels_(session_, settings_),
        view_(session.rig.workspace.edge_m),
        recorder_(gpu),
        timed_frames_(gpu, 0) {
    if (!options.log.file.empty()) log_.open(options.log.file);
    settings_.folder = settings_.folder.empty() ? std::filesystem::current_path() : settings_.folder;
    show_help_ = settings_.first_run;
    settings_.first_run = false;
    bindKeys();
    if (const auto taken = meaningOf(keys_, settings_.clutch_key)) {
      notes_.push_back({"Clutch key reset to Space: " + keyName(settings_.clutch_key) + " is already used (" +
                            *taken + ")",
                        Clock::now()});
      settings_.clutch_key = StudioSettings().clutch_key;
      bindKeys();
    }
    mouse_hand_.pose.world_from_hand.translation() =
        session.rig.workspace.center + Vec3(0, -0.35 * session.rig.workspace.edge_m, 0);
  }

  void run() {
    while (!window_.closing()) {
      if (session_.pipelineFailed()) break;
      window_.poll(secondsToFrame(session_.snapshot()));
      const Snapshot snapshot = session_.snapshot();  // a new frame may have arrived during the wait
      const bool waits = framesFlow() || !window_.inUse();
      if (waits && secondsToFrame(snapshot) > 0 && !window_.closing()) continue;
      for (const std::filesystem::path& file : window_.takeDropped()) openDropped(file);
      drawImage(snapshot);
      writeLog(snapshot);
      if (secondsBetween(settings_at_, Clock::now()) > kSettingsSeconds) rememberSettings();
      if (snapshot.ended && options_.close_at_end) window_.close();
    }
    rememberSettings();
    for (const std::string& note : session_.takeMessages()) {
      if (session_.pipelineFailed()) throw Error(note, Fault::kDevice);
      printWarning(note);
    }
  }

 private:
  /// New frames wake the window.
  static Session::Options waking(Session::Options session) {
    session.wake = [] { glfwPostEmptyEvent(); };
    return session;
  }

  struct Note {
    std::string text;
    Clock::time_point since;
  };

  /// Seconds until the next image: one per new frame and during input, and occasionally otherwise.
  double secondsToFrame(const Snapshot& snapshot) const {
    const bool new_frame = session_.hasRecording() && snapshot.serial != drawn_serial_;
    if (new_frame) return 0;
    const double interval = framesFlow() ? kFlowingFrameS : moving() ? kMovingFrameS : kQuietFrameS;
    return std::clamp(interval - secondsBetween(last_image_, Clock::now()), 0.0, interval);
  }
  bool framesFlow() const { return secondsBetween(last_frame_, Clock::now()) < kFlowingS; }
  bool moving() const { return secondsBetween(last_change_, Clock::now()) < kMovingSeconds; }

  void drawImage(const Snapshot& snapshot) {
    const Window::Begun begun = window_.begin(framesFlow());
    if (begun == Window::Begun::kNothing) {
      session_.renderSubmitted(snapshot.serial);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));  // minimised
      return;
    }
    if (begun == Window::Begun::kInterface) drawInterface(snapshot);
    last_image_ = Clock::now();
    session_.withClay([&](const Session::ClayOnDevice& clay) {
      recorder_.begin(timed_frames_.next());
      viewport_.record(recorder_, clay, snapshot, settings_,
                       {view_.view(), window_.width(), window_.height(), moving()});
      window_.draw(recorder_, viewport_.image(), panels_.insets());
    });
    session_.renderSubmitted(snapshot.serial);
    window_.show(recorder_);
    renewStages(recorder_.stageMs(), render_ms_);
    std::optional<double> latency_ms;
    if (snapshot.serial != drawn_serial_ && !snapshot.hands.empty())
      latency_ms = 1000 * secondsBetween(snapshot.captured_at, Clock::now());
    if (session_.hasRecording() && snapshot.serial != drawn_serial_)
      last_change_ = last_frame_ = Clock::now();
    drawn_serial_ = snapshot.serial;
    meter_.shown(latency_ms);
  }

  void drawInterface(const Snapshot& snapshot) {
    takeInput(std::min(secondsBetween(last_image_, Clock::now()), 0.1));
    const PanelRequests requests = panels_.draw(snapshot, viewport_, meter_);
    grant(requests);
    chooser_.draw();
    if (show_help_) show_help_ = drawHelp(keys_);
    drawNotes();
  }

  // --- input ---

  void bindKeys() {
    const auto key = [](int code, const char* shown, const char* does, std::function<void()> act) {
      return KeyBinding{code, false, false, shown, does, std::move(act), false, {}};
    };
    const auto ctrl = [](int code, bool shift, const char* shown, const char* does, std::function<void()> act,
                         bool repeats = false) {
      return KeyBinding{code, true, shift, shown, does, std::move(act), repeats, {}};
    };
    const auto shown_only = [](const std::string& shown, const char* does, std::vector<int> held = {}) {
      return KeyBinding{0, false, false, shown, does, {}, false, std::move(held)};
    };
    keys_ = {{"Sculpt",
              {shown_only(keyName(settings_.clutch_key), "Clutch (hold)"),
               key(GLFW_KEY_X, "X", "Mirror left and right", [this] { settings_.symmetry.x ^= true; }),
               key(GLFW_KEY_Y, "Y", "Mirror front and back", [this] { settings_.symmetry.y ^= true; }),
               shown_only("Arrows", "Rotate the clay",
                          {GLFW_KEY_LEFT, GLFW_KEY_RIGHT, GLFW_KEY_UP, GLFW_KEY_DOWN}),
               key(GLFW_KEY_R, "R", "Refine the cage", [this] { session_.refineClay(); }),
               key(GLFW_KEY_M, "M", "Remesh: even quads, lobes fuse", [this] { session_.remeshClay(); })}},
             {"Edit and file",
              {ctrl(
                   GLFW_KEY_Z, false, "Ctrl Z", "Undo", [this] { session_.undo(); }, true),
               ctrl(
                   GLFW_KEY_Z, true, "Ctrl Shift Z", "Redo", [this] { session_.redo(); }, true),
               ctrl(
                   GLFW_KEY_Y, false, "Ctrl Y", "Redo", [this] { session_.redo(); }, true),
               ctrl(GLFW_KEY_O, false, "Ctrl O", "Open a document", [this] { askOpen(); }),
               ctrl(GLFW_KEY_S, false, "Ctrl S", "Save as (every edit is saved automatically)",
                    [this] { askSave(); }),
               ctrl(GLFW_KEY_E, false, "Ctrl E", "Export", [this] { askExport(true); }),
               ctrl(GLFW_KEY_R, false, "Ctrl R", "Start or stop recording", [this] { recordOrStop(); }),
               shown_only("Esc", "Cancel the running task"),
               ctrl(GLFW_KEY_Q, false, "Ctrl Q", "Quit", [this] { window_.close(); })}},
             {"Navigate",
              {shown_only("Right drag", "Orbit"), shown_only("Middle drag", "Pan"),
               shown_only("Wheel", "Zoom"), key(GLFW_KEY_5, "5", "Front view", [this] { view_.front(); }),
               key(GLFW_KEY_6, "6", "Side view", [this] { view_.side(); }),
               key(GLFW_KEY_7, "7", "Top view", [this] { view_.top(); }),
               key(GLFW_KEY_F, "F", "Frame the clay",
                   [this] { view_.fit(viewport_.clayCenter(), viewport_.clayRadius()); }),
               key(GLFW_KEY_HOME, "Home", "Reset the view", [this] { view_.reset(); })}},
             {"View",
              {key(GLFW_KEY_G, "G", "Control cage", [this] { settings_.show_cage ^= true; }),
               key(GLFW_KEY_P, "P", "Data points", [this] { settings_.show_points ^= true; }),
               key(GLFW_KEY_V, "V", "Voxels", [this] { settings_.show_voxels ^= true; }),
               key(GLFW_KEY_B, "B", "Skeleton", [this] { settings_.show_skeleton ^= true; }),
               key(GLFW_KEY_C, "C", "Cameras", [this] { settings_.show_cameras ^= true; }),
               key(GLFW_KEY_TAB, "Tab", "Panels", [this] { settings_.show_panels ^= true; }),
               key(GLFW_KEY_F1, "F1", "This help", [this] { show_help_ = !show_help_; })}}};
    std::vector<KeyBinding> tool_keys;
    for (std::size_t i = 0; i < std::min(settings_.tools.size(), kToolKeys); ++i) {
      tool_keys.push_back(
          key(GLFW_KEY_1 + int(i), "", settings_.tools[i].tool().name, [this, i] { settings_.tool = i; }));
      tool_keys.back().shown = std::to_string(i + 1);
    }
    keys_.front().bindings.insert(keys_.front().bindings.begin(), tool_keys.begin(), tool_keys.end());
    if (session_.isLive())
      keys_.push_back({"Cameras",
                       {key(GLFW_KEY_E, "E", "Relearn the background (keep hand and arm out)",
                            [this] { session_.relearnBackground(); })}});
    else if (session_.hasRecording())
      keys_.push_back({"Recording",
                       {key(GLFW_KEY_BACKSPACE, "Backspace", "Restart", [this] { session_.restartTake(); }),
                        key(GLFW_KEY_PAUSE, "Pause", "Pause or resume",
                            [this] { session_.pauseTake(paused_ = !paused_); })}});
    else
      keys_.push_back(
          {"Mouse hand",
           {shown_only("Left drag", "Move"),
            shown_only("Shift wheel, W S", "Farther, nearer", {GLFW_KEY_W, GLFW_KEY_S}),
            shown_only("J L, I K, U O", "Rotate",
                       {GLFW_KEY_J, GLFW_KEY_L, GLFW_KEY_I, GLFW_KEY_K, GLFW_KEY_U, GLFW_KEY_O}),
            key(GLFW_KEY_H, "H", "Hide or show", [this] { mouse_hand_.present = !mouse_hand_.present; })}});
  }

  void takeInput(double step_s) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool mouse_moved = io.MouseDelta.x != 0 || io.MouseDelta.y != 0 || io.MouseWheel != 0;
    bool any_key = false;
    for (const bool down : io.KeysDown) any_key = any_key || down;
    if (mouse_moved || any_key || ImGui::IsAnyMouseDown()) last_change_ = Clock::now();
    if (!chooser_.isOpen() && !panels_.asksForKey()) obeyKeys(keys_);
    if (!io.WantCaptureMouse) takeMouse(io);
    if (!io.WantTextInput && !chooser_.isOpen()) takeHeldKeys(io, step_s);
    SessionSettings settings{settings_.tools[settings_.tool], settings_.symmetry, settings_.clutch, false,
                             settings_.filtered};
    settings.clutch_down = !io.WantTextInput && ImGui::IsKeyDown(settings_.clutch_key);
    session_.set(settings);
    if (settings_.show_voxels != hull_kept_) session_.keepHull(hull_kept_ = settings_.show_voxels);
    if (!session_.hasRecording()) session_.setMouseHand(mouse_hand_);
  }

  void takeMouse(const ImGuiIO& io) {
    const Vec2 drag(io.MouseDelta.x, io.MouseDelta.y);
    const bool has_hand = !session_.hasRecording();
    // in the first image of a press, pointer motion is not yet a drag
    const auto dragged = [&](int button) { return io.MouseDownDuration[button] > 0; };
    if (dragged(1) || (!has_hand && dragged(0))) view_.orbit(drag);
    if (dragged(2)) view_.pan(drag, window_.height());
    if (has_hand && io.KeyShift)
      mouse_hand_.pose.world_from_hand.pretranslate(0.01 * io.MouseWheel * view_.forward());
    else
      view_.zoom(io.MouseWheel);
    if (has_hand && ImGui::IsMouseDown(0)) mouse_hand_.present = true;
    if (has_hand && dragged(0)) {
      const double m = view_.metresAPixel(window_.height());
      mouse_hand_.pose.world_from_hand.pretranslate(m * (drag.x() * view_.right() - drag.y() * view_.up()));
    }
  }

  void takeHeldKeys(const ImGuiIO& io, double step_s) {
    const auto direction = [&](int more, int less) {
      if (io.KeyCtrl) return 0.0;
      return double(ImGui::IsKeyDown(more)) - double(ImGui::IsKeyDown(less));
    };
    const double about_up = direction(GLFW_KEY_RIGHT, GLFW_KEY_LEFT),
                 about_right = direction(GLFW_KEY_DOWN, GLFW_KEY_UP);
    const bool turning = about_up != 0 || about_right != 0;
    if (turning || turning_clay_) {
      const Vec3 axis =
          turning ? Vec3(about_up * Vec3::UnitZ() + about_right * view_.right()) : Vec3::UnitZ();
      session_.turn(axis.normalized(), turning ? kTurnRadS * step_s : 0, !turning);
      turning_clay_ = turning;
    }
    if (session_.hasRecording()) return;
    Pose& hand = mouse_hand_.pose.world_from_hand;
    hand.pretranslate(0.15 * step_s * direction(GLFW_KEY_W, GLFW_KEY_S) * view_.forward());
    const Vec3 turn = direction(GLFW_KEY_L, GLFW_KEY_J) * Vec3::UnitZ() +
                      direction(GLFW_KEY_K, GLFW_KEY_I) * view_.right() +
                      direction(GLFW_KEY_O, GLFW_KEY_U) * view_.forward();
    if (turn.norm() > 0)
      hand.linear() =
          Eigen::AngleAxisd(kTurnRadS * step_s, turn.normalized()).toRotationMatrix() * hand.linear();
  }

  // --- files ---

  void grant(const PanelRequests& requests) {
    if (requests.open) askOpen();
    if (requests.save_as) askSave();
    if (requests.export_surface || requests.export_cage) askExport(requests.export_surface);
    if (requests.import)
      chooser_.open("Import cage", settings_.folder, cageExtensions(), false,
                    [this](const std::filesystem::path& file) { remember(file), session_.importCage(file); });
    if (requests.help) show_help_ = true;
    if (requests.record) recordOrStop();
    if (requests.clutch_key != 0) chooseClutchKey(requests.clutch_key);
    if (!requests.new_clay.empty()) {
      ClayState state;
      state.cage = presetCage(requests.new_clay);
      for (Vec3& point : state.cage.points) point += session_.rig().workspace.center;
      session_.replaceClay(state, "New " + requests.new_clay);
    }
  }

  void recordOrStop() {
    if (session_.recorderView().recording) return session_.stopRecording();
    const std::time_t now = std::time(nullptr);
    char name[64];
    std::strftime(name, sizeof name, "recording-%Y%m%d-%H%M%S", std::localtime(&now));
    session_.startRecording(settings_.folder / name);
  }

  void chooseClutchKey(int key) {
    if (const std::optional<std::string> taken = meaningOf(keys_, key)) {
      if (key != GLFW_KEY_ESCAPE)
        notes_.push_back(
            {keyName(key) + " is already used: " + *taken + "; choose another key", Clock::now()});
      return;
    }
    settings_.clutch_key = key;
    bindKeys();  // updates the help overlay
  }

  void askOpen() {
    chooser_.open("Open a document", settings_.folder, {".clay"}, false,
                  [this](const std::filesystem::path& file) { remember(file), session_.openDocument(file); });
  }
  void askSave() {
    chooser_.open("Save as", settings_.folder, {".clay"}, true,
                  [this](const std::filesystem::path& file) { remember(file), session_.saveAs(file); });
  }
  void askExport(bool surface) {
    chooser_.open(surface ? "Export surface" : "Export cage", settings_.folder,
                  {".stl", ".obj", ".ply", ".glb"}, true, [this, surface](const std::filesystem::path& file) {
                    remember(file), session_.exportMesh(file, surface);
                  });
  }
  void remember(const std::filesystem::path& file) { settings_.folder = file.parent_path(); }

  void openDropped(const std::filesystem::path& file) {
    if (file.extension() == ".clay")
      session_.openDocument(file);
    else if (isCageFile(file))
      session_.importCage(file);
    else
      notes_.push_back(
          {file.filename().string() + ": not a document (.clay) or a cage (.obj, .ply, .stl, .gltf, .glb)",
           Clock::now()});
  }

  void drawNotes() {
    for (const std::string& text : session_.takeMessages()) notes_.push_back({text, Clock::now()});
    while (!notes_.empty() && secondsBetween(notes_.front().since, Clock::now()) > kNoteSeconds)
      notes_.pop_front();
    if (notes_.empty()) return;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos(ImVec2(size.x / 2, 3 * ImGui::GetFontSize()), ImGuiCond_Always, ImVec2(0.5f, 0));
    ImGui::Begin("##notes", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    for (const Note& note : notes_) ImGui::TextUnformatted(note.text.c_str());
    ImGui::End();
  }

  void rememberSettings() {
    std::tie(settings_.window_width, settings_.window_height) = window_.sizeOnScreen();
    settings_at_ = Clock::now();
    if (settings_ == remembered_) return;
    saveSettings(settings_);
    remembered_ = settings_;
  }

  void writeLog(const Snapshot& snapshot) {
    if (!log_.is_open() || secondsBetween(last_log_, Clock::now()) < options_.log.interval_s) return;
    last_log_ = Clock::now();
    const DocumentView document = session_.documentView();
    nlohmann::ordered_json stages;
    for (const auto& [name, ms] : snapshot.stage_ms) stages[name] = ms;
    for (const auto& [name, ms] : render_ms_) stages[name] = ms;
    using json = nlohmann::ordered_json;
    const json line = {{"image_hz", meter_.frameHz()},
                       {"tracking_hz", snapshot.rate_hz},
                       {"latency_ms", meter_.latencyMs()},
                       {"hand", nameOf(snapshot.trust)},
                       {"frame", snapshot.frame},
                       {"learning", snapshot.learning},
                       {"ended", snapshot.ended},
                       {"sculpting", snapshot.sculpting},
                       {"undo", document.undo_count},
                       {"redo", document.redo_count},
                       {"control_points", document.control_points},
                       {"data_points", document.data_points},
                       {"width", window_.width()},
                       {"height", window_.height()},
                       {"screen", window_.screenName()},
                       {"note", notes_.empty() ? "" : notes_.back().text},
                       {"recording", session_.recorderView().recording},
                       {"recorded_frames", session_.recorderView().frames},
                       {"working", session_.taskStatus().what},
                       {"clutch_key", keyName(settings_.clutch_key)},
                       {"grip_barred", snapshot.grip_barred},
                       {"cameras_shown", panels_.insets().size()},
                       {"resident_mb", residentMegabytes()},
                       {"longest_submission_ms", gpu_.takeLongestSubmissionMs()},
                       {"decode_ms", snapshot.decode_ms},
                       {"camera_problems", snapshot.camera_problems},
                       {"skew_ms", snapshot.skew_s ? json(1000 * *snapshot.skew_s) : json()},
                       {"filter_lag_ms", snapshot.filter_lag_ms ? json(*snapshot.filter_lag_ms) : json()},
                       {"stage_ms", stages}};
    log_ << line.dump() << std::endl;
  }

  StudioOptions options_;
  StudioSettings settings_, remembered_;
  Gpu& gpu_;
  Window window_;
  Session session_;
  Viewport viewport_;
  Panels panels_;
  ViewControl view_;
  Recorder recorder_;
  TimingPlan timed_frames_;
  StageTimes render_ms_;  ///< of the last timed images
  Meter meter_;
  FileChooser chooser_;
  std::vector<KeyGroup> keys_;
  MouseHand mouse_hand_;
  std::deque<Note> notes_;
  std::ofstream log_;
  bool show_help_ = false, turning_clay_ = false, paused_ = false;
  std::uint64_t drawn_serial_ = 0;
  bool hull_kept_ = false;  ///< by the session, for display
  Clock::time_point last_change_ = Clock::now(), last_image_ = Clock::now(), last_frame_{}, last_log_{},
                    settings_at_{};
};

void runStudio(Gpu& gpu, const Session::Options& session, Document document, const StudioOptions& options) {
  Studio(gpu, session, std::move(document), options).run();
}

}  // namespace airclay
