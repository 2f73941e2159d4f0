// SPDX-License-Identifier: MIT
// The machine's Video4Linux cameras and their modes. Not yet tested on hardware.
#pragma once

#include <string>
#include <vector>

#include "capture/images/image_file.h"

namespace airclay {

/// One size in one pixel format.
struct V4l2Mode {
  std::string format;  ///< four letters: MJPG, YUYV
  ImageSize size;
  std::vector<double> rates_hz;  ///< fastest first
};

struct V4l2Device {
  std::string path;    ///< /dev/video0
  std::string name;    ///< reported by the camera
  std::string driver;  ///< uvcvideo
  std::string bus;     ///< where it is connected; cameras on one USB hub share its bandwidth
  std::vector<V4l2Mode> modes;
};

/// The devices that deliver images, by number. Omits devices that cannot be opened or deliver none (a
/// camera's second node has only metadata).
std::vector<V4l2Device> listV4l2Devices();

}  // namespace airclay
