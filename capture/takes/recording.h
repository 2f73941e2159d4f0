// SPDX-License-Identifier: MIT
// The interface of everything that can be tracked: frames of a rig's cameras with their times. Implemented by
// takes (take.h), synthetic cameras (synthetic.h) and live cameras.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/takes/poses_file.h"
#include "engine/camera/rig.h"
#include "engine/camera/silhouette_image.h"
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
  /// Buffers for a frame, one per camera in the rig's order; rows from the top, without padding.
  using Buffers = std::span<const std::span<std::uint8_t>>;

  virtual ~Recording() = default;

  virtual const Rig& rig() const = 0;
  /// The number of frames that every camera has.
  virtual int frameCount() const = 0;
  /// Average frames per second.
  virtual double rateHz() const = 0;
  /// The frame's capture time, seconds: the mean of its cameras' times. \pre 0 <= frame < frameCount()
  virtual double timeOf(int frame) const = 0;
  /// Each camera's capture time of the frame, seconds, in the rig's order; empty without per-camera
  /// timestamps. \pre 0 <= frame < frameCount()
  virtual std::vector<double> cameraTimesOf(int /*frame*/) const { return {}; }

  /// The number of leading frames that show the empty workspace; 0 if background images or masks replace
  /// them.
  virtual int backgroundFrames() const = 0;
  virtual bool hasImages() const { return true; }        ///< false: masks only
  virtual bool hasSilhouettes() const { return false; }  ///< masks that replace segmentation
  virtual bool hasBackground() const { return false; }   ///< images of the empty workspace

  /// Reads a frame of every camera, BGR, 3 bytes per pixel; false after the last frame. Fastest in ascending
  /// order. \pre hasImages()
  virtual bool readImages(int frame, Buffers bgr) = 0;
  /// Reads a frame's silhouettes, 1 byte per pixel (Silhouette::pixels); false after the last frame. \pre
  /// hasSilhouettes()
  virtual bool readSilhouettes(int /*frame*/, Buffers /*masks*/) { return false; }
  /// Reads images of the empty workspace, BGR. \pre hasBackground()
  virtual void readBackground(Buffers /*bgr*/) const {}

  /// The true poses, if known.
  virtual const std::optional<std::vector<TimedPose>>& truth() const = 0;

  /// Bit k: camera k has no image of the frame that was read last.
  virtual std::uint32_t missingCameras() const { return 0; }
  /// The cameras, if they are live; null for a recording.
  virtual const LiveSource* live() const { return nullptr; }
  bool isLive() const { return live() != nullptr; }
};

/// A frame's masks, one per camera. \pre recording.hasSilhouettes() and 0 <= frame < recording.frameCount()
inline std::vector<Silhouette> silhouettesOf(Recording& recording, int frame) {
  std::vector<Silhouette> masks;
  for (const Camera& camera : recording.rig().cameras) masks.push_back(emptySilhouette(camera));
  std::vector<std::span<std::uint8_t>> buffers;
  for (Silhouette& mask : masks) buffers.emplace_back(mask.pixels);
  recording.readSilhouettes(frame, buffers);
  return masks;
}

/// The skew between cameras: the largest difference of a set's times, seconds. Empty for a set without times.
inline std::optional<double> skewOf(const std::vector<double>& camera_times_s) {
  if (camera_times_s.empty()) return std::nullopt;
  const auto [first, last] = std::minmax_element(camera_times_s.begin(), camera_times_s.end());
  return *last - *first;
}

}  // namespace airclay
