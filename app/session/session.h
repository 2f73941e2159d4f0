// SPDX-License-Identifier: MIT
// What goes on behind the window: frames are tracked and clay is sculpted on a thread of its own, every
// stroke goes into the document.
//
// The window's thread looks at snapshots, draws the clay from the buffers that it lies in, and posts
// commands.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <shared_mutex>

#include "app/session/frame_reader.h"
#include "app/session/session_recorder.h"
#include "app/session/stroke_recorder.h"
#include "capture/takes/player.h"
#include "engine/clay/document.h"
#include "engine/hand/one_euro.h"
#include "engine/pipeline.h"

namespace airclay {

/// How well the hand is known.
enum class TrackingState {
  kNoHand,  ///< nobody there
  kTracking,
  kUncertain,  ///< a pose, but a doubtful one: the clay does not move
  kLost,
};

/// When the clay is held still.
enum class Clutch {
  kContact,  ///< never: touching is sculpting
  kHold,     ///< but for while a key or pedal is down
};

/// The hand that mouse and keys move.
struct MouseHand {
  Pose world_from_hand = Pose::Identity();
  bool present = false;
};

struct SessionSettings {
  ToolChoice tool;
  Symmetry symmetry;
  Clutch clutch = Clutch::kContact;
  bool clutch_down = false;
  bool filtered = true;  ///< the One Euro filter

  /// Whether the clutch lets the hand shape the clay.
  bool held() const { return clutch == Clutch::kContact || clutch_down; }
};

/// The state of things after a frame, as the window shows it.
struct Snapshot {
  std::uint64_t serial = 0;        ///< of the frame; 0: none yet
  int frame = 0, frame_count = 0;  ///< of cameras that run there is no count: 0
  double time_s = 0;
  bool learning = false;  ///< the empty workspace
  bool ended = false;     ///< of the take
  bool silent = false;    ///< cameras that run give no images
  TrackingState trust = TrackingState::kNoHand;
  std::optional<Pose> world_from_hand;  ///< as it sculpts
  FrameResult result;
  StageTimes stage_ms;  ///< of the last frames that were timed
  double decode_ms = 0;
  std::optional<double> filter_lag_ms;       ///< the filter's lag; of a hand at rest it means nothing
  std::optional<double> skew_s;              ///< the cameras'; none where they have no times of their own
  std::vector<std::string> camera_problems;  ///< what is wrong with the cameras
  Clock::time_point captured_at;
  double rate_hz = 0;             ///< frames that went through in the last second
  std::uint64_t clay_serial = 0;  ///< another one when the clay may have moved
  std::vector<vec3> clay_points;  ///< some of its data points, spread evenly; workspace frame
  bool sculpting = false;         ///< a stroke is under way
  bool grip_barred = false;       ///< the clutch must be pressed anew: the hand was lost while it pulled
  /// A turn: on the device the clay lies in its own frame.
  Pose workspace_from_clay = Pose::Identity();
};

/// Work that takes long, for a bar.
struct TaskStatus {
  std::string what;  ///< "refining"; empty: there is none
  double share = 0;  ///< of the step under way
  Clock::time_point since;
};

/// What was recorded, to be done again.
struct Replay {
  std::filesystem::path folder;
  Actions actions;
};

/// What the document is like, for menus.
struct DocumentView {
  std::filesystem::path file;  ///< empty: kept as an unsaved one
  std::optional<std::string> undo, redo;
  int undo_count = 0, redo_count = 0;
  int levels = 0, control_points = 0, data_points = 0;
  SubdivisionRule rule = SubdivisionRule::kCatmullClark;
  const SolveMethod* solve = &kSolveAll;
};

class Session {
 public:
  struct Options {
    Recording* recording = nullptr;  ///< none: the mouse's hand; must outlive the session
    Rig rig;
    HandModel hand;
    int voxels = 128;
    std::string hand_name = "right";  ///< or left, or its file: what a recording notes
    std::filesystem::path record;     ///< a new folder: everything is recorded from the first frame on
    SessionSettings settings;         ///< until set() is called
    const Replay* replay = nullptr;   ///< `recording` is its take's; none of the mouse's hand
    bool headless = false;  ///< as fast as it goes; ends with the recording, and with the first fault
    /// Called after every frame of the recording, on the session's own thread, and once at its end, without a
    /// frame.
    std::function<void(const Pipeline&, const PlayedFrame*)> on_frame;
    std::function<void()> wake;  ///< called from the session's thread when there is a new snapshot
  };

