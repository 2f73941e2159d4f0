// SPDX-License-Identifier: MIT
#include "engine/silhouette/silhouette.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <random>

#include "capture/images/video_reader.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// A mottled backdrop with Gaussian noise; optionally a disc of skin colour, a shadow, speckle and pinholes.
struct Studio {
  explicit Studio(int image_width, int image_height) : rig(ringRig(2, image_width, image_height)) {}

  std::vector<std::uint8_t> image(int camera, bool hand, double brightness = 1) {
    const int width = rig.cameras[0].width, height = rig.cameras[0].height;
    std::vector<std::uint8_t> bgr(std::size_t(width) * height * 3);
    std::normal_distribution<double> noise(0, 2);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        Vec3 color = Vec3(120, 105, 85) * (1 + 0.2 * std::sin(0.05 * x + camera) * std::cos(0.07 * y));
        const double u = x - 0.45 * width, v = y - 0.5 * height;
        if (hand && std::hypot(u - 40, v - 10) < 30) color *= 0.65;  // its shadow
        if (hand && std::hypot(u, v) < 30) color = Vec3(110, 140, 205) * (1 - 0.004 * u);
        if (hand && std::hypot(u + 5, v - 6) < 3) color = Vec3(120, 105, 85);   // a hole
        if (hand && std::hypot(u - 70, v + 40) < 4) color = Vec3(40, 60, 200);  // something small
        for (int c = 0; c < 3; ++c)
          bgr[std::size_t(3 * (y * width + x) + c)] = static_cast<std::uint8_t>(
              std::clamp(std::round(brightness * color[c] + noise(random)), 0.0, 255.0));
      }
    return bgr;
  }

  Rig rig;
  std::mt19937 random{7};
};

/// A camera's images: kEmptyFrames of the empty studio, and others.
using Shots = std::vector<std::vector<std::uint8_t>>;
constexpr int kEmptyFrames = 8;

/// Images after video compression with OpenCV's default quality.
Shots throughVideo(const Shots& images, cv::Size size, const char* form) {
  const TemporaryFolder folder;
  cv::VideoWriter writer(folder / "video.avi", cv::CAP_FFMPEG,
                         cv::VideoWriter::fourcc(form[0], form[1], form[2], form[3]), 30, size);
  for (const auto& image : images)
    writer.write(cv::Mat(size, CV_8UC3, const_cast<std::uint8_t*>(image.data())));
  writer.release();
  const auto video = openFrames(folder.path(), "video");
  Shots result(images.size());
  for (std::size_t frame = 0; frame < result.size(); ++frame) {
    result[frame].resize(images[frame].size());
    video->read(static_cast<int>(frame), result[frame]);
  }
  return result;
}

struct Segmented {
  std::vector<Silhouette> raw, majority, largest, cleaned;
  std::vector<std::vector<BackgroundPixel>> background;
  std::vector<std::vector<std::uint8_t>> images;
};

/// For all cameras, with one image that is not empty.
std::vector<Shots> shoot(Studio& studio, bool hand, double brightness = 1) {
  std::vector<Shots> shots(studio.rig.cameras.size());
  for (int frame = 0; frame <= kEmptyFrames; ++frame)
    for (std::size_t c = 0; c < shots.size(); ++c)
      shots[c].push_back(frame < kEmptyFrames ? studio.image(static_cast<int>(c), false)
                                              : studio.image(static_cast<int>(c), hand, brightness));
  return shots;
}

/// The last image; the first kEmptyFrames teach the background.
Segmented segment(const Rig& cameras, const std::vector<Shots>& shots) {
  Gpu& gpu = testGpu();
  const GpuRig rig(gpu, cameras);
  Silhouettes silhouettes(gpu, rig);
  Buffer<std::uint32_t> images(gpu, rig.imageWords(), Memory::kHost);
  Recorder recorder(gpu);
  const auto show = [&](std::size_t camera, const std::vector<std::uint8_t>& bgr) {
    std::copy(bgr.begin(), bgr.end(), rig.image(images.host(), camera).begin());
  };
  for (int frame = 0; frame < kEmptyFrames; ++frame) {
    for (std::size_t c = 0; c < rig.cameraCount(); ++c) show(c, shots[c][std::size_t(frame)]);
    recorder.begin();
    silhouettes.recordLearning(recorder, images);
    if (frame + 1 == kEmptyFrames) silhouettes.finishLearning(recorder);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
  }
  Segmented result;
  for (std::size_t c = 0; c < rig.cameraCount(); ++c) {
    result.background.push_back(
        learnBackgroundReference({shots[c].begin(), shots[c].begin() + kEmptyFrames}));
    result.images.push_back(shots[c].back());
    show(c, result.images.back());
  }
  recorder.begin();
  silhouettes.record(recorder, images);
  recorder.submitAndWait();
  EXPECT_TRUE(hazards(recorder.commands()).empty());
  result.raw = rig.unpack(silhouettes.segmented().download());
  result.majority = rig.unpack(silhouettes.majorityMask().download());
  result.largest = rig.unpack(silhouettes.largestMask().download());
  result.cleaned = rig.unpack(silhouettes.masks().host());
  return result;
}

Segmented segment(Studio& studio, bool hand, double brightness = 1) {
  return segment(studio.rig, shoot(studio, hand, brightness));
}

long pixelsSet(const Silhouette& mask) {
  return std::count(mask.pixels.begin(), mask.pixels.end(), 255);
}

