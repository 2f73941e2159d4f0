// SPDX-License-Identifier: MIT
// Takes written here and read back frame by frame; and each kind of invalid take, rejected in one line that
// names the place.
#include "capture/takes/take.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "capture/images/quiet_opencv.h"
#include "capture/images/video_writer.h"
#include "capture/takes/timestamps.h"
#include "engine/core/error.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr int kWidth = 64, kHeight = 48;

const char kRig[] = R"([cam_0]
name = "left"
size = [64, 48]
matrix = [[56, 0, 31.5], [0, 56, 23.5], [0, 0, 1]]
distortions = [0, 0, 0, 0]
rotation = [[0, 1, 0], [0, 0, -1], [-1, 0, 0]]
translation = [0, 0, 1.2]

[cam_1]
name = "right"
size = [64, 48]
matrix = [[56, 0, 31.5], [0, 56, 23.5], [0, 0, 1]]
distortions = [0, 0, 0, 0]
rotation = [[-1, 0, 0], [0, 0, -1], [0, -1, 0]]
translation = [0, 0, 1.2]

[metadata]
units = "m"
)";

/// The grey level of a camera's frame: distinguishes frames despite a lossy codec.
int greyOf(int camera, int frame) {
  return 20 + 100 * camera + 16 * frame;
}
// Less than half the difference between frames; H.264 with limited-range YUV loses up to 5.
constexpr int kGreyLoss = 7;

void writeVideo(const std::filesystem::path& file, int camera, int frames, ImageSize size = {kWidth, kHeight},
                double rate_hz = 25) {
  VideoWriter writer(file, {size, rate_hz, VideoWriter::Format::kBgr8});
  std::vector<std::uint8_t> pixels(static_cast<size_t>(size.width * size.height * 3));
  for (int frame = 0; frame < frames; ++frame) {
    std::fill(pixels.begin(), pixels.end(), static_cast<std::uint8_t>(greyOf(camera, frame)));
    writer.write(pixels);
  }
  writer.finish();
}

void writeImage(const std::filesystem::path& file, const cv::Mat& image) {
  std::filesystem::create_directories(file.parent_path());
  ASSERT_TRUE(cv::imwrite(file.string(), image));
}

cv::Mat flat(cv::Scalar color, int width = kWidth, int height = kHeight) {
  return cv::Mat(height, width, CV_8UC3, color);
}

std::string numbered(int frame) {
  const std::string digits = std::to_string(frame);
  return std::string(6 - digits.size(), '0') + digits + ".png";
}

/// A buffer per camera.
struct Frame {
  explicit Frame(const Take& take, int channels = 3) {
    for (const Camera& camera : take.rig().cameras)
      bytes.emplace_back(static_cast<size_t>(camera.width * camera.height * channels));
    for (std::vector<std::uint8_t>& of_camera : bytes) spans.emplace_back(of_camera);
  }
  std::vector<std::vector<std::uint8_t>> bytes;
  std::vector<std::span<std::uint8_t>> spans;
};

class TakeTest : public testing::Test {
 protected:
  void SetUp() override { folder.write("rig.toml", kRig); }

  void writeVideos(int left_frames = 6, int right_frames = 6) {
    writeVideo(folder / "left.mp4", 0, left_frames);
    writeVideo(folder / "right.mp4", 1, right_frames);
  }

  /// The error of opening or reading the take; "" if there is none.
  std::string fault() {
    const std::string message = messageOf([&] {
      Take take(folder.path());
      Frame frame(take), masks(take, 1);
      for (int i = 0; take.hasImages() && take.readImages(i, frame.spans); ++i) continue;
      for (int i = 0; take.hasSilhouettes() && take.readSilhouettes(i, masks.spans); ++i) continue;
    });
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }

  void expectFault(const std::vector<std::string>& mentions) {
    testing::internal::CaptureStderr();
    const std::string message = fault();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "with the error: " << message;
    EXPECT_NE(message, "");
    for (const std::string& mention : mentions)
      EXPECT_NE(message.find(mention), std::string::npos) << "\"" << mention << "\" is not in: " << message;
  }

  TemporaryFolder folder;
};

