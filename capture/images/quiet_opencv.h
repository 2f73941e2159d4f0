// SPDX-License-Identifier: MIT
// OpenCV and FFmpeg write their own lines to standard error; this program's faults are one line each.
#pragma once

namespace airclay {

/// Silences OpenCV's log and FFmpeg's for the whole process, unless OPENCV_FFMPEG_LOGLEVEL or
/// OPENCV_LOG_LEVEL asks for it. To be called before OpenCV's first video: all of capture/ does.
void quietOpenCv();

}  // namespace airclay