TEST(Silhouette, SegmentationEqualsTheReference) {
  // 203 pixels: rows do not start at whole 32-bit words
  for (const int width : {320, 203}) {
    Studio studio(width, 240);
    const Segmented result = segment(studio, true);
    for (std::size_t c = 0; c < result.raw.size(); ++c) {
      std::vector<double> scores(result.raw[c].pixels.size());
      std::vector<char> exempt(scores.size());
      for (std::size_t i = 0; i < scores.size(); ++i) {
        const Vec3 seen(result.images[c][3 * i], result.images[c][3 * i + 1], result.images[c][3 * i + 2]);
        // the model stores integer grey levels and eighths of the deviation
        const BackgroundPixel& background = result.background[c][i];
        BackgroundPixel stored;
        for (int k = 0; k < 3; ++k) stored.mean[k] = std::floor(background.mean[k] + 0.5);
        stored.spread = std::floor(background.spread / kSpreadStep + 0.5) * kSpreadStep;
        scores[i] = scoreReference(seen, stored);
        for (const double level : {1, 2, 4, 8})
          if (std::abs(scores[i] - level) < 1e-4 * level) {
            // a different decision at a threshold affects up to two pixels
            const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
            for (int v = std::max(y - 2, 0); v <= std::min(y + 2, 239); ++v)
              for (int u = std::max(x - 2, 0); u <= std::min(x + 2, width - 1); ++u)
                exempt[std::size_t(v * width + u)] = 1;
          }
      }
      const Silhouette expected = edgesReference(width, 240, scores);
      std::size_t different = 0;
      for (std::size_t i = 0; i < scores.size(); ++i)
        different += !exempt[i] && expected.pixels[i] != result.raw[c].pixels[i];
      EXPECT_EQ(different, 0u);
      EXPECT_LT(std::count(exempt.begin(), exempt.end(), 1), 1000);
    }
  }
}

TEST(Silhouette, CleaningEqualsTheReferenceExactly) {
  for (const int width : {320, 203}) {
    Studio studio(width, 240);
    const Segmented result = segment(studio, true);
    for (std::size_t c = 0; c < result.raw.size(); ++c) {
      EXPECT_EQ(result.majority[c].pixels, majorityReference(result.raw[c]).pixels);
      EXPECT_EQ(result.largest[c].pixels, largestPartReference(result.majority[c]).pixels);
      EXPECT_EQ(result.cleaned[c].pixels, closeHolesReference(result.largest[c], largestHole(width)).pixels);
    }
  }
}

TEST(Silhouette, LargestPartEqualsOpenCv) {
  Studio studio(320, 240);
  const Segmented result = segment(studio, true);
  for (std::size_t c = 0; c < result.majority.size(); ++c) {
    Silhouette majority = result.majority[c];
    cv::Mat labels, stats, centers;
    cv::connectedComponentsWithStats(cv::Mat(majority.height, majority.width, CV_8U, majority.pixels.data()),
                                     labels, stats, centers, 8);
    int largest = 1;
    for (int i = 1; i < stats.rows; ++i)
      if (stats.at<int>(i, cv::CC_STAT_AREA) > stats.at<int>(largest, cv::CC_STAT_AREA)) largest = i;
    for (int i = 0; i < majority.height * majority.width; ++i)
      ASSERT_EQ(result.largest[c].pixels[std::size_t(i)] != 0,
                labels.at<int>(i / majority.width, i % majority.width) == largest);
  }
}

TEST(Silhouette, FindsTheDiscWithoutItsShadow) {
  for (const double brightness : {1.0, 0.92, 1.08}) {
    Studio studio(320, 240);
    const Segmented result = segment(studio, true, brightness);
    for (const Silhouette& mask : result.cleaned) {
      long wrong = 0;
      for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) {
          const double distance = std::hypot(x - 0.45 * mask.width, y - 0.5 * mask.height);
          if (std::abs(distance - 30) < 1) continue;  // its edge
          wrong += (distance < 30) != (mask.pixels[std::size_t(y * mask.width + x)] != 0);
        }
      EXPECT_EQ(wrong, 0);
    }
  }
}

TEST(Silhouette, VideoCodingMovesEdgesByLessThanHalfAPixel) {
  for (const char* form : {"avc1", "MJPG"}) {
    Studio studio(320, 240);
    std::vector<Shots> shots = shoot(studio, false);
    for (std::size_t c = 0; c < shots.size(); ++c) {
      for (int frame = 0; frame < 6; ++frame) shots[c].push_back(studio.image(static_cast<int>(c), true));
      shots[c] = throughVideo(shots[c], {320, 240}, form);
    }
    for (const Silhouette& mask : segment(studio.rig, shots).cleaned) {
      EXPECT_NEAR(std::sqrt(double(pixelsSet(mask)) / M_PI), 30, 0.5) << form;  // the disc's radius
      for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) {
          const double distance = std::hypot(x - 0.45 * mask.width, y - 0.5 * mask.height);
          if (std::abs(distance - 30) < 3) continue;  // re-encoded pixels around the edge: 2 pixels of chroma
          ASSERT_EQ(distance < 30, mask.pixels[std::size_t(y * mask.width + x)] != 0) << form;
        }
    }
  }
}

TEST(Silhouette, EmptyImageHasAlmostNoSilhouette) {
  Studio studio(320, 240);
  for (const Silhouette& mask : segment(studio, false).cleaned) EXPECT_LT(pixelsSet(mask), 10);
}

}  // namespace
}  // namespace airclay
