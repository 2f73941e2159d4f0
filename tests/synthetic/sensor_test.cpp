// SPDX-License-Identifier: MIT
#include "engine/synthetic/sensor.h"

#include "engine/core/error.h"
#include "engine/hand/hand_model.h"
#include "tests/support/coverage.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

/// A sphere of quads along meridians, split in two; closed, counterclockwise from outside.
TriangleMesh sphere(double radius_m) {
  constexpr int rings = 64, around = 128;
  TriangleMesh mesh;
  for (int r = 0; r <= rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double polar = M_PI * r / rings, azimuth = 2 * M_PI * a / around;
      mesh.vertices.push_back(radius_m * Vec3(std::sin(polar) * std::cos(azimuth),
                                              std::sin(polar) * std::sin(azimuth), std::cos(polar)));
    }
  for (int r = 0; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const int p = r * around + a, q = r * around + (a + 1) % around;
      mesh.triangles.push_back({p, p + around, q});
      mesh.triangles.push_back({q, p + around, q + around});
    }
  return mesh;
}

/// Two perspective cameras, a rational and a fisheye one.
Rig mixedRig() {
  Rig rig = ringRig(4);
  rig.cameras[2].lens.model = LensModel::kFisheye;
  rig.cameras[2].lens.distortion = {0.05, -0.02, 0.003, -0.001, 0, 0, 0, 0};
  rig.cameras[3].lens.distortion = {0.3, -0.1, 1e-3, -5e-4, 0.02, 0.25, -0.08, 0.01};
  for (Camera& camera : rig.cameras) camera.lens = withMonotonicRange(camera.lens);
  return rig;
}

/// A sensor with its rig, and its images as bytes.
struct Studio {
  Studio(const Rig& rig, const std::vector<TriangleMesh>& meshes)
      : gpu_rig(testGpu(), rig), sensor(testGpu(), gpu_rig, meshes), recorder(testGpu()) {}

  /// The bytes of all cameras, one after another.
  std::vector<std::uint8_t> take(const std::optional<Pose>& pose, const SensorFrame& frame = {}) {
    recorder.begin();
    recorder.stage("sensor");
    for (std::size_t i = 0; i < gpu_rig.cameraCount(); ++i) sensor.record(recorder, i, pose, frame);
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
    std::vector<std::uint32_t> words = sensor.images().download();
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i < gpu_rig.cameraCount(); ++i) {
      const auto image = gpu_rig.image(words, i);
      bytes.insert(bytes.end(), image.begin(), image.end());
    }
    return bytes;
  }

  GpuRig gpu_rig;
  Sensor sensor;
  Recorder recorder;
};

Pose somewhere() {
  Pose pose = Pose::Identity();
  pose.linear() = rotationFromVector(Vec3(0.5, 0.2, 0.3));
  pose.translation() = Vec3(-0.07, 0.02, -0.03);
  return pose;
}

TEST(Sensor, SphereOutlineIsItsTangentCone) {
  const Rig rig = mixedRig();
  const double radius_m = 0.09;
  Studio studio(rig, {sphere(radius_m)});
  studio.take(somewhere());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    SCOPED_TRACE(rig.cameras[c].name);
    // closed form: the pixel samples whose rays pass within the radius
    Camera fine = rig.cameras[c];
    fine.width *= 4;
    fine.height *= 4;
    fine.lens.fx *= 4;
    fine.lens.fy *= 4;
    fine.lens.cx = 4 * fine.lens.cx + 1.5;  // pixel centres at integers
    fine.lens.cy = 4 * fine.lens.cy + 1.5;
    const Silhouette mask = sphereMasks({{fine}, rig.workspace}, somewhere().translation(), radius_m)[0];
    const std::vector<double> samples(mask.pixels.begin(), mask.pixels.end());
    Shape expected = shapeOf(samples, fine.width);
    expected.area /= 16.0 * 255;
    expected.center = (expected.center - Vec2(1.5, 1.5)) / 4;
    const Shape seen = shapeOf(studio.sensor.coverage(c), rig.cameras[c].width);
    EXPECT_NEAR(seen.area / expected.area, 1, 0.005);
    EXPECT_LT((seen.center - expected.center).norm(), 0.05);
  }
}

