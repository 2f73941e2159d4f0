// SPDX-License-Identifier: MIT
// Videos written by VideoWriter: their codec and pixels, and what remains on disk after an error.
#include "capture/images/video_writer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/videoio.hpp>

#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr int kWidth = 64, kHeight = 48;

TEST(VideoWriter, RemovesUnfinishedVideoAndReportsErrors) {
  const TemporaryFolder folder;
  { VideoWriter dropped(folder / "dropped.mp4", {{kWidth, kHeight}}); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_NE(messageOf([&] { VideoWriter(folder / "a.mp4", {{63, 48}}); }).find("even"), std::string::npos);
  EXPECT_NE(messageOf([&] { VideoWriter(folder / "a.mov", {{64, 48}}); }).find(".mp4"), std::string::npos);
  testing::internal::CaptureStderr();
  EXPECT_NE(messageOf([&] {
              VideoWriter(folder / "none/a.mp4", {{64, 48}});
            }).find("a.mp4"),
            std::string::npos);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(VideoWriter, WritesRgbaAsH264) {
  const TemporaryFolder folder;
  VideoWriter writer(folder / "red.mp4", {{kWidth, kHeight}, 24, VideoWriter::Format::kRgba8});
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kWidth * kHeight; ++i) pixels.insert(pixels.end(), {200, 40, 60, 255});
  for (int i = 0; i < 3; ++i) writer.write(pixels);
  writer.finish();
  cv::VideoCapture video((folder / "red.mp4").string(), cv::CAP_FFMPEG);
  const int codec = static_cast<int>(video.get(cv::CAP_PROP_FOURCC));
  EXPECT_TRUE(codec == cv::VideoWriter::fourcc('a', 'v', 'c', '1') ||
              codec == cv::VideoWriter::fourcc('h', '2', '6', '4'));
  const int format = static_cast<int>(video.get(cv::CAP_PROP_CODEC_PIXEL_FORMAT));
  EXPECT_EQ(format, cv::VideoWriter::fourcc('I', '4', '2', '0'));  // FFmpeg's tag of yuv420p
  cv::Mat frame;
  ASSERT_TRUE(video.read(frame));
  const cv::Vec3b pixel = frame.at<cv::Vec3b>(20, 30);
  EXPECT_NEAR(pixel[2], 200, 4);
  EXPECT_NEAR(pixel[1], 40, 4);
  EXPECT_NEAR(pixel[0], 60, 4);
}

}  // namespace
}  // namespace airclay
