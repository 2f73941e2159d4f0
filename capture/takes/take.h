// SPDX-License-Identifier: MIT
// A take: one recording of a rig, a folder. Its calibration, frames, masks, times and truth, checked when it
// is opened.
#pragma once

#include <limits>
#include <memory>

#include "capture/takes/recording.h"

namespace airclay {

struct TakeOptions {
  RigUnits units = RigUnits::kAsWritten;
  int background_frames = 10;  ///< how many first frames show the empty workspace, where no background/ does
  /// It may have been cut off while it was written: what is whole is used, and its frames are no more than
  /// `most_frames`.
  bool unfinished = false;
  int most_frames = std::numeric_limits<int>::max();
};

/// Opens a take and reads its frames into the caller's memory: one buffer a camera, in the rig's order.
///
///     Take take("takes/monday");
///     for (int frame = 0; take.readImages(frame, buffers); ++frame) { … }
///
/// Every fault, now or while reading, is an Error that names the file and, where it helps, the frame.
class Take : public Recording {
 public:
  /// \throw Error: no such folder, no rig, a camera without its video or images, another size than the rig
  /// says, no frame at all, timestamps or truth that cannot be read.
  explicit Take(const std::filesystem::path& folder, const TakeOptions& options = {});
  ~Take() override;
  Take(Take&&) noexcept;
  Take& operator=(Take&&) noexcept;

  const Rig& rig() const override;
  /// Frames that every camera has.
  int frameCount() const override;
  /// Frames a second, on average.
  double rateHz() const override;
  /// When frame `frame` was taken, in seconds: the mean of its cameras' times. \pre 0 <= frame < frameCount()
  double timeOf(int frame) const override;
  /// As timestamps.csv says them.
  std::vector<double> cameraTimesOf(int frame) const override;

  bool hasImages() const override;       ///< videos or image folders; else there are masks alone
  bool hasSilhouettes() const override;  ///< masks to be used as they are, instead of segmentation
  bool hasBackground() const override;   ///< images of the empty workspace
  /// How many first frames show the empty workspace: 0 where background images or masks make them needless.
  int backgroundFrames() const override;

  /// Decodes a frame of every camera, BGR, 3 bytes a pixel. False past the last frame. In order this costs
  /// one decoded image a camera; any other order decodes a video up to the frame. \pre hasImages()
  bool readImages(int frame, Buffers bgr) override;
  /// A frame's masks, 1 byte a pixel: 255 the object, 0 not. A missing file is an empty mask. \pre
  /// hasSilhouettes()
  bool readSilhouettes(int frame, Buffers masks) override;
  /// The empty workspace, BGR. \pre hasBackground()
  void readBackground(Buffers bgr) const override;

  /// True poses, where the take has truth.tum.
  const std::optional<std::vector<TimedPose>>& truth() const override;
  /// What is unusual but no fault, in one line to be shown: videos of unequal length.
  const std::optional<std::string>& note() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
