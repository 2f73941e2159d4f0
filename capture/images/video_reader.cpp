// SPDX-License-Identifier: MIT
// Videos through OpenCV's FFmpeg backend, images through image_file.h.
#include "capture/images/video_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "capture/images/quiet_opencv.h"
#include "capture/images/video_index.h"
#include "engine/camera/camera_name.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// For images, and for videos without a rate: the rate of ordinary cameras.
constexpr double kDefaultRateHz = 30;
// Nine hours at 30 Hz; a larger number in a file name is not a frame number.
constexpr int kMaxFrame = 1'000'000;

class VideoSource : public FrameSource {
 public:
  VideoSource(const std::filesystem::path& file, bool unfinished) : file_(file), unfinished_(unfinished) {
    quietOpenCv();
    open();
    index_ = readVideoIndex(file_);
    size_ = {static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
             static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
    if (index_.rotation_degrees % 180 != 0) std::swap(size_.width, size_.height);
    const double rate = video_.get(cv::CAP_PROP_FPS);
    rate_hz_ = rate > 0 && rate <= 1000 ? rate : kDefaultRateHz;
    frame_count_ = countFrames();
    if (frame_count_ < 1) throw Error(file_.string() + ": the video has no frame that can be decoded");
  }

  ImageSize size() const override { return size_; }
  int frameCount() const override { return frame_count_; }
  double rateHz() const override { return rate_hz_; }
  const std::vector<double>& timesS() const override { return index_.times_s; }
  std::string pixelFormat() const override {
    return index_.pixel_format.empty() ? ""
                                       : index_.pixel_format + ", " + std::to_string(index_.bits) + " bits";
  }

  void read(int frame, std::span<std::uint8_t> bgr) override {
    if (frame + 1 < next_) open();  // the last frame can be retrieved again
    for (; next_ <= frame; ++next_)
      if (!video_.grab()) failAt(next_, frame_count_);
    cv::Mat target(size_.height, size_.width, CV_8UC3, bgr.data());
    if (index_.rotation_degrees != 0) return readRotated(frame, target);
    cv::Mat image = target;  // the decoder writes to it if size and type match
    if (!video_.retrieve(image)) failAt(frame, frame_count_);
    if (image.size() != target.size() || image.type() != target.type())
      throw Error(file_.string() + ": frame " + std::to_string(frame) + " is " + std::to_string(image.cols) +
                  " x " + std::to_string(image.rows) + " pixels; expected the same size in all frames");
    if (image.data != target.data) image.copyTo(target);
  }

 private:
  void open() {
    next_ = 0;
    if (!video_.open(file_.string(), cv::CAP_FFMPEG))
      throw Error(
          file_.string() +
          ": the video cannot be opened (truncated, damaged or of unknown format); expected a complete "
          "recording");
    video_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);  // builds of OpenCV differ: readRotated() rotates
  }

  /// Cameras are calibrated with images as players show them, so a frame is rotated as the file asks.
  void readRotated(int frame, cv::Mat& target) {
    cv::Mat stored, image;
    if (!video_.retrieve(stored)) failAt(frame, frame_count_);
    cv::rotate(stored, image,
               index_.rotation_degrees == 90    ? cv::ROTATE_90_CLOCKWISE
               : index_.rotation_degrees == 180 ? cv::ROTATE_180
                                                : cv::ROTATE_90_COUNTERCLOCKWISE);
    if (image.size() != target.size() || image.type() != target.type()) failAt(frame, frame_count_);
    image.copyTo(target);
  }

  /// The number of frames, counted by packets: the count that a container declares may be derived from its
  /// duration. If there are fewer packets and their times do not reach the declared end, the recording is
  /// truncated.
  int countFrames() const {
    const double declared = video_.get(cv::CAP_PROP_FRAME_COUNT);
    const bool is_known = declared >= 1 && declared < kMaxFrame;
    const int frames = index_.frames, expected = is_known ? static_cast<int>(std::lround(declared)) : frames;
    if (unfinished_ || frames >= expected - 1 || frames == 0) return frames;
    // The last frame lasts an interval; half an interval more allows for a variable rate.
    const std::vector<double>& times_s = index_.times_s;
    const double interval_s = frames > 1 && !times_s.empty() ? times_s.back() / (frames - 1) : 1 / rate_hz_;
    const double reached_s = (times_s.empty() ? frames / rate_hz_ : times_s.back()) + 1.5 * interval_s;
    if (reached_s < expected / rate_hz_) failAt(frames, expected);
    return frames;
  }

