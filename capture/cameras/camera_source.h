// SPDX-License-Identifier: MIT
// The sources of live images: devices, files played in real time, streams, pipelines.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/images/image_file.h"
#include "engine/core/clock.h"

namespace airclay {

/// The kinds of SOURCE.
enum class SourceKind {
  kDevice,    ///< 0, /dev/video0: Video4Linux (not yet tested on hardware)
  kVideo,     ///< a video file, played at its own rate
  kImages,    ///< a folder of numbered images, or a pattern such as img_%04d.png
  kStream,    ///< rtsp://…, http://… (also MJPEG, as phones serve it), tcp://…, udp://…
  kPipeline,  ///< GStreamer: "gst: videotestsrc", or any text that contains '!'
};

/// A parsed SOURCE, not opened.
struct Source {
  SourceKind kind = SourceKind::kVideo;
  std::string text;  ///< the device's path, the file, the address, or the pipeline without "gst:"
};

/// Determines the kind of a SOURCE from its text. \throw Error if it is none of these kinds.
Source parseSource(const std::string& source);

/// A camera on the command line.
struct NamedSource {
  std::string name;
  Source source;
};

/// Parses NAME=SOURCE; names consist of letters, digits, '-', '_' and '.', because they become file names.
/// \throw Error (Fault::kUsage)
NamedSource parseNamedSource(const std::string& text);

/// Requested device settings. An unsupported one is an error, except for the rate, which devices may round.
struct SourceOptions {
  std::optional<ImageSize> size;
  std::optional<double> rate_hz;
  std::string format;              ///< four letters: MJPG, YUYV; empty: the device's current format
  std::optional<double> exposure;  ///< turns automatic exposure off; the driver's unit, often 100 us
  std::optional<double> gain;      ///< the driver's unit
  bool loop = false;               ///< restart a file at its end
};

/// The origin of a source's capture times.
enum class TimeOrigin {
  kBuffer,   ///< the driver's time when the buffer was filled
  kFile,     ///< frame k of a file is at k / rate
  kArrival,  ///< the arrival time with jitter removed (ArrivalClock)
};

/// For display: "buffer times", "the file's rate", "arrival, delay unknown".
const char* nameOf(TimeOrigin origin);

/// One image: BGR, 3 bytes per pixel, rows from the top without padding.
struct LiveImage {
  ImageSize size;
  std::vector<std::uint8_t> bgr;
};

/// Delivers one camera's images. Not thread-safe, except for stop().
class CameraSource {
 public:
  virtual ~CameraSource() = default;

  virtual ImageSize size() const = 0;
  virtual double rateHz() const = 0;  ///< as declared by the source; 30 if it declares none
  virtual TimeOrigin times() const = 0;

  /// For files: frame 0 is due at `start`; if that is long past, a whole number of frames later, so that
  /// files started at different times stay synchronized. Other sources ignore this.
  virtual void begin(Clock::time_point /*start*/) {}

  /// Waits for the next image. `capture_s`: capture time in seconds of the machine's monotonic clock (Clock,
  /// CLOCK_MONOTONIC). False if a file has ended, or after stop(). \throw Error naming camera and source if
  /// no more images arrive.
  virtual bool read(LiveImage& image, double& capture_s) = 0;

  /// Callable from any thread. A read that waits for a file's next frame returns at once; one that waits for
  /// a device or network returns after its timeout of some seconds.
  virtual void stop() {}
};

/// Opens a camera's source. \throw Error naming camera and source, and what is expected.
std::unique_ptr<CameraSource> openSource(const NamedSource& camera, const SourceOptions& options = {});

/// The current time on the clock of capture times, seconds.
inline double secondsNow() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Estimates capture times from arrival times. The delay from the sensor varies but has a minimum, so the
/// lower envelope of (arrival - stream time) is the offset of the stream's clock plus the minimum delay. This
/// removes the jitter. The minimum delay itself cannot be determined from one camera
/// (capture/cameras/clock_offsets.h compares cameras).
class ArrivalClock {
 public:
  /// The capture time plus the minimum delay, for a frame with the stream time `stream_s`.
  double captureOf(double arrival_s, double stream_s);

  /// Frames in the envelope: 4 s at 30 Hz. A clock drift of 100 ppm moves it by 0.4 ms.
  static constexpr std::size_t kFrames = 120;

 private:
  std::deque<double> delays_s_;  ///< arrival - stream time
};

}  // namespace airclay
