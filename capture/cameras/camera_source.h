// SPDX-License-Identifier: MIT
// Where a live camera's images come from: a device, a file played as if it were one, a stream, a pipeline.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/images/image_file.h"
#include "engine/core/clock.h"

namespace airclay {

/// What a SOURCE can be.
enum class SourceKind {
  kDevice,    ///< 0, /dev/video0: Video4Linux (untested on hardware: where this was written there was none)
  kVideo,     ///< a video file, played at its own rate
  kImages,    ///< a folder of numbered images, or a pattern as img_%04d.png
  kStream,    ///< rtsp://…, http://… (also MJPEG, as telephones serve it), tcp://…, udp://…
  kPipeline,  ///< GStreamer: "gst: videotestsrc", or any words with a '!' between them
};

/// A SOURCE as it was read. Nothing has been opened.
struct Source {
  SourceKind kind = SourceKind::kVideo;
  std::string text;  ///< the device's path, the file, the address, or the pipeline without "gst:"
};

/// Tells what a SOURCE means by its form. \throw Error when it has none of these forms.
Source parseSource(const std::string& source);

/// A camera of the command line.
struct NamedSource {
  std::string name;
  Source source;
};

/// Reads NAME=SOURCE; names are letters, digits, '-', '_' and '.', for they become files' names.
/// \throw Error (Fault::kUsage)
NamedSource parseNamedSource(const std::string& text);

/// What a device is asked for; one that can't says so, except for the rate, which a device may round.
struct SourceOptions {
  std::optional<ImageSize> size;
  std::optional<double> rate_hz;
  std::string format;  ///< four letters: MJPG, YUYV; empty: as the device has it
  std::optional<double>
      exposure;                ///< automatic exposure off, and this value (the driver's unit, often 100 us)
  std::optional<double> gain;  ///< this value; the driver's unit
  bool loop = false;           ///< a file begins anew at its end
};

/// How a source's times are known.
enum class TimeOrigin {
  kBuffer,   ///< the driver says when the buffer was filled
  kFile,     ///< frame k of a file is at k / its rate
  kArrival,  ///< when the image came, its jitter taken off (ArrivalClock)
};

/// The same in words: "buffer times", "the file's rate", "arrival, delay unknown".
const char* nameOf(TimeOrigin origin);

/// One image: BGR, 3 bytes a pixel, tightly packed, rows from the top.
struct LiveImage {
  ImageSize size;
  std::vector<std::uint8_t> bgr;
};

/// Delivers images one after another. All but stop() belong to one thread.
class CameraSource {
 public:
  virtual ~CameraSource() = default;

  virtual ImageSize size() const = 0;
  virtual double rateHz() const = 0;  ///< as the source declares it; 30 where it doesn't
  virtual TimeOrigin times() const = 0;

  /// Files: frame 0 is due at `start`; where that has long passed, a whole number of frames after it, so
  /// that files that were begun apart stay in step. Others begin by themselves.
  virtual void begin(Clock::time_point /*start*/) {}

  /// Waits for the next image. `capture_s` is when it was taken, in seconds of the machine's monotonic
  /// clock (Clock, CLOCK_MONOTONIC). False when a file has ended, or after stop(). \throw Error naming camera
  /// and source when no image comes any more.
  virtual bool read(LiveImage& image, double& capture_s) = 0;

  /// From any thread: a read that waits for a file's next frame returns. One that waits for a device or a
  /// network returns when that gives up, after some seconds.
  virtual void stop() {}
};

/// Opens the source of camera `name`. \throw Error naming both, and what would be right.
std::unique_ptr<CameraSource> openSource(const NamedSource& camera, const SourceOptions& options = {});

/// Now, on the clock of capture times.
inline double secondsNow() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Capture times from arrivals. The way from the sensor to us takes a time that varies, but is never shorter
/// than some least one: of a stream's own times (or the count of frames) and the arrivals, the lower envelope
/// of arrival - stream time is the stream's clock plus that least delay. The jitter is gone; the delay itself
/// nobody can tell from one camera alone (capture/cameras/clock_offsets.h compares cameras).
class ArrivalClock {
 public:
  /// When the frame with the stream's time `stream_s` was taken, `least delay` late.
  double captureOf(double arrival_s, double stream_s);

  /// Frames over which the envelope is taken: 4 s at 30 Hz. Clocks that part by 100 ppm move it by 0.4 ms.
  static constexpr std::size_t kFrames = 120;

 private:
  std::deque<double> delays_s_;  ///< arrival - stream time
};

}  // namespace airclay
