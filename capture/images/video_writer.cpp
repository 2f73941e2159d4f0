// SPDX-License-Identifier: MIT
// H.264 through OpenCV's FFmpeg backend.
#include "capture/images/video_writer.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "capture/images/quiet_opencv.h"
#include "engine/core/error.h"

namespace airclay {

struct VideoWriter::Parts {
  std::filesystem::path file, unfinished;  // `unfinished` is next to `file` until finish()
  Options options;
  cv::VideoWriter video;
  cv::Mat bgr;
  int frame_count = 0;

  ~Parts() {
    video.release();
    std::error_code ignored;  // it may not exist, or already be renamed
    std::filesystem::remove(unfinished, ignored);
  }
};

VideoWriter::VideoWriter(const std::filesystem::path& file, const Options& options)
    : parts_(std::make_unique<Parts>()) {
  quietOpenCv();
  const auto fits = [](int side) { return side >= 16 && side <= 16384 && side % 2 == 0; };
  if (file.extension() != ".mp4")
    throw Error(file.string() + ": videos are written as H.264 in MP4; expected a name that ends in .mp4");
  if (!fits(options.size.width) || !fits(options.size.height))
    throw Error(file.string() + ": a video of " + std::to_string(options.size.width) + " x " +
                std::to_string(options.size.height) + " pixels; expected even sides from 16 to 16384");
  if (!(options.rate_hz > 0 && options.rate_hz <= 1000))
    throw Error(file.string() + ": a video's rate must be above 0 and at most 1000 Hz");
  parts_->file = file;
  parts_->unfinished = file.parent_path() / (file.stem().string() + ".unfinished.mp4");
  parts_->options = options;
  const cv::Size size(options.size.width, options.size.height);
  const int h264 = cv::VideoWriter::fourcc('a', 'v', 'c', '1');
  if (!parts_->video.open(parts_->unfinished.string(), cv::CAP_FFMPEG, h264, options.rate_hz, size))
    throw Error(
        file.string() +
        ": the video cannot be written; expected an existing, writable folder and an OpenCV whose FFmpeg "
        "has libx264");
  parts_->bgr.create(size, CV_8UC3);
}

VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::write(std::span<const std::uint8_t> pixels) {
  const ImageSize size = parts_->options.size;
  const bool is_bgr = parts_->options.format == Format::kBgr8;
  const size_t pixel_count = static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
  if (pixels.size() != pixel_count * static_cast<size_t>(parts_->options.format))
    throw std::logic_error("VideoWriter: the image does not have the video's size and format");
  // OpenCV only reads the data, but cv::Mat cannot wrap const memory.
  const cv::Mat image(size.height, size.width, is_bgr ? CV_8UC3 : CV_8UC4,
                      const_cast<std::uint8_t*>(pixels.data()));
  if (!is_bgr) cv::cvtColor(image, parts_->bgr, cv::COLOR_RGBA2BGR);
  parts_->video.write(is_bgr ? image : parts_->bgr);
  ++parts_->frame_count;
}

void VideoWriter::finish() {
  parts_->video.release();
  // OpenCV does not report write errors, so check that the file is complete.
  cv::VideoCapture check(parts_->unfinished.string(), cv::CAP_FFMPEG);
  const double found = check.isOpened() ? check.get(cv::CAP_PROP_FRAME_COUNT) : 0;
  if (found != parts_->frame_count || parts_->frame_count == 0)
    throw Error(parts_->file.string() + ": the video could not be written completely (" +
                std::to_string(found > 0 ? static_cast<int>(found) : 0) + " of " +
                std::to_string(parts_->frame_count) + " frames); free some disk space");
  check.release();
  std::error_code error;
  std::filesystem::rename(parts_->unfinished, parts_->file, error);
  if (error) throw Error(parts_->file.string() + ": the video cannot be renamed: " + error.message());
}

}  // namespace airclay
