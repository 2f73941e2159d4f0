// SPDX-License-Identifier: MIT
// Sources through OpenCV: V4L2 and FFmpeg (files and streams). Numbered images use image_file.h; RTSP and
// pipelines use gstreamer_source.h.
#include "capture/cameras/camera_source.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <map>
#include <mutex>
#include <opencv2/videoio.hpp>

#include "capture/cameras/gstreamer_source.h"
#include "capture/images/quiet_opencv.h"
#include "capture/images/video_reader.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// For sources that declare no rate: the rate of ordinary cameras.
constexpr double kDefaultRateHz = 30;
// A stream that is silent for this long is lost, and is then reopened.
constexpr int kOpenTimeoutMs = 4000, kReadTimeoutMs = 2000;
// A file that begins later than this was restarted and does not catch up.
constexpr double kMaxDelayS = 1;
// A driver's buffer times are plausible if they precede the arrival by at most this.
constexpr double kPlausibleBufferAgeS = 1;

/// "camera "left" (rtsp://…): "
std::string where(const NamedSource& camera) {
  return "camera \"" + camera.name + "\" (" + camera.source.text + "): ";
}

double saneRate(double rate_hz) {
  return rate_hz > 0 && rate_hz <= 1000 ? rate_hz : kDefaultRateHz;
}

// ------------------------------------------------------------------------------------------ devices, streams

/// Devices and streams, which set the pace themselves.
class StreamSource : public CameraSource {
 public:
  StreamSource(const NamedSource& camera, const SourceOptions& options) : camera_(camera) {
    quietOpenCv();
    if (camera.source.kind == SourceKind::kDevice)
      openDevice(options);
    else
      openStream();
    size_ = {static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
             static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
    rate_hz_ = saneRate(video_.get(cv::CAP_PROP_FPS));
  }

  ImageSize size() const override { return size_; }
  double rateHz() const override { return rate_hz_; }
  TimeOrigin times() const override { return times_; }

  bool read(LiveImage& image, double& capture_s) override {
    cv::Mat decoded;
    if (!video_.grab())
      throw Error(where(camera_) + "no more images arrive (unplugged, ended, or the network failed)");
    const double arrival_s = secondsNow();
    capture_s = captureTime(arrival_s);
    if (!video_.retrieve(decoded) || decoded.empty() || decoded.type() != CV_8UC3)
      throw Error(where(camera_) + "an image cannot be decoded; expected 8-bit colour");
    image.size = {decoded.cols, decoded.rows};
    if (image.size != size_)
      throw Error(where(camera_) + "the image's size changed to " + std::to_string(decoded.cols) + " x " +
                  std::to_string(decoded.rows) + "; expected the same size throughout");
    image.bgr.resize(decoded.total() * 3);
    decoded.copyTo(cv::Mat(decoded.rows, decoded.cols, CV_8UC3, image.bgr.data()));
    return true;
  }

 private:
  void openDevice(const SourceOptions& options) {
    // OpenCV waits 10 s for a silent device by default; it reads this variable once, at the first device.
    setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "2", 0);
    const std::string& device = camera_.source.text;
    if (!video_.open(device, cv::CAP_V4L2))
      throw Error(where(camera_) +
                  "the device cannot be opened (missing, or used by another program); expected one that "
                  "`airclay cameras` lists");
    // In this order: the available sizes depend on the format, and the rates on the size.
    if (!options.format.empty()) {
      const std::string& f = options.format;
      ask(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc(f[0], f[1], f[2], f[3]), "pixel format " + f);
    }
    if (options.size) {
      ask(cv::CAP_PROP_FRAME_WIDTH, options.size->width, "width " + std::to_string(options.size->width));
      ask(cv::CAP_PROP_FRAME_HEIGHT, options.size->height, "height " + std::to_string(options.size->height));
    }
    if (options.rate_hz) video_.set(cv::CAP_PROP_FPS, *options.rate_hz);
    // V4L2_EXPOSURE_MANUAL is 1 (videodev2.h); OpenCV passes the number on.
    if (options.exposure) {
      video_.set(cv::CAP_PROP_AUTO_EXPOSURE, 1);
      ask(cv::CAP_PROP_EXPOSURE, *options.exposure, "a locked exposure");
    }
    if (options.gain) ask(cv::CAP_PROP_GAIN, *options.gain, "a locked gain");
    times_ = TimeOrigin::kBuffer;
  }