  /// `document` holds the clay.
  Session(Gpu& gpu, const Options& options, Document document);
  /// Ends the stroke under way, so that it is kept.
  ~Session();

  // --- the window's thread ---
  Snapshot snapshot() const;
  /// The image of this snapshot is on its way, or there is none to come: the next frame may begin. Until
  /// then the recording's next one waits a little: on one queue, it would be done before the image.
  void renderSubmitted(std::uint64_t serial);
  DocumentView documentView() const;
  /// Lines to be shown once: what a command did, or why it could not.
  std::vector<std::string> takeMessages();
  void set(const SessionSettings& settings);
  void setMouseHand(const MouseHand& hand);
  bool hasRecording() const { return options_.recording != nullptr; }
  bool isLive() const { return hasRecording() && options_.recording->isLive(); }
  bool pipelineFailed() const { return failed_; }
  bool replaying() const { return options_.replay != nullptr; }
  RecorderView recorderView() const;
  TaskStatus taskStatus() const;
  /// Ends the work under way, if it is some that can be; everything is as before.
  void cancelTask() { cancel_task_ = true; }
  /// \pre headless: waits for the end. \throw what ended it
  void finish();

  /// Everything from here on goes into a new folder: sets, deeds, the clay. The hand is looked for anew, as
  /// it will be when that is played.
  void startRecording(const std::filesystem::path& folder);
  void stopRecording();
  void undo();
  void redo();
  void refineClay();
  void setSurface(int levels, SubdivisionRule rule, const SolveMethod* solve);
  /// Turns the clay about an axis through the workspace's centre; `name` is the entry's once it is done.
  void turn(const Vec3& axis, double angle_rad, bool last);
  void exportMesh(const std::filesystem::path& file, bool surface);
  void importCage(const std::filesystem::path& file);
  void saveAs(const std::filesystem::path& file);
  void openDocument(const std::filesystem::path& file);
  void replaceClay(const ClayState& state, const std::string& name);
  void restartTake();
  /// Of cameras that run: the next sets show the empty workspace, which has changed.
  void relearnBackground();
  void pauseTake(bool paused);

  /// The clay as it lies on the device, and its form; `look` must submit all that it records before it
  /// returns.
  struct ClayOnDevice {
    const Clay& clay;
    const ClayState& structure;  ///< its cage's points are those of long ago
    std::uint64_t structure_serial;
  };
  void withClay(const std::function<void(const ClayOnDevice&)>& look) const;
  /// Small images of the cameras, silhouettes tinted: B G R A, in two sizes of which two small ones stand
  /// beside each other where a large one would.
  const Buffer<std::uint32_t>& thumbnails() const { return thumbnails_; }
  struct Thumbnail {
    std::size_t first = 0;      ///< of thumbnails()
    int width = 0, height = 0;  ///< pixels
  };
  const Thumbnail& thumbnail(std::size_t camera, bool small) const {
    return thumbnail_places_[small][camera];
  }
  static constexpr int kThumbnailWidth = 240, kThumbnailGap = 4;
  const Rig& rig() const { return options_.rig; }
  const HandModel& hand() const { return options_.hand; }
  const Carver& carver() const;

