// SPDX-License-Identifier: MIT
// Live cameras on the command line, shared by the commands that take them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/cameras/live_cameras.h"

namespace CLI {
class App;
}

namespace airclay {

/// As written.
struct CameraOptions {
  std::vector<std::string> cameras;  ///< NAME=SOURCE each
  std::vector<std::string> offsets;  ///< NAME=MS each
  std::string mode, format;          ///< 640x480 or 640x480@30; MJPG
  std::optional<double> exposure, gain, max_skew_ms;
  bool loop = false;
  std::optional<ImageSize> usual_size;  ///< where no mode is given: the rig's

  bool given() const { return !cameras.empty(); }
  /// \throw Error (Fault::kUsage) naming a word that is malformed, or a name that is there twice
  std::vector<NamedSource> sources() const;
  /// The cameras for LiveCameras, in the order of `sources`, with the offsets and modes that were given.
  /// \throw Error (Fault::kUsage) naming an offset that is malformed or of no camera
  std::vector<LiveCamera> live(const std::vector<NamedSource>& sources) const;
  SourceOptions sourceOptions() const;
  LiveOptions liveOptions(LiveOptions::Sets sets) const;
};

/// --camera, --mode, --format, --exposure, --gain, --offset, --max-skew-ms, --loop.
void addCameraOptions(CLI::App& command, CameraOptions& options);

}  // namespace airclay