TEST_F(TakeTest, ReadsVideosFrameByFrame) {
  writeVideos();
  Take take(folder.path());
  EXPECT_EQ(take.frameCount(), 6);
  EXPECT_TRUE(take.hasImages());
  EXPECT_FALSE(take.hasSilhouettes());
  EXPECT_FALSE(take.truth());
  EXPECT_FALSE(take.note());
  EXPECT_EQ(take.backgroundFrames(), 10);
  EXPECT_NEAR(take.rateHz(), 25, 1e-9);
  EXPECT_NEAR(take.timeOf(5), 0.2, 1e-9);
  Frame frame(take);
  const auto expectFrame = [&](int number) {
    ASSERT_TRUE(take.readImages(number, frame.spans));
    for (int camera = 0; camera < 2; ++camera)
      for (const std::uint8_t value : frame.bytes[static_cast<size_t>(camera)])
        ASSERT_NEAR(value, greyOf(camera, number), kGreyLoss) << "frame " << number;
  };
  for (int number = 0; number < 6; ++number) expectFrame(number);
  EXPECT_FALSE(take.readImages(6, frame.spans));
  EXPECT_FALSE(take.readImages(-1, frame.spans));
  for (const int number : {3, 1, 5, 5, 0}) expectFrame(number);  // any order
}

TEST_F(TakeTest, ReadsImagesExactly) {
  for (int frame = 0; frame < 3; ++frame)
    for (const char* camera : {"left", "right"})
      writeImage(folder / camera / numbered(frame), flat({10.0 + frame, 20, camera[0] == 'l' ? 30.0 : 40.0}));
  writeImage(folder / "background/left.png", flat({1, 2, 3}));
  writeImage(folder / "background/right.png", flat({4, 5, 6}));
  Take take(folder.path());
  EXPECT_EQ(take.frameCount(), 3);
  EXPECT_EQ(take.rateHz(), 30);
  ASSERT_TRUE(take.hasBackground());
  EXPECT_EQ(take.backgroundFrames(), 0);
  Frame frame(take);
  ASSERT_TRUE(take.readImages(2, frame.spans));
  EXPECT_EQ(frame.bytes[0][0], 12);
  EXPECT_EQ(frame.bytes[0][1], 20);
  EXPECT_EQ(frame.bytes[0].back(), 30);
  EXPECT_EQ(frame.bytes[1].back(), 40);
  take.readBackground(frame.spans);
  EXPECT_EQ(frame.bytes[0].back(), 3);
  EXPECT_EQ(frame.bytes[1][0], 4);
}

TEST_F(TakeTest, ReadsOtherContainers) {
  quietOpenCv();
  const auto write = [&](const char* name, const char* fourcc, int camera) {
    cv::VideoWriter writer((folder / name).string(), cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc(fourcc[0], fourcc[1], fourcc[2], fourcc[3]), 20,
                           cv::Size(kWidth, kHeight));
    ASSERT_TRUE(writer.isOpened()) << name;
    for (int frame = 0; frame < 8; ++frame) writer.write(flat(cv::Scalar::all(greyOf(camera, frame))));
  };
  write("left.mkv", "avc1", 0);
  write("right.avi", "MJPG", 1);
  Take take(folder.path());
  Frame frame(take);
  int read = 0;
  while (take.readImages(read, frame.spans)) {
    EXPECT_NEAR(frame.bytes[0][99], greyOf(0, read), kGreyLoss);
    EXPECT_NEAR(frame.bytes[1][99], greyOf(1, read), kGreyLoss);
    ++read;
  }
  EXPECT_EQ(read, 8);
  EXPECT_EQ(take.frameCount(), 8);
  EXPECT_NEAR(take.rateHz(), 20, 1e-6);
}

TEST_F(TakeTest, AcceptsUpperCaseNamesAndExtensions) {
  writeVideo(folder / "a.mp4", 0, 2);
  writeVideo(folder / "b.mp4", 1, 2);
  for (const char* ending : {".MP4", ".mov", ".MOV", ".m4v"}) {
    const std::filesystem::path left = folder / ("LEFT" + std::string(ending));
    std::filesystem::copy_file(folder / "a.mp4", left);
    std::filesystem::copy_file(folder / "b.mp4", folder / "right.mp4");
    Take take(folder.path());
    Frame frame(take);
    ASSERT_TRUE(take.readImages(1, frame.spans)) << ending;
    EXPECT_NEAR(frame.bytes[0][0], greyOf(0, 1), kGreyLoss) << ending;
    EXPECT_NEAR(frame.bytes[1][0], greyOf(1, 1), kGreyLoss) << ending;
    std::filesystem::remove(left);
    std::filesystem::remove(folder / "right.mp4");
  }
  for (const char* camera : {"left", "right"}) writeImage(folder / camera / "0.png", flat({1, 2, 3}));
  std::filesystem::rename(folder / "left/0.png", folder / "left/0.PNG");
  EXPECT_EQ(Take(folder.path()).frameCount(), 1);
}

