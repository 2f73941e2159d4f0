// SPDX-License-Identifier: MIT
// The cameras of this machine for another one: each is an RTSP stream of H.264 images.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/cameras/live_cameras.h"

namespace airclay {

struct StreamServerOptions {
  std::string address = "127.0.0.1";  ///< one of this machine's, in numbers; 0.0.0.0 or ::, all of them
  int port = 8554;                    ///< 0: any that is free
  SourceOptions sources;
};

/// How a camera is streamed.
struct StreamStatus {
  CameraStatus camera;
  std::string address;         ///< rtsp://ADDRESS:PORT/NAME
  bool watched = false;        ///< somebody watches; only then its images are coded
  std::uint64_t streamed = 0;  ///< images that were coded for those who watched
};

/// Streams cameras until it ends. An image is coded once for all who watch, without B frames, and a whole
/// one twice a second, so that who comes later sees it soon. RTP times are capture times. The streams go over
/// TCP alone (interleaved in RTSP): an image is whole or missing, not smeared. Who reads too slowly loses
/// images; no queue grows without bound. A camera that is lost is opened again
/// once a second; till then whoever asks for it is told that the service is unavailable, and the others go
/// on.
class StreamServer {
 public:
  /// Takes the port, opens all cameras and begins. \throw Error (Fault::kUsage) for an address or port that
  /// cannot be had; Error naming the first camera that cannot be opened, or a plugin of GStreamer that is
  /// missing.
  StreamServer(const std::vector<NamedSource>& cameras, const StreamServerOptions& options);
  /// Ends all connections, within a second or so.
  ~StreamServer();
  StreamServer(const StreamServer&) = delete;
  StreamServer& operator=(const StreamServer&) = delete;

  int port() const;
  /// One a camera, in the order they were given in. From any thread.
  std::vector<StreamStatus> status() const;
  /// All were files, and all are over.
  bool ended() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
