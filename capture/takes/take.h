// SPDX-License-Identifier: MIT
// A take: a folder with one recording of a rig. Calibration, frames, masks, times and true poses are checked
// when it is opened.
#pragma once

#include <limits>
#include <map>
#include <memory>

#include "capture/takes/recording.h"

namespace airclay {

struct TakeOptions {
  RigUnits units = RigUnits::kAsWritten;
  int background_frames = 10;  ///< leading frames that show the empty workspace, if there is no background/
  /// Accepts a recording that was interrupted while being written, and uses its complete frames.
  bool unfinished = false;
  /// By how much a camera's timestamps are late, in seconds, by its name: they are subtracted, and images are
  /// matched by their times.
  std::map<std::string, double> offsets_s;
  int max_frames = std::numeric_limits<int>::max();  ///< later frames are ignored
};

/// Opens a take and reads its frames into the caller's buffers, one per camera in the rig's order.
///
///     Take take("takes/monday");
///     for (int frame = 0; take.readImages(frame, buffers); ++frame) { … }
///
/// Every error, on opening or reading, names the file and, if useful, the frame.
class Take : public Recording {
 public:
  /// \throw Error if there is no such folder, no rig or no frames; a camera has no video or images, or their
  /// size differs from the rig's; or timestamps or true poses cannot be read.
  explicit Take(const std::filesystem::path& folder, const TakeOptions& options = {});
  ~Take() override;
  Take(Take&&) noexcept;
  Take& operator=(Take&&) noexcept;

  const Rig& rig() const override;
  /// The number of frames: instants at which every camera, or with different rates at least two, has an
  /// image.
  int frameCount() const override;
  /// Average frames per second.
  double rateHz() const override;
  /// The frame's capture time, seconds: the mean of its cameras' times. \pre 0 <= frame < frameCount()
  double timeOf(int frame) const override;
  /// From timestamps.csv, or from videos whose images are matched by their times; otherwise empty.
  std::vector<double> cameraTimesOf(int frame) const override;
  /// A camera of a lower rate, or that missed a frame; readImages() gives its last image before.
  std::uint32_t missingCameras() const override;

  bool hasImages() const override;       ///< videos or image folders; false: masks only
  bool hasSilhouettes() const override;  ///< masks that replace segmentation
  bool hasBackground() const override;   ///< images of the empty workspace
  /// The number of leading frames that show the empty workspace; 0 if background images or masks replace
  /// them.
  int backgroundFrames() const override;

  /// Decodes a frame of every camera, BGR, 3 bytes per pixel; false after the last frame. In ascending order
  /// this decodes one image per camera; otherwise it decodes the video up to the frame. \pre hasImages()
  bool readImages(int frame, Buffers bgr) override;
  /// Reads a frame's silhouettes, 1 byte per pixel (Silhouette::pixels). A missing file is an empty one. \pre
  /// hasSilhouettes()
  bool readSilhouettes(int frame, Buffers masks) override;
  /// Reads images of the empty workspace, BGR. \pre hasBackground()
  void readBackground(Buffers bgr) const override;

  /// The true poses, if the take has truth.tum.
  const std::optional<std::vector<TimedPose>>& truth() const override;
  /// A one-line warning for the user, such as videos of unequal length.
  const std::optional<std::string>& note() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