TEST_F(TakeTest, RejectsTwoVideosOfOneCamera) {
  writeVideos();
  std::filesystem::copy_file(folder / "left.mp4", folder / "LEFT.MP4");
  EXPECT_EQ(fault(), "");  // left.mp4 equals the camera's name exactly
  std::filesystem::copy_file(folder / "left.mp4", folder / "left.MOV");
  expectFault({"left", "second video", "left.mp4"});
}

TEST_F(TakeTest, ReportsRotatedRecording) {
  writeVideo(folder / "left.mp4", 0, 2, {kHeight, kWidth});
  writeVideo(folder / "right.mp4", 1, 2);
  expectFault({"left", "48 x 64", "64 x 48", "90°"});
}

TEST_F(TakeTest, AcceptsSpacesSignsAndUnicodeInNames) {
  std::string rig = kRig;
  rig.replace(rig.find("left"), 4, "Größe #1 左");
  folder.write("rig.toml", rig);
  writeVideo(folder / "a.mp4", 0, 2);
  std::filesystem::rename(folder / "a.mp4", folder / "Größe #1 左.mp4");
  writeVideo(folder / "right.mp4", 1, 2);
  std::filesystem::create_symlink("loop.mp4", folder / "loop.mp4");  // to itself: not a file
  EXPECT_EQ(fault(), "");
}

TEST_F(TakeTest, UnequalLengthsEndAtTheShortestWithANote) {
  writeVideos(7, 4);
  Take take(folder.path());
  EXPECT_EQ(take.frameCount(), 4);
  ASSERT_TRUE(take.note());
  for (const char* mention : {"left", "7", "right", "4"})
    EXPECT_NE(take.note()->find(mention), std::string::npos) << *take.note();
  EXPECT_EQ(take.note()->find('\n'), std::string::npos);
  EXPECT_EQ(fault(), "");
}

TEST_F(TakeTest, AcceptsMasksWithoutImages) {
  cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(0));
  mask.at<std::uint8_t>(5, 7) = 255;
  mask.at<std::uint8_t>(6, 7) = 128;  // a soft edge: the probability of half is kept
  mask.at<std::uint8_t>(7, 7) = 127;
  writeImage(folder / "silhouettes/left/000004.png", mask);
  std::filesystem::create_directories(folder / "silhouettes/right");
  Take take(folder.path());
  EXPECT_FALSE(take.hasImages());
  EXPECT_TRUE(take.hasSilhouettes());
  EXPECT_EQ(take.frameCount(), 5);
  EXPECT_EQ(take.backgroundFrames(), 0);
  EXPECT_NEAR(take.timeOf(3), 0.1, 1e-12);
  Frame masks(take, 1);
  ASSERT_TRUE(take.readSilhouettes(4, masks.spans));
  EXPECT_EQ(std::count(masks.bytes[0].begin(), masks.bytes[0].end(), 0), kWidth * kHeight - 3);
  EXPECT_EQ(masks.bytes[0][5 * kWidth + 7], 255);
  EXPECT_EQ(masks.bytes[0][6 * kWidth + 7], 128);
  EXPECT_EQ(masks.bytes[0][7 * kWidth + 7], 127);
  EXPECT_EQ(std::count(masks.bytes[1].begin(), masks.bytes[1].end(), 0), kWidth * kHeight);
  ASSERT_TRUE(take.readSilhouettes(0, masks.spans));
  EXPECT_EQ(std::count(masks.bytes[0].begin(), masks.bytes[0].end(), 0), kWidth * kHeight);
  EXPECT_FALSE(take.readSilhouettes(5, masks.spans));
}

TEST_F(TakeTest, FrameTimeIsTheMeanOfTheCameras) {
  writeVideos(3, 3);
  folder.write("timestamps.csv",
               "cam_id,frame_time\nleft,10.0\nright,10.2\nright,10.3\nleft,10.1\nleft,10.2\nright,10.5\n"
               "right,10.6\n");
  const Take take(folder.path());
  EXPECT_NEAR(take.timeOf(0), 10.1, 1e-12);
  EXPECT_NEAR(take.timeOf(1), 10.2, 1e-12);
  EXPECT_NEAR(take.timeOf(2), 10.35, 1e-12);
  EXPECT_NEAR(take.rateHz(), 8, 1e-9);
  EXPECT_EQ(take.cameraTimesOf(1), (std::vector<double>{10.1, 10.3}));
  EXPECT_NEAR(*skewOf(take.cameraTimesOf(2)), 0.3, 1e-12);
}

