// SPDX-License-Identifier: MIT
// RTSP streams and GStreamer pipelines as cameras.
#pragma once

#include <memory>

#include "capture/cameras/camera_source.h"

namespace airclay {

/// Opens rtsp://… (over TCP) or a GStreamer pipeline. For RTSP, OpenCV's FFmpeg delivers images late, by one
/// frame for its parser and one for each processor but the first, because it decodes frames in parallel: half
/// a second on a machine with 16 processors. This source is late only by the decoding, a few milliseconds.
/// And OpenCV's GStreamer backend waits forever for a pipeline that delivers no image. \throw Error naming
/// camera and source if no image has arrived after four seconds, or the pipeline is invalid
std::unique_ptr<CameraSource> openGStreamerSource(const NamedSource& camera);

}  // namespace airclay
