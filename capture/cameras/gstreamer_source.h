// SPDX-License-Identifier: MIT
// RTSP streams, and pipelines in words, as cameras.
#pragma once

#include <memory>

#include "capture/cameras/camera_source.h"

namespace airclay {

/// Opens rtsp://… (over TCP), or a GStreamer pipeline. For RTSP, OpenCV's FFmpeg would deliver every image
/// late, by one frame for its parser and one for each processor but the first, on which it decodes side by
/// side: half a second on a machine with 16. This takes the decoding alone, some milliseconds. And OpenCV's
/// GStreamer waits without end for a pipeline that gives no image.
/// \throw Error naming camera and source when no image has come after four seconds, or when the words are
/// no pipeline
std::unique_ptr<CameraSource> openGStreamerSource(const NamedSource& camera);

}  // namespace airclay