TEST_F(TakeTest, NoSkewWithoutTimestamps) {
  writeVideos(3, 3);
  const Take take(folder.path());
  EXPECT_TRUE(take.cameraTimesOf(1).empty());
  EXPECT_FALSE(skewOf(take.cameraTimesOf(1)));
}

TEST_F(TakeTest, ReadsIncompleteTake) {
  writeVideos(3, 3);
  folder.write("timestamps.csv", "cam_id,frame_time\nleft,1\nright,1\nleft,2\nright,2\nleft,2.5\nri");
  expectFault({"timestamps.csv:7:"});
  TakeOptions options;
  options.unfinished = true;
  EXPECT_EQ(Take(folder.path(), options).frameCount(), 2);
  options.max_frames = 1;
  EXPECT_EQ(Take(folder.path(), options).frameCount(), 1);
}

TEST(Timestamps, AcceptsCameraNamesAndNumbers) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& rows, const std::vector<std::string>& names) {
    const std::vector<double> times =
        readFrameTimes(folder.write("timestamps.csv", "sync_index,cam_id,frame_time\n" + rows), names, 1)[0];
    return (times.at(0) + times.at(1)) / 2;
  };
  EXPECT_EQ(read("0,0,1\n0,1,2\n", {"left", "right"}), 1.5);    // position in the rig
  EXPECT_EQ(read("0,7,1\n0,5,2\n", {"cam_5", "cam_07"}), 1.5);  // number in the name
  EXPECT_EQ(read("0,cam_07,1\n0,5,2\n", {"cam_5", "cam_07"}), 1.5);
  EXPECT_NE(messageOf([&] { read("0,0,1\n0,1,2\n", {"cam_5", "cam_07"}); }).find(":2:"), std::string::npos);
  EXPECT_NE(messageOf([&] { read("0,1,1\n0,1,2\n", {"left_1", "right_1"}); }).find(":2:"), std::string::npos);
}

TEST_F(TakeTest, ReadsTruth) {
  writeVideos(2, 2);
  folder.write("truth.tum", "0.04 0.1 0.2 0.3 0 0 0 1\n");
  const Take take(folder.path());
  ASSERT_TRUE(take.truth());
  EXPECT_EQ(take.truth()->front().world_from_hand.translation(), Vec3(0.1, 0.2, 0.3));
  folder.write("truth.tum", "0.04 0.1 0.2 0.3 0 0 0 2\n");
  expectFault({"truth.tum:1:", "quaternion"});
}

const char kIntri[] = R"(%YAML:1.0
---
names:
  - "left"
  - "right"
K_left: !!opencv-matrix
  rows: 3
  cols: 3
  dt: d
  data: [56., 0., 31.5, 0., 56., 23.5, 0., 0., 1.]
dist_left: !!opencv-matrix
  rows: 1
  cols: 5
  dt: d
  data: [-0.1, 0.02, 0.001, -0.002, 0.003]
K_right: !!opencv-matrix
  rows: 3
  cols: 3
  dt: d
  data: [57., 0., 31.5, 0., 57., 23.5, 0., 0., 1.]
dist_right: !!opencv-matrix
  rows: 5
  cols: 1
  dt: d
  data: [0., 0., 0., 0., 0.]
)";
const char kExtri[] = R"(%YAML:1.0
---
names:
  - "left"
  - "right"
R_left: !!opencv-matrix
  rows: 3
  cols: 1
  dt: d
  data: [1.2091995761561452, -1.2091995761561452, 1.2091995761561452]
T_left: !!opencv-matrix
  rows: 3
  cols: 1
  dt: d
  data: [0., 0., 1.2]
R_right: !!opencv-matrix
  rows: 3
  cols: 1
  dt: d
  data: [0., 0., 0.]
Rot_right: !!opencv-matrix
  rows: 3
  cols: 3
  dt: d
  data: [-1., 0., 0., 0., 0., -1., 0., -1., 0.]
T_right: !!opencv-matrix
  rows: 3
  cols: 1
  dt: d
  data: [0., 0., 1.2]
)";