  void ask(int property, double value, const std::string& setting) {
    if (!video_.set(property, value) || std::abs(video_.get(property) - value) > 0.5)
      throw Error(where(camera_) + "the device does not support " + setting +
                  "; use a mode that `airclay cameras` lists");
  }

  void openStream() {
    const std::vector<int> timeouts = {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, kOpenTimeoutMs,
                                       cv::CAP_PROP_READ_TIMEOUT_MSEC, kReadTimeoutMs};
    if (!video_.open(camera_.source.text, cv::CAP_FFMPEG, timeouts))
      throw Error(where(camera_) +
                  "no stream answers there; expected the address of a running camera or server");
  }

  double captureTime(double arrival_s) {
    const double stream_s = video_.get(cv::CAP_PROP_POS_MSEC) / 1000;
    if (times_ == TimeOrigin::kBuffer) {
      const double age_s = arrival_s - stream_s;
      if (age_s >= 0 && age_s <= kPlausibleBufferAgeS) return stream_s;
      times_ = TimeOrigin::kArrival;  // another clock, not comparable with other cameras
    }
    // MJPEG over HTTP has no times, or frame counts; times that do not increase are ignored.
    const bool grows = std::isfinite(stream_s) && stream_s > last_stream_s_;
    last_stream_s_ = stream_s;
    return grows && camera_.source.kind == SourceKind::kStream ? clock_.captureOf(arrival_s, stream_s)
                                                               : arrival_s;
  }

  NamedSource camera_;
  cv::VideoCapture video_;
  ImageSize size_;
  double rate_hz_ = kDefaultRateHz;
  TimeOrigin times_ = TimeOrigin::kArrival;
  double last_stream_s_ = 0;
  ArrivalClock clock_;
};

// -------------------------------------------------------------------------------------------------- files

/// Files, played in real time: frame k is due at start + k / rate.
class PacedSource : public CameraSource {
 public:
  PacedSource(const NamedSource& camera, bool loop) : camera_(camera), loop_(loop) {}

  TimeOrigin times() const override { return TimeOrigin::kFile; }

  void begin(Clock::time_point start) override {
    // A thread that is slightly late catches up, so that frame k of all files has the same time.
    const double passed_s = secondsBetween(start, Clock::now());
    const double frames = passed_s > kMaxDelayS ? std::ceil(passed_s * rateHz()) : 0;
    start_s_ = std::chrono::duration<double>(start.time_since_epoch()).count() + frames / rateHz();
    played_ = 0;
  }

  bool read(LiveImage& image, double& capture_s) override {
    if (start_s_ < 0) begin(Clock::now());
    capture_s = start_s_ + static_cast<double>(played_) / rateHz();
    if (!waitUntil(capture_s)) return false;
    if (!step(image) && !(loop_ && played_ > 0 && rewind() && step(image))) return false;
    ++played_;
    return true;
  }

