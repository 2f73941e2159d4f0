// SPDX-License-Identifier: MIT
// Reads several cameras, each on its own thread, and matches their frames by capture time
// (capture/takes/frame_matcher.h). If a camera fails, its status names the problem, and the others continue.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture/cameras/camera_source.h"
#include "engine/camera/rig.h"

namespace airclay {

/// One camera of LiveCameras.
struct LiveCamera {
  std::string name;
  /// Opens the source; called at the start, and to reopen a lost camera. \throw Error
  std::function<std::unique_ptr<CameraSource>()> open;
  /// Subtracted from the capture times: a network's delay, or the result of estimateClockOffsets().
  double offset_s = 0;
};
/// A camera that opens its source by openSource().
LiveCamera liveCamera(const NamedSource& camera, const SourceOptions& options = {}, double offset_s = 0);

struct LiveOptions {
  enum class Sets {
    kNewest,  ///< the newest set, skipping older ones; for sculpting
    kEvery,   ///< all sets in order; for recording
  };
  Sets sets = Sets::kNewest;
  /// The maximum difference between the times of a set's frames. Default: half a period of the slowest
  /// camera; for kEvery, a whole period, because a recording stores each frame's time.
  std::optional<double> max_skew_s;
  /// The minimum time for which a set waits for a late camera. It waits longer, up to 5 s, if a camera's
  /// images regularly take longer to arrive. Default: 0.1 s; for kEvery, 0.5 s.
  std::optional<double> patience_s;
};

/// The images of one instant.
struct LiveSet {
  std::vector<LiveImage> images;  ///< one per camera; empty if the camera is missing
  /// Capture times (camera_source.h) minus the cameras' offsets, one per camera; NaN if missing.
  std::vector<double> camera_times_s;
  double time_s = 0;             ///< the mean capture time
  double skew_s = 0;             ///< latest - earliest capture time
  bool complete = false;         ///< no camera is missing; an incomplete set has at least two images
  Clock::time_point arrived_at;  ///< when its last image was decoded
};

enum class CameraState {
  kLive,
  kLate,          ///< slower than 80 % of its rate, or behind the others
  kFrozen,        ///< no image for 0.5 s, or identical images for 2 s; its images are not used
  kLost,          ///< reading failed; reopening follows
  kReconnecting,  ///< being reopened, one attempt per second
  kEnded,         ///< its file has ended
};
/// "live", "late", "frozen", "lost", "reconnecting", "ended".
const char* nameOf(CameraState state);

struct CameraStatus {
  std::string name;
  CameraState state = CameraState::kLive;
  ImageSize size;
  double rate_hz = 0;      ///< as declared by the source
  double measured_hz = 0;  ///< over the last two seconds
  TimeOrigin times = TimeOrigin::kArrival;
  std::uint64_t frames = 0;  ///< received frames
  /// Lost frames: gaps in the capture times (not counted for arrival times, which have jitter), and frames
  /// that came into no set.
  std::uint64_t drops = 0;
  int reconnects = 0;
  double skew_s = 0;  ///< its capture time - the mean time, in the last set that contains it
  std::string fault;  ///< the last error, one line; empty if there was none
};

/// Reads cameras until destruction. Public functions are callable from any thread.
class LiveCameras {
 public:
  /// Opens all cameras and starts reading. \throw Error naming the first camera that cannot be opened.
  explicit LiveCameras(std::vector<LiveCamera> cameras, const LiveOptions& options = {});
  /// Returns within a second, even if a device or network blocks a thread's read: such a thread is detached
  /// and ends when its read returns.
  ~LiveCameras();
  LiveCameras(const LiveCameras&) = delete;
  LiveCameras& operator=(const LiveCameras&) = delete;

  /// Waits up to `wait_s` for the next set, according to LiveOptions::sets; empty after that time, or at the
  /// end. A set lacks a camera only if the camera is late by more than the patience, or is frozen, lost or
  /// ended.
  std::optional<LiveSet> next(double wait_s);
  /// Whether all sources are files that have ended, and next() has returned the last set.
  bool ended() const;

  /// One per camera, in constructor order.
  std::vector<CameraStatus> status() const;
  /// The smallest skew among the waiting frames, seconds, if it exceeds maxSkew() so that there is no set;
  /// empty otherwise.
  std::optional<double> excessSkew() const;
  double maxSkew() const;  ///< seconds
  double slowestRateHz() const;
  /// Replaces the cameras' offset_s, one per camera.
  void setOffsets(const std::vector<double>& offsets_s);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  ///< outlives this object if a blocked thread was detached
  std::vector<std::thread> threads_;
};

/// The sources in the rig's order. \throw Error (Fault::kUsage) naming a camera of the rig without a source,
/// or a source without a camera in the rig.
std::vector<NamedSource> inOrderOf(const Rig& rig, const std::vector<NamedSource>& sources);
/// \throw Error naming a camera whose images do not have the rig's size. \pre the cameras are in the rig's
/// order
void checkSizes(const Rig& rig, const LiveCameras& cameras);

}  // namespace airclay
