// SPDX-License-Identifier: MIT
// FFmpeg's log level can only be set through the environment, which OpenCV reads once, at the first video.
#include "capture/images/quiet_opencv.h"

#include <cstdlib>
#include <mutex>
#include <opencv2/core/utils/logger.hpp>

namespace airclay {

void quietOpenCv() {
  static std::once_flag once;
  std::call_once(once, [] {
    setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // AV_LOG_QUIET
    if (!std::getenv("OPENCV_LOG_LEVEL"))
      cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  });
}

}  // namespace airclay
