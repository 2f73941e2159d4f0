// SPDX-License-Identifier: MIT
// A recording of a waved board: which videos make it, which of their frames are one instant, and where the
// board is in them.
#pragma once

#include <memory>

#include "capture/calibration/board_detector.h"
#include "capture/calibration/calibration.h"

namespace airclay {

struct BoardSearch {
  int every = 0;            ///< only every so many frames are looked at; 0: so that 150 of a camera are
  std::optional<int> also;  ///< and this one
  int threads = 2;
};

/// A folder of videos NAME.mp4, .mkv or .avi, or of folders NAME/000000.png and on: a camera each. Where it
/// holds timestamps.csv, frames within half a frame's time are one instant, and it bears the number of the
/// camera's that has most frames a second; otherwise frame k of each camera is instant k.
class BoardRecording {
 public:
  /// \throw Error: no such folder, fewer than two cameras or too many, a video that cannot be read,
  /// timestamps that cannot.
  explicit BoardRecording(const std::filesystem::path& folder);
  ~BoardRecording();

  /// Instants, of which not all cameras need have a frame.
  int frameCount() const;
  /// Their names and sizes; no views yet.
  std::vector<CameraViews> cameras() const;
  /// What is unusual but no fault, a line each.
  const std::vector<std::string>& notes() const;

  /// Looks for the board in all cameras. Tells the calling thread's reportProgress().
  /// \throw Error when no camera saw it at all, with what was seen instead where that is known; when a camera
  /// hardly finds it because it is too small in the image; or when a frame cannot be decoded.
  std::vector<CameraViews> findBoards(const BoardDetector& detector, const BoardSearch& search = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
