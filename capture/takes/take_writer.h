// SPDX-License-Identifier: MIT
// Writes a take while it happens: the sets of images that were used, without loss, on a thread of its own.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "capture/takes/recording.h"

namespace airclay {

/// The images of all cameras at one instant, as they were used.
struct TakenSet {
  std::vector<double> camera_times_s;            ///< one a camera; empty where there are none
  std::vector<std::vector<std::uint8_t>> bytes;  ///< one a camera: BGR, 3 bytes a pixel; or masks, 1 byte
};

/// Writes rig.toml, NAME.mkv a camera (HuffYUV: no bit is lost, at a tenth of FFV1's time; images of odd
/// size as NAME/000000.png), or silhouettes/NAME/000000.png of masks, and timestamps.csv, as they come: what
/// is there when the power fails can be read as a take (TakeOptions::unfinished).
class TakeWriter {
 public:
  enum class Content {
    kImages,
    kMasks,
    kNothing,  ///< the rig alone
  };
  struct Options {
    double rate_hz = 30;
    Content content = Content::kImages;
    /// False: a recording from which the rig will be calibrated. Of the rig only names and sizes count, and
    /// there is no rig.toml.
    bool writes_rig = true;
    /// How many bytes there is room for on the disk of a folder; none: as the system says.
    std::function<std::uintmax_t(const std::filesystem::path&)> room;
  };

  /// \throw Error when `folder` is there and not empty, or cannot be made or written.
  TakeWriter(const std::filesystem::path& folder, const Rig& rig, const Options& options);
  ~TakeWriter();
  TakeWriter(const TakeWriter&) = delete;
  TakeWriter& operator=(const TakeWriter&) = delete;

  /// The empty workspace, one BGR image a camera. \pre before the first set
  void writeBackground(const std::vector<std::vector<std::uint8_t>>& bgr);
  /// The next set. Nothing is ever left out: when the disk is slower than the cameras and the queue is full,
  /// this waits. Times that don't grow (a take played again) are moved behind those before.
  void write(TakenSet set);
  /// Waits until all is on its way to the disk, and closes the videos. \throw Error when something could not
  /// be written.
  void finish();

  struct Status {
    int sets = 0;             ///< written
    double waited_s = 0;      ///< what write() has waited for the disk so far
    std::string fault;        ///< why nothing more is written; empty: all is well
    std::uint64_t bytes = 0;  ///< of all files
  };
  Status status() const;

  /// What may wait for the disk: some 17 sets of four VGA cameras.
  static constexpr std::size_t kQueueBytes = 64u << 20;
  /// Less room than this on the disk ends the recording, so that what is open can be closed.
  static constexpr std::uintmax_t kLeastRoomBytes = 64u << 20;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
