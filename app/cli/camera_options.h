// SPDX-License-Identifier: MIT
// The command-line options for live cameras, shared by the commands that take them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/cameras/live_cameras.h"

namespace CLI {
class App;
}

namespace airclay {

/// The options as given.
struct CameraOptions {
  std::vector<std::string> cameras;  ///< NAME=SOURCE each
  std::vector<std::string> offsets;  ///< NAME=MS each
  std::string mode, format;          ///< 640x480 or 640x480@30; MJPG
  std::optional<double> exposure, gain, max_skew_ms;
  bool loop = false;
  std::optional<ImageSize> usual_size;  ///< used without --mode: the rig's image size

  bool given() const { return !cameras.empty(); }
  /// \throw Error (Fault::kUsage) naming a malformed option or a duplicate name
  std::vector<NamedSource> sources() const;
  /// The cameras for LiveCameras, in the order of `sources`, with the given offsets and modes. \throw Error
  /// (Fault::kUsage) naming an offset that is malformed or of an unknown camera
  std::vector<LiveCamera> live(const std::vector<NamedSource>& sources) const;
  SourceOptions sourceOptions() const;
  LiveOptions liveOptions(LiveOptions::Sets sets) const;
};

/// Parses NAME=MS: the camera's name and the offset in seconds. \throw Error (Fault::kUsage)
std::pair<std::string, double> parseOffset(const std::string& text);
/// --offset, unless the command already has it.
void addOffsetOption(CLI::App& command, std::vector<std::string>& offsets);

/// --camera, --mode, --format, --exposure, --gain, --offset, --max-skew-ms, --loop.
void addCameraOptions(CLI::App& command, CameraOptions& options);

}  // namespace airclay
