// SPDX-License-Identifier: MIT
// Writing takes: reading returns every bit, even after an interruption.
#include "capture/takes/take_writer.h"

#include <gtest/gtest.h>

#include <random>

#include "capture/takes/take.h"
#include "engine/core/error.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;
using Images = std::vector<std::vector<std::uint8_t>>;

/// The ring's cameras; the second one has an odd width, so its images are not a video.
Rig rig(int width = 64, int height = 48) {
  Rig rig = ringRig(3, width, height);
  rig.cameras[1].width -= 1;
  return rig;
}

std::size_t pixels(const Camera& camera) {
  return std::size_t(camera.width) * std::size_t(camera.height);
}

/// Noise, because codecs lose it first.
Images noise(const Rig& of, unsigned seed) {
  std::mt19937 random(seed);
  Images images;
  for (const Camera& camera : of.cameras) {
    images.emplace_back(3 * pixels(camera));
    for (std::uint8_t& byte : images.back()) byte = static_cast<std::uint8_t>(random());
  }
  return images;
}

std::vector<double> timesOf(int set) {
  return {0.1 + set / 3.0, 0.2 + set / 3.0, 0.15 + set / 3.0};
}

void writeNoise(const fs::path& folder, int sets) {
  TakeWriter writer(folder, rig(), {});
  for (int i = 0; i < sets; ++i) writer.write({timesOf(i), noise(rig(), unsigned(i))});
  writer.finish();
  EXPECT_EQ(writer.status().sets, sets);
}

/// Every existing frame equals what was written.
void expectNoise(Take& take) {
  Images images = noise(rig(), 99);
  const std::vector<std::span<std::uint8_t>> buffers(images.begin(), images.end());
  for (int i = 0; i < take.frameCount(); ++i) {
    ASSERT_TRUE(take.readImages(i, buffers));
    EXPECT_EQ(images, noise(rig(), unsigned(i))) << i;
    EXPECT_EQ(take.cameraTimesOf(i), timesOf(i));
  }
}

TEST(TakeWriter, ImagesRoundTripExactly) {
  const TemporaryFolder folder;
  writeNoise(folder / "take", 40);
  Take take(folder / "take");
  EXPECT_EQ(take.frameCount(), 40);
  expectNoise(take);
  const Rig of = rig();
  for (std::size_t c = 0; c < 3; ++c) {
    const Camera &written = of.cameras[c], &read = take.rig().cameras[c];
    EXPECT_EQ(read.name, written.name);
    EXPECT_TRUE(read.camera_from_world.matrix() == written.camera_from_world.matrix()) << c;
    EXPECT_EQ(read.lens.fx, written.lens.fx);
  }
}

TEST(TakeWriter, MasksRoundTripExactly) {
  const TemporaryFolder folder;
  const Rig of = rig();
  const auto masks = [&](unsigned seed) {
    Images bytes;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::vector<std::uint8_t> random = noise(of, seed)[c];
      bytes.emplace_back();
      for (std::size_t i = 0; i < pixels(of.cameras[c]); ++i) bytes.back().push_back(random[i] & 1 ? 255 : 0);
    }
    return bytes;
  };
  {
    TakeWriter writer(folder / "take", of, {.content = TakeWriter::Content::kMasks});
    for (unsigned i = 0; i < 5; ++i) writer.write({{}, masks(i)});
    writer.finish();
  }
  Take take(folder / "take");
  EXPECT_EQ(take.frameCount(), 5);
  EXPECT_TRUE(take.cameraTimesOf(0).empty());
  Images read = masks(77);
  const std::vector<std::span<std::uint8_t>> buffers(read.begin(), read.end());
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(take.readSilhouettes(i, buffers));
    EXPECT_EQ(read, masks(unsigned(i)));
  }
}

