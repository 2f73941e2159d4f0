// SPDX-License-Identifier: MIT
// Videos of different rates, with dropped frames, start offsets or rotation metadata. Each image shows its
// own time.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "capture/images/quiet_opencv.h"
#include "capture/images/video_index.h"
#include "capture/images/video_reader.h"
#include "capture/takes/image_sets.h"
#include "capture/takes/take.h"
#include "tests/support/remux.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr int kWidth = 64, kHeight = 48;

/// The grey level of an image taken at `time_s`; 30 Hz frames differ by 4.
int greyAt(double time_s) {
  return 20 + static_cast<int>(std::lround(120 * time_s));
}
// Motion JPEG changes a level by at most 1.
constexpr int kGreyLoss = 1;

/// Motion JPEG, so that each packet can be decoded on its own; at `rate_hz`, from `start_s` on.
void writeVideo(const std::filesystem::path& file, double rate_hz, int frames, double start_s = 0) {
  quietOpenCv();
  cv::VideoWriter writer(file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz,
                         {kWidth, kHeight});
  ASSERT_TRUE(writer.isOpened());
  for (int k = 0; k < frames; ++k)
    writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(greyAt(start_s + k / rate_hz))));
}

class VideoTimes : public testing::Test {
 protected:
  void SetUp() override {
    Rig rig = ringRig(4, kWidth, kHeight);
    writeRig(folder / "rig.toml", rig);
    for (const Camera& camera : rig.cameras) names.push_back(camera.name);
  }
  std::filesystem::path video(int camera) const { return folder / (names[std::size_t(camera)] + ".mkv"); }
  std::filesystem::path scratch(const std::string& name) const { return folder / name; }

  /// Reads the frame; every present camera must show the time of its image.
  void expectTimesShown(Take& take, int frame, double tolerance_s) {
    std::vector<std::vector<std::uint8_t>> bytes(4, std::vector<std::uint8_t>(3 * kWidth * kHeight));
    std::vector<std::span<std::uint8_t>> spans(bytes.begin(), bytes.end());
    ASSERT_TRUE(take.readImages(frame, spans));
    for (std::size_t c = 0; c < 4; ++c) {
      if (take.missingCameras() >> c & 1) continue;
      const double shown_s = (bytes[c][0] - 20) / 120.0;
      EXPECT_NEAR(shown_s, take.timeOf(frame), tolerance_s + kGreyLoss / 120.0)
          << "camera " << c << ", frame " << frame;
    }
  }

  TemporaryFolder folder;
  std::vector<std::string> names;
};

TEST_F(VideoTimes, EqualVideosAreMatchedByNumber) {
  for (int c = 0; c < 4; ++c) writeVideo(video(c), 30, 12);
  Take take(folder.path());
  EXPECT_EQ(take.frameCount(), 12);
  EXPECT_FALSE(take.note());
  EXPECT_TRUE(take.cameraTimesOf(3).empty());
  for (int frame = 0; frame < 12; ++frame) {
    EXPECT_DOUBLE_EQ(take.timeOf(frame), frame / 30.0);
    expectTimesShown(take, frame, 0.001);
    EXPECT_EQ(take.missingCameras(), 0u);
  }
}

TEST_F(VideoTimes, SlowerCameraIsMissingInEveryOtherFrame) {
  for (int c = 0; c < 3; ++c) writeVideo(video(c), 30, 31);
  writeVideo(video(3), 15, 16);
  Take take(folder.path());
  ASSERT_EQ(take.frameCount(), 31);
  EXPECT_NEAR(take.rateHz(), 30, 0.1);
  ASSERT_TRUE(take.note());
  EXPECT_NE(take.note()->find("camera \"" + names[3] + "\" has no image in 15"), std::string::npos)
      << *take.note();
  for (int frame = 0; frame < 31; ++frame) {
    expectTimesShown(take, frame, 0.002);
    EXPECT_EQ(take.missingCameras(), frame % 2 == 0 ? 0u : 8u) << frame;
    EXPECT_NEAR(take.timeOf(frame), frame / 30.0, 0.001);
  }
}

TEST_F(VideoTimes, DroppedFrameIsMissingAndShiftsNothing) {
  for (int c = 0; c < 3; ++c) writeVideo(video(c), 30, 30);
  writeVideo(scratch("whole.mkv"), 30, 30);
  remuxVideo(scratch("whole.mkv"), video(3), {.keep = [](int k) { return k != 10 && k != 11 && k != 20; }});
  EXPECT_EQ(missingFrames(readVideoIndex(video(3)).times_s), 3);
  Take take(folder.path());
  ASSERT_EQ(take.frameCount(), 30);
  for (int frame = 0; frame < 30; ++frame) {
    expectTimesShown(take, frame, 0.002);
    EXPECT_EQ(take.missingCameras(), frame == 10 || frame == 11 || frame == 20 ? 8u : 0u) << frame;
  }
  // out of order, too
  expectTimesShown(take, 25, 0.002);
  expectTimesShown(take, 9, 0.002);
}

TEST_F(VideoTimes, VariableFrameRateIsFollowed) {
  // a camera that lengthens its exposure: 30 Hz, then 25 Hz
  const auto time_s = [](int k) { return k < 15 ? k / 30.0 : 15 / 30.0 + (k - 15) / 25.0; };
  for (int c = 0; c < 3; ++c) writeVideo(video(c), 30, 34);
  quietOpenCv();
  {
    cv::VideoWriter writer(scratch("variable.mkv").string(), cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, {kWidth, kHeight});
    for (int k = 0; k < 31; ++k)
      writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(greyAt(time_s(k)))));
  }
  remuxVideo(scratch("variable.mkv"), video(3), {.time_s = time_s});
  Take take(folder.path());
  ASSERT_EQ(take.frameCount(), 34);
  int missing = 0;
  for (int frame = 0; frame < 34; ++frame) {
    expectTimesShown(take, frame, 0.5 / 30);
    missing += take.missingCameras() == 8;
  }
  EXPECT_EQ(missing, 3);  // 19 instants at 30 Hz, 16 images at 25 Hz
}

