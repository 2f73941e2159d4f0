// SPDX-License-Identifier: MIT
// Streams this machine's cameras to other machines: one RTSP stream of H.264 images per camera.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/cameras/live_cameras.h"

namespace airclay {

struct StreamServerOptions {
  std::string address = "127.0.0.1";  ///< a numeric address of this machine; 0.0.0.0 or ::: all of them
  int port = 8554;                    ///< 0: any free port
  SourceOptions sources;
};

/// The state of one stream.
struct StreamStatus {
  CameraStatus camera;
  std::string address;         ///< rtsp://ADDRESS:PORT/NAME
  bool watched = false;        ///< there are clients; images are encoded only then
  std::uint64_t streamed = 0;  ///< encoded images
};

/// Streams cameras until destruction. Each image is encoded once for all clients, without B frames, and with
/// two key frames per second, so that new clients start soon. RTP times are capture times. Streams use only
/// TCP (interleaved in RTSP), so images are complete or missing. Slow clients lose images; no queue grows
/// without bound. A lost camera is reopened once per second; until then, requests for it get "service
/// unavailable", and the other streams continue.
class StreamServer {
 public:
  /// Binds the port, opens all cameras and starts streaming. \throw Error (Fault::kUsage) if the address or
  /// port is unavailable; Error naming the first camera that cannot be opened, or a missing GStreamer plugin.
  StreamServer(const std::vector<NamedSource>& cameras, const StreamServerOptions& options);
  /// Closes all connections, within about a second.
  ~StreamServer();
  StreamServer(const StreamServer&) = delete;
  StreamServer& operator=(const StreamServer&) = delete;

  int port() const;
  /// One per camera, in constructor order. Callable from any thread.
  std::vector<StreamStatus> status() const;
  /// Whether all sources are files that have ended.
  bool ended() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
