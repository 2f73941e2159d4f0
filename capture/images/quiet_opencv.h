// SPDX-License-Identifier: MIT
// Silences OpenCV and FFmpeg, which otherwise write to standard error; this program reports each error in one
// line.
#pragma once

namespace airclay {

/// Silences the logs of OpenCV and FFmpeg for the whole process, unless OPENCV_FFMPEG_LOGLEVEL or
/// OPENCV_LOG_LEVEL is set. Call it before OpenCV opens its first video, as all of capture/ does.
void quietOpenCv();

}  // namespace airclay
