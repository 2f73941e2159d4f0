// SPDX-License-Identifier: MIT
// Several cameras at once: a thread reads each, a matcher puts their frames together by capture time
// (capture/takes/frame_matcher.h), and a problem is reported with the camera's name while the others
// continue.
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

/// What LiveCameras needs of one camera.
struct LiveCamera {
  std::string name;
  /// Opens it, at the start and again after it was lost. \throw Error
  std::function<std::unique_ptr<CameraSource>()> open;
  /// What its times are too late by; it is subtracted. A network's delay, or what estimateClockOffsets found.
  double offset_s = 0;
};
LiveCamera liveCamera(const NamedSource& camera, const SourceOptions& options = {}, double offset_s = 0);

struct LiveOptions {
  enum class Sets {
    kNewest,  ///< the newest complete set wins; for sculpting
    kEvery,   ///< all sets in order; for recording
  };
  Sets sets = Sets::kNewest;
  /// Frames of a set are at most so far apart. None: half a period of the slowest camera; for kEvery, which
  /// keeps every frame's time, a whole one.
  std::optional<double> max_skew_s;
  /// How long a set waits for a camera that is late, at least; where a camera's images usually need longer
  /// to get here, so long, up to 5 s. None: 0.1 s; for kEvery 0.5 s.
  std::optional<double> patience_s;
};

/// The images of one instant.
struct LiveSet {
  std::vector<LiveImage> images;  ///< one a camera; empty where the camera is missing
  std::vector<double>
      camera_times_s;            ///< capture times (camera_source.h), offsets applied; NaN where missing
  double time_s = 0;             ///< their mean
  double skew_s = 0;             ///< latest - earliest
  bool complete = false;         ///< no camera is missing; else at least two are there
  Clock::time_point arrived_at;  ///< when the last of its images was decoded
};

enum class CameraState {
  kLive,
  kLate,          ///< slower than 80 % of its rate, or behind the others
  kFrozen,        ///< no image for half a second, or the same bytes for two; its images are not used
  kLost,          ///< reading failed just now
  kReconnecting,  ///< it is opened again, once a second
  kEnded,         ///< the file is over
};
/// "live", "late", "frozen", "lost", "reconnecting", "ended".
const char* nameOf(CameraState state);

struct CameraStatus {
  std::string name;
  CameraState state = CameraState::kLive;
  ImageSize size;
  double rate_hz = 0;      ///< as the source declares it
  double measured_hz = 0;  ///< of the last two seconds
  TimeOrigin times = TimeOrigin::kArrival;
  std::uint64_t frames = 0;  ///< that came
  /// That didn't: gaps in the capture times (where those are not arrivals: jitter is no gap), and frames that
  /// nobody took in time.
  std::uint64_t drops = 0;
  int reconnects = 0;
  double skew_s = 0;  ///< its time - the mean of the last set that it was in
  std::string fault;  ///< the last one, a line; empty: none yet
};

class LiveCameras {
 public:
  /// Opens all cameras and begins to read. \throw Error naming the first one that cannot be opened.
  explicit LiveCameras(std::vector<LiveCamera> cameras, const LiveOptions& options = {});
  /// Ends within a second, also where a device or a network blocks: such a thread is left to itself and ends
  /// when its read gives up.
  ~LiveCameras();
  LiveCameras(const LiveCameras&) = delete;
  LiveCameras& operator=(const LiveCameras&) = delete;

  /// The next set, as the options say; none when there is none within `wait_s`, or at the end. A set without
  /// some camera is given only when waiting for it took longer than the patience, or when it is known to be
  /// frozen or gone.
  std::optional<LiveSet> next(double wait_s);
  /// All were files, and the last set has been taken.
  bool ended() const;

  /// One a camera, in the order they were given in. From any thread.
  std::vector<CameraStatus> status() const;
  /// Where cameras run, but their frames lie too far apart for a set: how far. The allowed skew must be
  /// larger.
  std::optional<double> refusedSkew() const;
  double maxSkew() const;
  double slowestRateHz() const;
  /// Replaces the offsets, one a camera.
  void setOffsets(const std::vector<double>& offsets_s);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  ///< shared with threads that a blocked read may keep beyond this
  std::vector<std::thread> threads_;
};

/// The sources in the rig's order. \throw Error (Fault::kUsage) naming a camera of the rig that has none, or
/// a source that is no camera of the rig.
std::vector<NamedSource> inOrderOf(const Rig& rig, const std::vector<NamedSource>& sources);
/// \throw Error naming a camera whose images are not of the rig's size. \pre the rig's order
void checkSizes(const Rig& rig, const LiveCameras& cameras);

}  // namespace airclay