  void stop() override {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

 protected:
  /// Reads the next frame; false at the end.
  virtual bool step(LiveImage& image) = 0;
  virtual bool rewind() = 0;

  NamedSource camera_;

 private:
  bool waitUntil(double due_s) {
    std::unique_lock lock(mutex_);
    const std::chrono::duration<double> wait(due_s - secondsNow());
    changed_.wait_for(lock, wait, [&] { return stopped_; });
    return !stopped_;
  }

  bool loop_;
  double start_s_ = -1;
  long played_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopped_ = false;
};

class VideoFileSource : public PacedSource {
 public:
  VideoFileSource(const NamedSource& camera, bool loop) : PacedSource(camera, loop) {
    quietOpenCv();
    if (!rewind())
      throw Error(
          where(camera) +
          "the video cannot be opened (missing, damaged or of unknown format); expected a video file");
    size_ = {static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
             static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
    rate_hz_ = saneRate(video_.get(cv::CAP_PROP_FPS));
    if (!grabbed_) throw Error(where(camera) + "the video has no frame that can be decoded");
  }
  ImageSize size() const override { return size_; }
  double rateHz() const override { return rate_hz_; }

 private:
  /// Decodes the first frame at once, because decoders start slowly and would then be late for a long time.
  bool rewind() override {
    if (!video_.open(camera_.source.text, cv::CAP_FFMPEG)) return false;
    grabbed_ = video_.grab();
    return true;
  }

  bool step(LiveImage& image) override {
    if (!grabbed_ && !video_.grab()) return false;
    grabbed_ = false;
    image.size = size_;
    image.bgr.resize(3 * std::size_t(size_.width) * std::size_t(size_.height));
    cv::Mat target(size_.height, size_.width, CV_8UC3, image.bgr.data());
    cv::Mat decoded = target;  // the decoder writes to it if size and type match
    if (!video_.retrieve(decoded) || decoded.size() != target.size() || decoded.type() != target.type())
      throw Error(where(camera_) +
                  "a frame cannot be decoded or has another size; expected a complete recording of one size");
    if (decoded.data != target.data) decoded.copyTo(target);
    return true;
  }

  cv::VideoCapture video_;
  ImageSize size_;
  double rate_hz_ = kDefaultRateHz;
  bool grabbed_ = false;  ///< the next frame has been decoded
};

/// The existing images that match a pattern, by number.
std::vector<std::filesystem::path> imagesOf(const std::filesystem::path& pattern) {
  const std::string name = pattern.filename().string();
  const std::size_t percent = name.find('%'), end = name.find('d', percent);
  const std::string before = name.substr(0, percent), after = name.substr(end + 1);
  std::map<long, std::filesystem::path> found;
  std::error_code error;
  const std::filesystem::path folder = pattern.has_parent_path() ? pattern.parent_path() : ".";
  for (std::filesystem::directory_iterator at(folder, error), stop; !error && at != stop;
       at.increment(error)) {
    const std::string file = at->path().filename().string();
    if (file.size() <= before.size() + after.size() || !file.starts_with(before) || !file.ends_with(after))
      continue;
    const std::string number = file.substr(before.size(), file.size() - before.size() - after.size());
    if (number.size() <= 9 && number.find_first_not_of("0123456789") == std::string::npos)
      found[std::stol(number)] = at->path();
  }
  std::vector<std::filesystem::path> files;
  for (const auto& [number, file] : found) files.push_back(file);
  return files;
}

class ImagesSource : public PacedSource {
 public:
  ImagesSource(const NamedSource& camera, const SourceOptions& options)
      : PacedSource(camera, options.loop), rate_hz_(saneRate(options.rate_hz.value_or(kDefaultRateHz))) {
    const std::filesystem::path place = camera.source.text;
    if (std::filesystem::is_directory(place))
      for (const auto& [number, file] : numberedImages(place)) files_.push_back(file);
    else
      files_ = imagesOf(place);
    if (files_.empty())
      throw Error(
          where(camera) +
          "there are no such images; expected a folder with 000000.png (or .jpg), …, or a pattern such "
          "as img_%04d.png");
    size_ = imageSize(files_.front());
  }
  ImageSize size() const override { return size_; }
  double rateHz() const override { return rate_hz_; }

 private:
  bool rewind() override {
    next_ = 0;
    return true;
  }
  bool step(LiveImage& image) override {
    if (next_ >= files_.size()) return false;
    const std::filesystem::path& file = files_[next_++];
    image.size = size_;
    image.bgr.resize(3 * std::size_t(size_.width) * std::size_t(size_.height));
    try {
      readImage(file, size_, PixelFormat::kBgr8, image.bgr);
    } catch (const Error& error) {
      throw Error(where(camera_) + error.what());
    }
    return true;
  }

  std::vector<std::filesystem::path> files_;
  std::size_t next_ = 0;
  ImageSize size_;
  double rate_hz_;
};

}  // namespace

std::unique_ptr<CameraSource> openSource(const NamedSource& camera, const SourceOptions& options) {
  if (!options.format.empty() && options.format.size() != 4)
    throw Error("a pixel format has four letters; expected one such as MJPG or YUYV", Fault::kUsage);
  switch (camera.source.kind) {
    case SourceKind::kVideo:
      return std::make_unique<VideoFileSource>(camera, options.loop);
    case SourceKind::kImages:
      return std::make_unique<ImagesSource>(camera, options);
    case SourceKind::kPipeline:
      return openGStreamerSource(camera);
    default:
      if (camera.source.text.starts_with("rtsp://")) return openGStreamerSource(camera);
      return std::make_unique<StreamSource>(camera, options);
  }
}

}  // namespace airclay