TEST_F(VideoTimes, OffsetMovesACamerasTimes) {
  // the last camera started 0.3 s later, so that its times are 0.3 s too early
  for (int c = 0; c < 3; ++c) writeVideo(video(c), 30, 40);
  writeVideo(video(3), 30, 31, 0.3);
  TakeOptions options;
  options.offsets_s[names[3]] = -0.3;
  Take take(folder.path(), options);
  ASSERT_EQ(take.frameCount(), 31);
  for (int frame = 0; frame < 31; ++frame) {
    expectTimesShown(take, frame, 0.002);
    EXPECT_EQ(take.missingCameras(), 0u) << frame;
  }
  options.offsets_s["nobody"] = 1;
  EXPECT_NE(messageOf([&] { Take(folder.path(), options); }).find("\"nobody\""), std::string::npos);
  TakeOptions apart;
  apart.offsets_s[names[3]] = 10;
  EXPECT_NE(messageOf([&] { Take(folder.path(), apart); }).find("--offset"), std::string::npos);
}

TEST_F(VideoTimes, TimestampsFileAndOffsetMatchAgain) {
  for (int c = 0; c < 4; ++c) writeVideo(video(c), 30, 30, c == 3 ? -0.1 : 0.0);
  std::string rows = "cam_id,frame_time\n";
  for (int k = 0; k < 30; ++k)
    for (int c = 0; c < 4; ++c) rows += names[std::size_t(c)] + "," + std::to_string(5 + k / 30.0) + "\n";
  folder.write("timestamps.csv", rows);
  Take plain(folder.path());
  EXPECT_EQ(plain.frameCount(), 30);
  TakeOptions options;
  options.offsets_s[names[3]] = 0.1;  // late: what it shows was taken 0.1 s before
  Take take(folder.path(), options);
  ASSERT_EQ(take.frameCount(), 27);
  std::vector<std::vector<std::uint8_t>> bytes(4, std::vector<std::uint8_t>(3 * kWidth * kHeight));
  std::vector<std::span<std::uint8_t>> spans(bytes.begin(), bytes.end());
  ASSERT_TRUE(take.readImages(4, spans));
  EXPECT_NEAR(bytes[3][0], bytes[0][0], 2 * kGreyLoss);
}

TEST_F(VideoTimes, RotationMetadataIsApplied) {
  quietOpenCv();
  {
    cv::VideoWriter writer(scratch("upright.mkv").string(), cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, {kWidth, kHeight});
    cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar::all(40));
    image(cv::Rect(0, 0, kWidth / 2, kHeight / 2)).setTo(cv::Scalar::all(220));  // top left
    for (int k = 0; k < 3; ++k) writer.write(image);
  }
  const auto brightCorner = [](FrameSource& source) {
    const ImageSize size = source.size();
    cv::Mat image(size.height, size.width, CV_8UC3);
    source.read(1, {image.data, image.total() * 3});
    const auto bright = [&](int x, int y) { return image.at<cv::Vec3b>(y, x)[0] > 130; };
    const int right = size.width - 4, bottom = size.height - 4;
    return std::string(bright(4, 4) ? "top left" : "") + (bright(right, 4) ? "top right" : "") +
           (bright(4, bottom) ? "bottom left" : "") + (bright(right, bottom) ? "bottom right" : "");
  };
  const struct {
    int degrees;
    const char* corner;
  } cases[] = {{0, "top left"}, {90, "top right"}, {180, "bottom right"}, {270, "bottom left"}};
  for (const auto& [degrees, corner] : cases) {
    SCOPED_TRACE(degrees);
    remuxVideo(scratch("upright.mkv"), scratch("turned.mp4"), {.rotation_degrees = degrees});
    EXPECT_EQ(readVideoIndex(scratch("turned.mp4")).rotation_degrees, degrees);
    const auto source = openFrames(folder.path(), "turned");
    EXPECT_EQ(source->size(), (degrees % 180 == 0 ? ImageSize{kWidth, kHeight} : ImageSize{kHeight, kWidth}));
    EXPECT_EQ(brightCorner(*source), corner);
  }
}

TEST(ImageSets, CamerasThatDriftApartStayMatched) {
  // 30 and 29 Hz for ten seconds: each image of the slower one is used once
  std::vector<std::vector<double>> times(3);
  for (int k = 0; k < 300; ++k) times[0].push_back(k / 30.0), times[1].push_back(k / 30.0 + 0.004);
  for (int k = 0; k < 290; ++k) times[2].push_back(k / 29.0);
  EXPECT_FALSE(matchesByNumber(times));
  const std::vector<ImageSet> sets = matchImages(times);
  EXPECT_GE(sets.size(), 295u);
  std::vector<int> used(290);
  for (const ImageSet& set : sets) {
    if (!(set.missing_cameras >> 2 & 1)) ++used[std::size_t(set.images[2])];
    for (std::size_t c = 0; c < 3; ++c) {
      if (set.missing_cameras >> c & 1) continue;
      EXPECT_LE(std::abs(times[c][std::size_t(set.images[c])] - set.times_s[0]), 0.5 / 29);
    }
  }
  EXPECT_LE(*std::ranges::max_element(used), 1);
  EXPECT_GE(std::ranges::count(used, 1), 280);
}

}  // namespace
}  // namespace airclay