TEST_F(TakeTest, EasyMocapRigTakesSizesFromImages) {
  std::filesystem::remove(folder / "rig.toml");
  folder.write("intri.yml", kIntri);
  folder.write("extri.yml", kExtri);
  writeVideos(2, 2);
  const Take take(folder.path());
  const std::vector<Camera>& cameras = take.rig().cameras;
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].width, kWidth);
  EXPECT_EQ(cameras[1].height, kHeight);
  EXPECT_EQ(cameras[1].lens.fx, 57);
  EXPECT_EQ(cameras[0].lens.distortion, (std::array<double, 8>{-0.1, 0.02, 0.001, -0.002, 0.003, 0, 0, 0}));
  EXPECT_TRUE(cameras[1].camera_from_world.inverse().translation().isApprox(Vec3(0, 1.2, 0), 1e-12));
  const Mat3 third = rotationFromVector(Vec3::Constant(1.2091995761561452).cwiseProduct(Vec3(1, -1, 1)));
  EXPECT_TRUE(cameras[0].camera_from_world.linear().isApprox(third, 1e-12));
}

TEST_F(TakeTest, ChecksEasyMocapRig) {
  std::filesystem::remove(folder / "rig.toml");
  writeVideos(2, 2);
  const auto changed = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  folder.write("intri.yml", kIntri);
  expectFault({"extri.yml", "missing"});
  folder.write("extri.yml", changed(kExtri, "T_right", "X_right"));
  expectFault({"extri.yml", "T_right", "missing"});
  folder.write("extri.yml", changed(kExtri, "[-1., 0., 0.,", "[1., 0., 0.,"));
  expectFault({"right", "rotation"});
  folder.write("extri.yml", changed(kExtri, "[0., 0., 1.2]", "[0., .Nan, 1.2]"));
  expectFault({"left", "translation"});
  folder.write("extri.yml", kExtri);
  folder.write("intri.yml", changed(kIntri, "K_left: !!opencv-matrix", "K_left: 7"));
  expectFault({"intri.yml"});
  folder.write("intri.yml", changed(kIntri, "names:", "cameras:"));
  expectFault({"intri.yml", "names"});
  folder.write("intri.yml", std::string(kIntri) + "W_left: 640\nH_left: 480\n");
  expectFault({"left", "640 x 480", "64 x 48"});
}

TEST_F(TakeTest, RejectsBadFolders) {
  writeVideos(2, 2);
  EXPECT_EQ(fault(), "");
  EXPECT_NE(messageOf([&] { Take take(folder / "none"); }).find("no such take"), std::string::npos);
  std::filesystem::remove(folder / "rig.toml");
  expectFault({"no rig", "rig.toml"});
  folder.write("rig.toml", kRig);
  std::filesystem::remove(folder / "right.mp4");
  expectFault({"right", "no frames"});
  std::filesystem::remove(folder / "left.mp4");
  expectFault({"left", "no frames"});
  std::filesystem::create_directories(folder / "left");
  std::filesystem::create_directories(folder / "right");
  expectFault({"left", "contains no image"});
}