TEST(Sensor, HandIsAtItsProjection) {
  const Rig rig = mixedRig();
  const TriangleMesh skin = builtInHand(false).skin;
  Studio studio(rig, {skin});
  studio.take(somewhere());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    SCOPED_TRACE(rig.cameras[c].name);
    const int width = rig.cameras[c].width;
    const std::vector<double> coverage = studio.sensor.coverage(c);
    const std::vector<double> projected = projectedCoverage(rig.cameras[c], skin, somewhere());
    const Shape seen = shapeOf(coverage, width), expected = shapeOf(projected, width);
    EXPECT_GT(expected.area, 300);
    EXPECT_NEAR(seen.area / expected.area, 1, 0.01);
    EXPECT_LT((seen.center - expected.center).norm(), 0.05);
    double different = 0;  // four samples resolve an edge pixel's coverage to about an eighth
    for (std::size_t i = 0; i < coverage.size(); ++i) different += std::abs(coverage[i] - projected[i]);
    EXPECT_LT(different / expected.area, 0.05);
  }
}

TEST(Sensor, HandAndBackdropDifferInColour) {
  Studio studio(ringRig(4), {builtInHand(false).skin, builtInForearm(false)});
  const SensorFrame clean{.noise_sigma = 0};
  const std::vector<std::uint8_t> empty = studio.take(std::nullopt, clean),
                                  full = studio.take(somewhere(), clean);
  std::size_t pixel = 0, alike = 0, covered = 0;
  for (std::size_t c = 0; c < 4; ++c)
    for (const double coverage : studio.sensor.coverage(c)) {
      if (coverage == 1) {
        ++covered;
        const std::uint8_t *behind = &empty[3 * pixel], *hand = &full[3 * pixel];
        // skin is the reddest, the cloth the bluest: the ratio of red to blue must have grown by this factor
        alike += double(hand[2]) * behind[0] < 1.6 * behind[2] * hand[0];
      }
      ++pixel;
    }
  EXPECT_GT(covered, 4000u);
  EXPECT_LT(alike, covered / 1000);
}

TEST(Sensor, ShadowDarkensTheFloorAndKeepsItsHue) {
  Rig rig = ringRig(4);
  Studio studio(rig, {builtInHand(false).skin, builtInForearm(false)});
  const SensorFrame clean{.noise_sigma = 0};
  const std::vector<std::uint8_t> empty = studio.take(std::nullopt, clean),
                                  full = studio.take(somewhere(), clean);
  std::vector<double> coverages;
  for (std::size_t c = 0; c < 4; ++c) {
    const std::vector<double> of_camera = studio.sensor.coverage(c);
    coverages.insert(coverages.end(), of_camera.begin(), of_camera.end());
  }
  double darkest = 1, tinted = 0;
  // blocks of 16 pixels in a row, because single bytes are too coarse
  for (std::size_t first = 0; first + 16 <= coverages.size(); first += 16) {
    double before[3] = {}, after[3] = {}, coverage = 0;
    for (std::size_t i = first; i < first + 16; ++i) {
      coverage += coverages[i];
      for (std::size_t k = 0; k < 3; ++k) {
        before[k] += empty[3 * i + k];
        after[k] += full[3 * i + k];
      }
    }
    if (coverage > 0 || before[2] < 16 * 25) continue;
    const double ratio = after[1] / before[1];
    darkest = std::min(darkest, ratio);
    for (std::size_t k = 0; k < 3; ++k) tinted = std::max(tinted, std::abs(after[k] / before[k] / ratio - 1));
    EXPECT_LT(ratio, 1.01);
  }
  EXPECT_LT(darkest, 0.93);
  EXPECT_GT(darkest, 0.70);
  EXPECT_LT(tinted, 0.02);
}

