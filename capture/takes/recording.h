// SPDX-License-Identifier: MIT
// What can be tracked: frames of a rig's cameras with their times. A take (take.h), or synthetic cameras
// (synthetic.h).
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/takes/poses_file.h"
#include "engine/camera/mask.h"
#include "engine/camera/rig.h"
#include "engine/core/clock.h"

namespace airclay {

/// Live cameras: frame k is the newest set of images, and none can be read again. Recording::readImages() is
/// also false if no image comes for a while; frameCount() is the end, unknown at first.
class LiveSource {
 public:
  virtual ~LiveSource() = default;
  /// When the set that was read last was captured; nullopt before the first.
  virtual std::optional<Clock::time_point> capturedAt() const = 0;
  /// Current problems of the cameras, a few words each: "left: frozen".
  virtual std::vector<std::string> cameraProblems() const = 0;
};

class Recording {
 public:
  /// Buffers that a frame is written into, one a camera in the rig's order, tightly packed, rows from the
  /// top.
  using Buffers = std::span<const std::span<std::uint8_t>>;

  virtual ~Recording() = default;

  virtual const Rig& rig() const = 0;
  /// Frames that every camera has.
  virtual int frameCount() const = 0;
  /// Frames a second, on average.
  virtual double rateHz() const = 0;
  /// When frame `frame` was taken, in seconds: the mean of its cameras' times. \pre 0 <= frame < frameCount()
  virtual double timeOf(int frame) const = 0;
  /// When each camera took its image of frame `frame`, in the rig's order; empty where the cameras have no
  /// times of their own. \pre as timeOf()
  virtual std::vector<double> cameraTimesOf(int /*frame*/) const { return {}; }

  /// How many first frames show the empty workspace: 0 where background images or masks make them needless.
  virtual int backgroundFrames() const = 0;
  virtual bool hasImages() const { return true; }        ///< else there are masks alone
  virtual bool hasSilhouettes() const { return false; }  ///< masks to be used instead of segmentation
  virtual bool hasBackground() const { return false; }   ///< images of the empty workspace

  /// A frame of every camera, BGR, 3 bytes a pixel. False past the last frame. Cheapest in order. \pre
  /// hasImages()
  virtual bool readImages(int frame, Buffers bgr) = 0;
  /// A frame's masks, 1 byte a pixel: 255 the object, 0 not. False past the last frame. \pre
  /// hasSilhouettes()
  virtual bool readSilhouettes(int /*frame*/, Buffers /*masks*/) { return false; }
  /// The empty workspace, BGR. \pre hasBackground()
  virtual void readBackground(Buffers /*bgr*/) const {}

  /// True poses, where they are known.
  virtual const std::optional<std::vector<TimedPose>>& truth() const = 0;

  /// Bit k: camera k has no image of the frame that was read last.
  virtual std::uint32_t missingCameras() const { return 0; }
  /// The cameras, if they are live; null for a recording.
  virtual const LiveSource* live() const { return nullptr; }
  bool isLive() const { return live() != nullptr; }
};

/// A frame's masks, one per camera. \pre recording.hasSilhouettes() and 0 <= frame < recording.frameCount()
inline std::vector<Mask> silhouettesOf(Recording& recording, int frame) {
  std::vector<Mask> masks;
  for (const Camera& camera : recording.rig().cameras) masks.push_back(emptyMask(camera));
  std::vector<std::span<std::uint8_t>> buffers;
  for (Mask& mask : masks) buffers.emplace_back(mask.pixels);
  recording.readSilhouettes(frame, buffers);
  return masks;
}

/// The cameras' skew: the largest difference of a set's times, seconds. None of a set without times.
inline std::optional<double> skewOf(const std::vector<double>& camera_times_s) {
  if (camera_times_s.empty()) return std::nullopt;
  const auto [first, last] = std::minmax_element(camera_times_s.begin(), camera_times_s.end());
  return *last - *first;
}

}  // namespace airclay
