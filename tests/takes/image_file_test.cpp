// SPDX-License-Identifier: MIT
// Image files of every format and depth, written by OpenCV; and damaged ones.
#include "capture/images/image_file.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "engine/core/file_io.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr ImageSize kSize{20, 12};

/// Grey values from 0 to `most`, increasing along rows and columns.
cv::Mat ramp(int type, double most) {
  cv::Mat image(kSize.height, kSize.width, CV_64F);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<double>(y, x) = most * (x + y) / (image.cols + image.rows - 2);
  cv::Mat converted;
  image.convertTo(converted, CV_MAT_DEPTH(type));
  if (CV_MAT_CN(type) == 3) cv::merge(std::vector<cv::Mat>(3, converted), converted);
  return converted;
}

std::vector<std::uint8_t> read(const std::filesystem::path& file, PixelFormat format,
                               std::optional<int> bits = std::nullopt) {
  std::vector<std::uint8_t> pixels(std::size_t(kSize.width) * std::size_t(kSize.height) *
                                   std::size_t(format));
  readImage(file, kSize, format, pixels, bits);
  return pixels;
}

void expectRamp(const std::vector<std::uint8_t>& pixels, int channels, int tolerance) {
  const cv::Mat expected = ramp(CV_8UC1, 255);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    ASSERT_NEAR(pixels[i], expected.data[i / std::size_t(channels)], tolerance) << i;
}

TEST(ImageFile, ReadsEveryFormat) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.jpg", "a.JPEG", "a.bmp", "a.tif", "a.tiff", "a.webp"})
    for (const int type : {CV_8UC1, CV_8UC3}) {
      const std::filesystem::path file = folder / name;
      ASSERT_TRUE(cv::imwrite(file.string(), ramp(type, 255)));
      EXPECT_TRUE(isImageName(name));
      EXPECT_EQ(imageSize(file), kSize) << name;
      const bool is_lossy = std::string(name).find('j') != std::string::npos ||
                            std::string(name).find('J') != std::string::npos;
      expectRamp(read(file, PixelFormat::kBgr8), 3, is_lossy ? 3 : 1);
      expectRamp(read(file, PixelFormat::kGrey8), 1, is_lossy ? 3 : 1);
    }
  EXPECT_FALSE(isImageName("a.mp4"));
}

TEST(ImageFile, ScalesDeepSamplesToEightBits) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.tif"})
    for (const int bits : {10, 12, 14, 16})
      for (const int type : {CV_16UC1, CV_16UC3}) {
        const std::filesystem::path file = folder / name;
        ASSERT_TRUE(cv::imwrite(file.string(), ramp(type, (1 << bits) - 1)));
        EXPECT_EQ(imageBits(file), bits);
        expectRamp(read(file, PixelFormat::kBgr8), 3, 1);
        expectRamp(read(file, PixelFormat::kGrey8), 1, 1);
      }
  ASSERT_TRUE(cv::imwrite((folder / "a.png").string(), ramp(CV_8UC1, 255)));
  EXPECT_EQ(imageBits(folder / "a.png"), 8);
}

/// A dark image of a camera is scaled like its other images; values that need more bits become white.
TEST(ImageFile, GivenBitsScaleEveryImageAlike) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "dark.png";
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(kSize.height, kSize.width, CV_16UC1, cv::Scalar(1000))));
  EXPECT_EQ(read(file, PixelFormat::kGrey8, 16)[0], 4);
  EXPECT_EQ(read(file, PixelFormat::kGrey8, 12)[0], 62);
  EXPECT_EQ(read(file, PixelFormat::kGrey8)[0], 249);
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(kSize.height, kSize.width, CV_16UC1, cv::Scalar(5000))));
  EXPECT_EQ(read(file, PixelFormat::kGrey8, 10)[0], 255);
}

TEST(ImageFile, ReportsTruncatedFilesOfEveryFormat) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.jpg", "a.bmp", "a.tif", "a.webp"}) {
    const std::filesystem::path file = folder / name;
    ASSERT_TRUE(cv::imwrite(file.string(), ramp(CV_8UC3, 255)));
    const std::string content = readWhole(file, 1 << 20);
    for (const std::size_t length : {content.size() / 2, content.size() - 3, std::size_t(12)}) {
      folder.write(name, content.substr(0, length));
      const std::string message = messageOf([&] { read(file, PixelFormat::kBgr8); });
      EXPECT_NE(message.find(name), std::string::npos) << name << length;
      EXPECT_NE(message.find("truncated"), std::string::npos) << name << " " << length << " " << message;
    }
  }
  folder.write("a.png", "text");
  EXPECT_NE(messageOf([&] { imageSize(folder / "a.png"); }).find("TIFF or WebP"), std::string::npos);
}

TEST(ImageFile, ReportsFloatingPointSamples) {
  const TemporaryFolder folder;
  ASSERT_TRUE(cv::imwrite((folder / "a.tif").string(), ramp(CV_32FC1, 1)));
  EXPECT_NE(messageOf([&] { read(folder / "a.tif", PixelFormat::kBgr8); }).find("8 or 16 bits"),
            std::string::npos);
}

TEST(ImageFile, PngRoundTripIsExact) {
  const TemporaryFolder folder;
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 5 * 4; ++i)
    for (const int value : {i, 50 + i, 100 + i, 255}) rgba.push_back(static_cast<std::uint8_t>(value));
  writePng(folder / "a.png", {5, 4}, rgba);
  EXPECT_EQ(imageSize(folder / "a.png"), (ImageSize{5, 4}));
  std::vector<std::uint8_t> bgr(5 * 4 * 3);
  readImage(folder / "a.png", {5, 4}, PixelFormat::kBgr8, bgr);
  for (size_t i = 0; i < 20; ++i)
    for (size_t c = 0; c < 3; ++c) ASSERT_EQ(bgr[3 * i + c], rgba[4 * i + 2 - c]);
  EXPECT_NE(messageOf([&] { writePng(folder / "none/a.png", {5, 4}, rgba); }), "");
  EXPECT_NE(messageOf([&] { writePng(folder / "b.png", {5, 5}, rgba); }), "");
}

}  // namespace
}  // namespace airclay
