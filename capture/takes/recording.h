// SPDX-License-Identifier: MIT
// What can be tracked: frames of a rig's cameras with their times. A take (take.h), or synthetic cameras
// (synthetic.h).
#pragma once

#include <algorithm>
#include <optional>
#include <span>

#include "capture/takes/poses_file.h"
#include "engine/camera/mask.h"
#include "engine/camera/rig.h"
#include "engine/core/clock.h"

namespace airclay {

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

  // --- cameras that run (live_recording.h). What follows, and the times, are of the frame read last ---

  /// Frames are what comes now, and none can be read again. readImages() is also false when none came for a
  /// while: the end is where frameCount() says it, at first nowhere.
  virtual bool isLive() const { return false; }
  virtual std::optional<Clock::time_point> capturedAt() const { return std::nullopt; }
  /// Bits of the cameras without an image of that instant.
  virtual std::uint32_t missingCameras() const { return 0; }
  /// What is wrong with the cameras now, a few words each: "left: frozen".
  virtual std::vector<std::string> camera_problems() const { return {}; }
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