TEST(TakeWriter, InterruptedTakeIsReadable) {
  const TemporaryFolder folder;
  writeNoise(folder / "take", 30);
  const fs::path video = folder / "take/cam0.mkv", times = folder / "take/timestamps.csv";
  const auto whole = fs::file_size(video);
  int least = 30;
  for (const double fraction : {0.95, 0.7, 0.61, 0.6, 0.35}) {
    fs::resize_file(video, static_cast<std::uintmax_t>(fraction * double(whole)));
    Take take(folder / "take", {.unfinished = true});
    EXPECT_GE(take.frameCount(), static_cast<int>(30 * fraction) - 2) << fraction;
    EXPECT_LE(take.frameCount(), least);
    least = take.frameCount();
    expectNoise(take);
  }
  fs::resize_file(times, fs::file_size(times) / 5);
  Take take(folder / "take", {.unfinished = true});
  EXPECT_GE(take.frameCount(), 4);
  EXPECT_LE(take.frameCount(), 6);
  expectNoise(take);
}

TEST(TakeWriter, DecreasingTimesAreMadeMonotonic) {
  const TemporaryFolder folder;
  TakeWriter writer(folder / "take", rig(), {.rate_hz = 10});
  for (const int set : {3, 4, 0, 1}) writer.write({timesOf(set), noise(rig(), 1)});
  writer.finish();
  const Take take(folder / "take");
  ASSERT_EQ(take.frameCount(), 4);
  for (int i = 1; i < 4; ++i) {
    EXPECT_GT(take.timeOf(i), take.timeOf(i - 1));
    EXPECT_NEAR(*skewOf(take.cameraTimesOf(i)), 0.1, 1e-12);
  }
  EXPECT_NEAR(take.timeOf(3) - take.timeOf(2), 1 / 3.0, 1e-12);
}

TEST(TakeWriter, FullQueueBlocksAndDropsNothing) {
  const TemporaryFolder folder;
  const Rig large = rig(1280, 960);
  Images flat = noise(large, 1);  // noise: slow to encode
  std::size_t bytes = 0;
  for (const std::vector<std::uint8_t>& one : flat) bytes += one.size();
  const int sets = static_cast<int>(2 * TakeWriter::kQueueBytes / bytes) + 2;
  TakeWriter writer(folder / "take", large, {});
  for (int i = 0; i < sets; ++i) writer.write({timesOf(i), flat});
  EXPECT_GT(writer.status().waited_s, 0);
  EXPECT_LT(writer.status().sets, sets);
  writer.finish();
  EXPECT_EQ(writer.status().sets, sets);
  EXPECT_EQ(Take(folder / "take").frameCount(), sets);
}

TEST(TakeWriter, FullDiskLeavesReadableTake) {
  const TemporaryFolder folder;
  int asked = 0;
  TakeWriter::Options options;
  options.free_bytes = [&](const fs::path&) {
    return ++asked <= 20 ? 10 * TakeWriter::kMinFreeBytes : TakeWriter::kMinFreeBytes - 1;
  };
  std::string message;
  {
    TakeWriter writer(folder / "take", rig(), options);
    try {
      for (int i = 0; i < 40; ++i) writer.write({timesOf(i), noise(rig(), unsigned(i))});
      writer.finish();
    } catch (const Error& error) {
      message = error.what();
    }
    EXPECT_EQ(writer.status().fault, message);
  }
  EXPECT_EQ(message, (folder / "take").string() +
                         ": the disk is full: the recording ends with set 20 and can be replayed up to it");
  Take take(folder / "take");
  EXPECT_EQ(take.frameCount(), 20);
  expectNoise(take);
}

TEST(TakeWriter, RejectsNonEmptyFolder) {
  const TemporaryFolder folder;
  folder.write("mine.txt", "x");
  try {
    const TakeWriter writer(folder.path(), rig(), {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("the folder is not empty"), std::string::npos);
  }
  EXPECT_EQ(contentOf(folder / "mine.txt"), "x");
}

}  // namespace
}  // namespace airclay