TEST_F(TakeTest, RejectsBadVideos) {
  writeVideos(20, 20);
  writeVideo(folder / "right.mp4", 1, 20, {96, 48});
  expectFault({"right", "96 x 48", "64 x 48"});

  writeVideo(folder / "right.mp4", 1, 20);
  const std::filesystem::path right = folder / "right.mp4";
  std::ifstream in(right, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  folder.write("right.mp4", whole.substr(0, whole.size() / 2));  // the index, at the end, is lost
  expectFault({"right.mp4", "cannot be opened"});
  folder.write("right.mp4", "no video");
  expectFault({"right.mp4", "cannot be opened"});
  folder.write("right.mp4", "");
  expectFault({"right.mp4", "cannot be opened"});

  // The index is complete, the second half of the images is missing.
  const size_t data = whole.find("mdat"), index = whole.find("moov");
  ASSERT_LT(data, index);
  std::string gutted = whole;
  const size_t half = (data + index) / 2;
  std::fill(gutted.begin() + static_cast<long>(half), gutted.begin() + static_cast<long>(index) - 4, '\0');
  folder.write("right.mp4", gutted);
  expectFault({"right.mp4", "fails at frame", "of the 20"});
}

TEST_F(TakeTest, RejectsTruncatedMatroskaVideo) {
  quietOpenCv();
  writeVideo(folder / "left.mp4", 0, 20);
  const std::filesystem::path right = folder / "right.mkv";
  {
    cv::VideoWriter writer(right.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                           cv::Size(kWidth, kHeight));
    cv::Mat noise(kHeight, kWidth, CV_8UC3);
    for (int frame = 0; frame < 20; ++frame) {
      cv::randu(noise, 0, 255);
      writer.write(noise);
    }
  }
  EXPECT_EQ(fault(), "");
  std::filesystem::resize_file(right, std::filesystem::file_size(right) / 2);
  expectFault({"right.mkv", "fails at frame", "of the 20"});
}

TEST_F(TakeTest, RejectsBadImages) {
  for (int frame = 0; frame < 3; ++frame)
    for (const char* camera : {"left", "right"})
      writeImage(folder / camera / numbered(frame), flat({1, 2, 3}));
  EXPECT_EQ(fault(), "");
  const std::filesystem::path middle = folder / "left/000001.png";
  writeImage(middle, flat({1, 2, 3}, 65));
  expectFault({"left/000001.png", "65 x 48", "64 x 48"});
  std::filesystem::remove(middle);
  expectFault({"left", "frame 1", "missing"});
  cv::Mat noise(kHeight, kWidth, CV_8UC3);
  cv::randu(noise, 0, 255);
  writeImage(middle, noise);
  std::ifstream in(middle, std::ios::binary);
  std::string whole{std::istreambuf_iterator<char>(in), {}};
  folder.write("left/000001.png", whole.substr(0, whole.size() - 100));
  expectFault({"left/000001.png", "truncated"});
  whole[whole.size() / 2] = static_cast<char>(whole[whole.size() / 2] + 1);
  folder.write("left/000001.png", whole);
  expectFault({"left/000001.png", "damaged"});
  folder.write("left/000001.png", "no image");
  expectFault({"left/000001.png", "is not a PNG"});
  writeImage(folder / "noise.jpg", noise);
  std::ifstream jpeg(folder / "noise.jpg", std::ios::binary);
  const std::string jpeg_bytes{std::istreambuf_iterator<char>(jpeg), {}};
  folder.write("left/000001.png", jpeg_bytes);  // the name's extension does not matter
  EXPECT_EQ(fault(), "");
  folder.write("left/000001.png", jpeg_bytes.substr(0, jpeg_bytes.size() * 2 / 3));
  expectFault({"left/000001.png", "truncated"});
  writeImage(middle, noise);
  writeImage(folder / "background/left.png", flat({1, 2, 3}));
  expectFault({"background", "right.png"});
  writeImage(folder / "background/right.png", flat({1, 2, 3}, 60));
  expectFault({"background", "right.png", "60 x 48"});
}

TEST_F(TakeTest, RejectsBadMasks) {
  std::filesystem::create_directories(folder / "silhouettes/left");
  expectFault({"silhouettes/right", "right"});
  std::filesystem::create_directories(folder / "silhouettes/right");
  expectFault({"empty"});
  writeImage(folder / "silhouettes/right/000001.png", cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(255)));
  EXPECT_EQ(fault(), "");
  writeImage(folder / "silhouettes/left/000001.png", cv::Mat(kHeight, 32, CV_8UC1, cv::Scalar(255)));
  expectFault({"silhouettes/left/000001.png", "32 x 48", "64 x 48"});
  writeImage(folder / "silhouettes/left/000001.png", cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(1)));
  expectFault({"silhouettes/left/000001.png", "255"});
  std::filesystem::rename(folder / "silhouettes/left/000001.png",
                          folder / "silhouettes/left/99999999999.png");
  expectFault({"99999999999.png", "number"});
}

TEST_F(TakeTest, RejectsBadTimestamps) {
  writeVideos(2, 2);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"camera,time\n", ":1:"},
      {"", ":1:"},
      {"cam_id,frame_time\nleft,0\nright,0\nleft\n", ":4:"},
      {"cam_id,frame_time\nleft,0\nright,zero\n", ":3:"},
      {"cam_id,frame_time\nleft,0\nright,nan\n", ":3:"},
      {"cam_id,frame_time\nleft,0\nmiddle,0\n", ":3:"},
      {"cam_id,frame_time\nleft,0\nleft,0\n", ":3:"},
      {"cam_id,frame_time\nleft,0\nleft,1\nright,0\n", "right"},
  };
  for (const auto& [content, mention] : cases) {
    folder.write("timestamps.csv", content);
    expectFault({"timestamps.csv", mention});
  }
}

}  // namespace
}  // namespace airclay
