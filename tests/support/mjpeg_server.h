// SPDX-License-Identifier: MIT
// A camera on the network, as telephones and cheap IP cameras are: MJPEG over HTTP, on this machine alone.
#pragma once

#include <atomic>
#include <thread>

#include "capture/images/image_file.h"

namespace airclay {

/// Serves an image that changes, `rate_hz` times a second, to one client at a time; gone with its object, as
/// a camera that is switched off.
class MjpegServer {
 public:
  /// `port` 0: any that is free.
  MjpegServer(ImageSize size, double rate_hz, int port = 0);
  ~MjpegServer();
  MjpegServer(const MjpegServer&) = delete;
  MjpegServer& operator=(const MjpegServer&) = delete;
  int port() const { return port_; }

 private:
  void serve(ImageSize size, double rate_hz);

  int listening_ = -1, port_ = 0;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace airclay
