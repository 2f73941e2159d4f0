// SPDX-License-Identifier: MIT
// Tracks frames and sculpts the clay on its own thread; commits every stroke to the document.
//
// The window's thread reads snapshots, draws the clay from its device buffers, and posts commands.
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

/// How certain the hand's pose is.
enum class TrackingState {
  kNoHand,  ///< no hand in view
  kTracking,
  kUncertain,  ///< the pose is doubtful: sculpting pauses
  kLost,
};

/// When the hand sculpts.
enum class Clutch {
  kContact,  ///< whenever it touches the clay
  kHold,     ///< only while a key or pedal is down
};

/// The hand that mouse and keys move.
struct MouseHand {
  HandPose pose;
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

/// The state after a frame, for the window.
struct Snapshot {
  std::uint64_t serial = 0;        ///< of the frame; 0: none yet
  int frame = 0, frame_count = 0;  ///< 0: unknown, with live cameras
  double time_s = 0;
  bool learning = false;  ///< learning the background
  bool ended = false;     ///< the take has ended
  bool silent = false;    ///< live cameras give no images
  TrackingState trust = TrackingState::kNoHand;
  std::vector<HandPose> hands;  ///< the tracked hands' poses as drawn; the first one sculpts
  FrameResult result;
  StageTimes stage_ms;  ///< of the last frames that were timed
  double decode_ms = 0;
  std::optional<double> filter_lag_ms;       ///< the filter's lag; meaningless for a hand at rest
  std::optional<double> skew_s;              ///< between the cameras; nullopt without timestamps
  std::vector<std::string> camera_problems;  ///< problems of the cameras
  Clock::time_point captured_at;
  double rate_hz = 0;             ///< frames processed in the last second
  std::uint64_t clay_serial = 0;  ///< changes when the clay may have moved
  std::vector<vec3> clay_points;  ///< a uniform sample of its data points; workspace frame
  bool sculpting = false;         ///< a stroke is under way
  bool grip_barred = false;       ///< the clutch must be pressed anew: the hand was lost while it pulled
  /// On the device, the clay is in its own frame.
  Pose workspace_from_clay = Pose::Identity();
};

/// A long task, for a progress bar.
struct TaskStatus {
  std::string what;  ///< "refining"; empty: no task
  double share = 0;  ///< fraction of the current step
  Clock::time_point since;
};

/// A recording to replay.
struct Replay {
  std::filesystem::path folder;
  Actions actions;
};

/// The document's properties, for menus.
struct DocumentView {
  std::filesystem::path file;  ///< empty: an unsaved document
  std::optional<std::string> undo, redo;
  int undo_count = 0, redo_count = 0;
  int levels = 0, control_points = 0, data_points = 0;
  SubdivisionRule rule = SubdivisionRule::kCatmullClark;
  const SolveMethod* solve = &kSolveAll;
};

class Session {
 public:
  struct Options {
    Recording* recording = nullptr;  ///< null: the mouse hand; must outlive the session
    Rig rig;
    HandModel hand;
    PipelineOptions pipeline;
    std::string hand_name = "right";  ///< or left, or its file; stored in recordings
    std::filesystem::path record;     ///< new folder to record to, from the first frame on
    SessionSettings settings;         ///< until set() is called
    const Replay* replay = nullptr;   ///< `recording` plays its take; null with the mouse hand
    bool headless = false;            ///< run without pacing; stop at the recording's end or the first error
    /// Called on the session's thread after every frame, and once at the end without a frame.
    std::function<void(Pipeline&, const PlayedFrame*)> on_frame;
    std::function<void()> wake;  ///< called from the session's thread when there is a new snapshot
  };

  /// `document` holds the clay.
  Session(Gpu& gpu, const Options& options, Document document);
  /// Ends and commits the current stroke.
  ~Session();

  // --- the window's thread ---
  Snapshot snapshot() const;
  /// Reports that the image of this snapshot is submitted or skipped, so that the next frame may start.
  /// Otherwise the next frame, on the same queue, would run before the image.
  void renderSubmitted(std::uint64_t serial);
  DocumentView documentView() const;
  /// Messages to show once: what a command did, or why it failed.
  std::vector<std::string> takeMessages();
  void set(const SessionSettings& settings);
  void setMouseHand(const MouseHand& hand);
  bool hasRecording() const { return options_.recording != nullptr; }
  bool isLive() const { return hasRecording() && options_.recording->isLive(); }
  bool pipelineFailed() const { return failed_; }
  bool replaying() const { return options_.replay != nullptr; }
  RecorderView recorderView() const;
  TaskStatus taskStatus() const;
  /// Cancels the current task, if it can be cancelled, without any change.
  void cancelTask() { cancel_task_ = true; }
  /// Waits for the end. \pre headless. Rethrows the error that ended it.
  void finish();

  /// Records sets, actions and the clay to a new folder from now on. Tracking restarts, as it will in the
  /// replay.
  void startRecording(const std::filesystem::path& folder);
  void stopRecording();
  void undo();
  void redo();
  void refineClay();
  /// Replaces the cage by a new one of even quads for the same surface; overlapping lobes fuse.
  void remeshClay();
  void setSurface(int levels, SubdivisionRule rule, const SolveMethod* solve);
  /// Rotates the clay about an axis through the workspace's center; the last call commits it.
  void turn(const Vec3& axis, double angle_rad, bool last);
  void exportMesh(const std::filesystem::path& file, bool surface);
  void importCage(const std::filesystem::path& file);
  void saveAs(const std::filesystem::path& file);
  void openDocument(const std::filesystem::path& file);
  void replaceClay(const ClayState& state, const std::string& name);
  void restartTake();
  /// With live cameras, learns the background again from the next sets.
  void relearnBackground();
  void pauseTake(bool paused);

  /// Calls `look` with the clay on the device and its structure; `look` must submit everything that it
  /// records.
  struct ClayOnDevice {
    const Clay& clay;
    const ClayState& structure;  ///< only the topology: its points are outdated
    std::uint64_t structure_serial;
  };
  void withClay(const std::function<void(const ClayOnDevice&)>& look) const;
  /// Thumbnails of the cameras, silhouettes tinted: B G R A, in two sizes; two small ones are as wide as a
  /// large one.
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
  /// Whether to compute the voxel model in every frame, and of the current one at once.
  void keepHull(bool keep);

 private:
  void run();
  class Working;
  struct Cancelled {};  ///< thrown when the user cancels a task
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
  void filterPoses(Snapshot& next);
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
  ClayState clay_structure_;  ///< structure of the pipeline's clay
  std::uint64_t structure_serial_ = 1;
  std::optional<FrameReader> reader_;
  FrameSet set_;
  StrokeRecorder strokes_;
  std::array<OneEuroPose, kMaxHands> pose_filters_;  ///< one per hand
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
  int still_to_learn_ = 0;         ///< number of further sets to learn the background from
  std::vector<FrameSet> learned_;  ///< stored for a recording that starts later; up to kKeptLearnedBytes
  std::size_t learned_bytes_ = 0;
  std::optional<SessionRecorder> recorder_;
  std::size_t replayed_mouse_frames_ = 0;
  Clock::time_point replay_began_;
  std::uint64_t serial_ = 0, clay_serial_ = 0;
  std::vector<vec3> clay_points_;
  Pose workspace_from_clay_ = Pose::Identity();

  mutable std::shared_mutex structure_;  ///< locked while the clay's buffers are used
  mutable std::mutex mutex_;             ///< guards the members below
  std::condition_variable render_submitted_;
  std::uint64_t submitted_serial_ = 0;  ///< of the last submitted image
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