 private:
  void run();
  class Working;
  struct Cancelled {};  ///< thrown: the person gave up on work under way
  void post(std::function<void()> command);
  void act(const Action& action, const std::string& what = "");
  void perform(const Action& action);
  void replayAction(const Action& action);
  void changeSurface(const Action& action);
  void turnClay(const Action& action);
  void resetTracking();
  bool learn();
  void replaceClayWith(const ClayState& state, const std::string& name);
  void replaceDocumentWith(Document opened);
  void refuseWhileReplaying() const;
  void beginRecording(const std::filesystem::path& folder);
  void endRecording();
  void showRecorder();
  void recordAction(const Action& action);
  void recordFrame(const ReplayFrame& done, const FrameSet* set);
  ReplayFrame currentInputs(double time_s, double step_s) const;
  const ReplayFrame* replayedFrame(int frame);
  void endOfTake();
  bool processCommands();
  bool frameFromRecording();
  void showSilence();
  bool frameFromMouse();
  bool frameFromReplayedMouse();
  void workOnMouseFrame(ReplayFrame done);
  void copyImages(const FrameSet& set);
  bool gripIsBarred(const Snapshot& next);
  void sculpt(Snapshot& next, const ReplayFrame& done);
  void follow(const Snapshot& next, const ReplayFrame& done);
  void endStroke();
  void show(const ClayState& state);
  void commit(const std::string& name, const ClayState& state);
  std::unique_ptr<Pipeline::PreparedClay> made(const ClayState& state);
  void show(const ClayState& state, std::unique_ptr<Pipeline::PreparedClay> made);
  void publish(Snapshot next);
  void waitForRender(std::uint64_t serial);
  void updateClayView(Snapshot& next, bool moved);
  void refreshDocumentView();
  void placeThumbnails();
  void drawThumbnails(const FrameSet& set);
  void drawThumbnail(const Thumbnail& to, std::size_t camera, const std::vector<std::uint8_t>& bytes);
  void note(const std::string& text);
  void guarded(const std::function<void()>& work);

  Gpu& gpu_;
  Options options_;
  Pipeline pipeline_;
  Document document_;
  ClayState clay_structure_;  ///< of the pipeline's clay
  std::uint64_t structure_serial_ = 1;
  std::optional<FrameReader> reader_;
  FrameSet set_;
  StrokeRecorder strokes_;
  OneEuroPose pose_filter_;
  Buffer<std::uint32_t> thumbnails_;
  std::array<std::vector<Thumbnail>, 2> thumbnail_places_;
  std::deque<Clock::time_point> frame_times_;
  StageTimes stage_ms_;
  Clock::time_point thumbnails_at_{};
  double last_frame_s_ = -1;
  bool background_learned_ = false, turning_ = false;
  /// Of one press of the clutch, pulling: the hand has been seen, and was lost.
  enum class Grip { kFree, kSeen, kBarred };
  Grip grip_ = Grip::kFree;
  int learned_frames_ = 0;
  int still_to_learn_ = 0;         ///< of cameras that run: so many sets more show the empty workspace
  std::vector<FrameSet> learned_;  ///< kept for a recording that begins later; up to kKeptLearnedBytes
  std::size_t learned_bytes_ = 0;
  std::optional<SessionRecorder> recorder_;
  std::size_t replayed_mouse_frames_ = 0;
  Clock::time_point replay_began_;
  std::uint64_t serial_ = 0, clay_serial_ = 0;
  std::vector<vec3> clay_points_;
  Pose workspace_from_clay_ = Pose::Identity();

  mutable std::shared_mutex structure_;  ///< the clay's buffers stay while it is held
  mutable std::mutex mutex_;             ///< of what follows
  std::condition_variable render_submitted_;
  std::uint64_t submitted_serial_ = 0;  ///< of the last image
  Snapshot snapshot_;
  DocumentView document_view_;
  std::vector<std::string> notes_;
  SessionSettings settings_;
  MouseHand mouse_hand_;
  std::deque<std::function<void()>> commands_;
  RecorderView recorder_view_;
  TaskStatus task_status_;
  std::exception_ptr fault_;  ///< headless
  std::atomic<bool> stop_ = false, failed_ = false, cancel_task_ = false;
  std::thread thread_;
};

}  // namespace airclay