  [[noreturn]] void failAt(int frame, int declared) const {
    throw Error(file_.string() + ": decoding fails at frame " + std::to_string(frame) + " of the " +
                std::to_string(declared) + " that the video declares; expected a complete recording");
  }

  std::filesystem::path file_;
  bool unfinished_;
  VideoIndex index_;
  cv::VideoCapture video_;
  ImageSize size_;
  double rate_hz_ = kDefaultRateHz;
  int frame_count_ = 0;
  int next_ = 0;  // the frame that the decoder returns next
};

class ImageSource : public FrameSource {
 public:
  explicit ImageSource(const std::filesystem::path& folder) : images_(numberedImages(folder)) {
    if (images_.empty())
      throw Error(folder.string() + ": the folder contains no image; expected 000000.png (or .jpg), …");
    int expected = 0;
    for (const auto& [frame, file] : images_) {
      if (frame != expected)
        throw Error(folder.string() + ": the image of frame " + std::to_string(expected) +
                    " is missing; expected numbers from 0 without gaps");
      ++expected;
    }
    size_ = imageSize(images_.at(0));
    bits_ = imageBits(images_.at(0));
  }

  ImageSize size() const override { return size_; }
  int frameCount() const override { return static_cast<int>(images_.size()); }
  std::string pixelFormat() const override { return std::to_string(bits_) + " bits"; }
  double rateHz() const override { return kDefaultRateHz; }
  const std::vector<double>& timesS() const override { return no_times_; }

  void read(int frame, std::span<std::uint8_t> bgr) override {
    readImage(images_.at(frame), size_, PixelFormat::kBgr8, bgr, bits_);
  }

 private:
  std::map<int, std::filesystem::path> images_;
  std::vector<double> no_times_;
  ImageSize size_;
  int bits_ = 8;  // per sample, of the first image: all are scaled alike
};

std::string lowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// The video of camera `name`. An exact match takes precedence over one that differs in case. \throw Error
/// for two equally good matches.
std::optional<std::filesystem::path> videoOf(const std::filesystem::path& take, const std::string& name) {
  std::vector<std::filesystem::path> exact, similar;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(take, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::filesystem::path& file = entry->path();
    std::error_code unreadable;  // a loop of symbolic links
    if (!isVideoName(file.filename().string()) || !entry->is_regular_file(unreadable)) continue;
    const std::string stem = file.stem().string();
    if (stem == name)
      exact.push_back(file);
    else if (lowerCase(stem) == lowerCase(name))
      similar.push_back(file);
  }
  std::vector<std::filesystem::path>& found = exact.empty() ? similar : exact;
  if (found.empty()) return std::nullopt;
  std::sort(found.begin(), found.end());
  if (found.size() > 1)
    throw Error(found[0].string() + ": camera \"" + name + "\" has a second video, " +
                found[1].filename().string() + "; expected one video per camera");
  return found[0];
}

}  // namespace

std::unique_ptr<FrameSource> openFrames(const std::filesystem::path& take, const std::string& name,
                                        bool unfinished) {
  if (const auto video = videoOf(take, name)) return std::make_unique<VideoSource>(*video, unfinished);
  const std::filesystem::path folder = take / name;
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return std::make_unique<ImageSource>(folder);
  if (error == std::errc::too_many_symbolic_link_levels)
    throw Error(folder.string() + ": a loop of symbolic links; expected a folder with images");
  return nullptr;
}

std::map<int, std::filesystem::path> numberedImages(const std::filesystem::path& folder) {
  std::map<int, std::filesystem::path> images;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    const bool is_image = isImageName(entry.path().filename().string());
    if (!is_image || stem.empty() || stem.find_first_not_of("0123456789") != std::string::npos) continue;
    int frame = 0;
    const std::from_chars_result result = std::from_chars(stem.data(), stem.data() + stem.size(), frame);
    if (result.ec != std::errc() || frame > kMaxFrame)
      throw Error(entry.path().string() + ": the frame number is larger than " + std::to_string(kMaxFrame));
    const auto [place, is_new] = images.emplace(frame, entry.path());
    if (!is_new)
      throw Error(entry.path().string() + ": frame " + std::to_string(frame) + " exists twice, also as " +
                  place->second.filename().string());
  }
  return images;
}

}  // namespace airclay
