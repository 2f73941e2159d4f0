// SPDX-License-Identifier: MIT
// A network camera, like a phone or a cheap IP camera: MJPEG over HTTP, on the loopback interface.
#pragma once

#include <atomic>
#include <thread>

#include "capture/images/image_file.h"

namespace airclay {

/// Serves changing images at `rate_hz` to one client at a time. Destruction looks like a camera that is
/// switched off.
class MjpegServer {
 public:
  /// `port` 0: any free port.
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