TEST(Sensor, NoiseIsWhiteGaussianWithGivenDeviation) {
  Studio studio(ringRig(2), {sphere(0.05)});
  const std::vector<std::uint8_t> clean = studio.take(std::nullopt, {.noise_sigma = 0}),
                                  noisy = studio.take(std::nullopt, {.noise_sigma = 2.5});
  double count = 0, sum = 0, square = 0, fourth = 0, with_next = 0, with_below = 0, with_channel = 0;
  const std::size_t row = 3 * 320;
  const auto noise = [&](std::size_t i) { return double(noisy[i]) - clean[i]; };
  for (std::size_t i = 0; i + row < clean.size(); ++i) {
    if (clean[i] < 20) continue;  // bytes are clamped at 0
    const double n = noise(i);
    ++count;
    sum += n;
    square += n * n;
    fourth += n * n * n * n;
    with_next += n * noise(i + 3);
    with_channel += n * noise(i + 1);
    with_below += n * noise(i + row);
  }
  ASSERT_GT(count, 200'000);
  const double variance = square / count;
  EXPECT_NEAR(sum / count, 0, 5 * 2.5 / std::sqrt(count) + 0.005);
  // both images are rounded to integers: variance 1/12 each
  EXPECT_NEAR(std::sqrt(variance - 2.0 / 12), 2.5, 0.02);
  EXPECT_NEAR(fourth / count / (variance * variance), 3, 0.1);
  for (const double product : {with_next, with_channel, with_below})
    EXPECT_NEAR(product / square, 0, 5 / std::sqrt(count));
}

TEST(Sensor, EqualFramesAreEqualBytes) {
  Studio studio(ringRig(2), {sphere(0.05)});
  const SensorFrame frame{.seed = 7, .frame = 12};
  const std::vector<std::uint8_t> first = studio.take(somewhere(), frame);
  const std::vector<std::uint8_t> other = studio.take(somewhere(), {.seed = 7, .frame = 13});
  const std::vector<std::uint8_t> seeded = studio.take(somewhere(), {.seed = 8, .frame = 12});
  EXPECT_EQ(studio.take(somewhere(), frame), first);
  EXPECT_NE(other, first);
  EXPECT_NE(seeded, first);
}

TEST(Sensor, BrightnessScalesTheImage) {
  Studio studio(ringRig(2), {sphere(0.05)});
  const auto mean = [&](double brightness) {
    double sum = 0;
    for (const std::uint8_t byte : studio.take(std::nullopt, {.noise_sigma = 2.5, .brightness = brightness}))
      sum += byte;
    return sum;
  };
  EXPECT_NEAR(mean(1.03) / mean(1), 1.03, 0.002);
}

TEST(Sensor, RendersAnyImageSize) {
  Rig rig = ringRig(3, 101, 77);  // 7,777 pixels: not a whole number of 32-bit words
  rig.cameras[1] = ringRig(3, 64, 64).cameras[1];
  Rig alone = rig;
  alone.cameras = {rig.cameras[0]};
  Studio together(rig, {sphere(0.2)}), first(alone, {sphere(0.2)});
  const SensorFrame clean{.noise_sigma = 0};
  const std::vector<std::uint8_t> all = together.take(somewhere(), clean);
  ASSERT_EQ(all.size(), 3u * (7777 + 64 * 64 + 7777));
  EXPECT_EQ(all[3 * 7776 + 0] != 0, true) << "the last pixel of the first camera";
  EXPECT_EQ(std::vector<std::uint8_t>(all.begin(), all.begin() + 3 * 7777), first.take(somewhere(), clean));
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_GT(shapeOf(together.sensor.coverage(c), rig.cameras[c].width).area, 200);
}

TEST(Sensor, StagesAreTimedAfterDrawing) {
  Studio studio(ringRig(4), {sphere(0.05)});
  const auto emptyFrameMs = [&] {
    studio.take(std::nullopt);
    return studio.recorder.stageMs().at(0).second;
  };
  emptyFrameMs();
  const double before_ms = emptyFrameMs();
  studio.take(somewhere());
  // the factor allows for a busy machine; a deferred timestamp would show less than a hundredth
  EXPECT_GT(emptyFrameMs(), 0.1 * before_ms);
}

TEST(Sensor, RejectsEmptyScene) {
  const GpuRig rig(testGpu(), ringRig(2));
  EXPECT_THROW(Sensor(testGpu(), rig, {}), Error);
}

}  // namespace
}  // namespace airclay
