// SPDX-License-Identifier: MIT
// Writes a take during a session: the image sets that were used, lossless, on a separate thread.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "capture/takes/recording.h"

namespace airclay {

/// The images of all cameras at one instant.
struct RecordedSet {
  std::vector<double> camera_times_s;            ///< one per camera; may be empty
  std::vector<std::vector<std::uint8_t>> bytes;  ///< one per camera: BGR, 3 bytes per pixel; or masks, 1 byte
};

/// Writes rig.toml, timestamps.csv, and per camera NAME.mkv (HuffYUV: lossless, in a tenth of FFV1's time;
/// images of odd size as NAME/000000.png), or silhouettes/NAME/000000.png for masks. Files are written
/// continuously: after a power failure, they can be read as a take (TakeOptions::unfinished).
class TakeWriter {
 public:
  enum class Content {
    kImages,
    kMasks,
    kNothing,  ///< only the rig
  };
  struct Options {
    double rate_hz = 30;
    Content content = Content::kImages;
    /// False for a recording to calibrate the rig from: writes no rig.toml and uses only the rig's names and
    /// sizes.
    bool writes_rig = true;
    /// The free disk space for a folder, bytes; by default from the system.
    std::function<std::uintmax_t(const std::filesystem::path&)> free_bytes;
  };

  /// \throw Error if `folder` exists and is not empty, or cannot be created or written.
  TakeWriter(const std::filesystem::path& folder, const Rig& rig, const Options& options);
  ~TakeWriter();
  TakeWriter(const TakeWriter&) = delete;
  TakeWriter& operator=(const TakeWriter&) = delete;

  /// Writes images of the empty workspace, one BGR image per camera. \pre before the first set
  void writeBackground(const std::vector<std::vector<std::uint8_t>>& bgr);
  /// Queues the next set. Never drops a set: if the disk is slower than the cameras and the queue is full, it
  /// waits. If times do not increase (a take that restarts), shifts them after the previous ones.
  void write(RecordedSet set);
  /// Writes the queue and closes the videos. \throw Error if something could not be written.
  void finish();

  struct Status {
    int sets = 0;             ///< written
    double waited_s = 0;      ///< total time that write() waited for the disk
    std::string fault;        ///< why writing stopped; empty: no error
    std::uint64_t bytes = 0;  ///< of all files
  };
  Status status() const;

  /// Capacity of the queue: about 17 sets of four VGA cameras.
  static constexpr std::size_t kQueueBytes = 64u << 20;
  /// Recording stops when less disk space is free, so that open files can be closed.
  static constexpr std::uintmax_t kMinFreeBytes = 64u << 20;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
