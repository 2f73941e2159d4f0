// SPDX-License-Identifier: MIT
#include "engine/silhouette/evidence.h"

#include <functional>
#include <random>

#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

constexpr std::uint32_t kSpread = 20;  // 2.5 grey levels

/// A rectangle of pixels, multiples of a cell.
struct Patch {
  int x = 0, y = 0, width = 0, height = 0;
  bool contains(int u, int v) const { return u >= x && v >= y && u < x + width && v < y + height; }
};

/// Cameras in front of a coloured, textured wall.
class Wall {
 public:
  explicit Wall(const Rig& cameras = ringRig(2), const Vec3& base = {70, 110, 150})
      : rig(testGpu(), cameras),
        evidence(testGpu(), rig),
        model(testGpu(), rig.pixels()),
        images(testGpu(), rig.imageWords(), Memory::kHost),
        masks(testGpu(), rig.maskWords(), Memory::kHost),
        forearms(testGpu(), std::vector<vec4>(2 * rig.cameraCount(), vec4::Zero())),
        recorder_(testGpu()) {
    std::mt19937 random(7);
    std::vector<std::uint32_t> words(rig.pixels());
    for (std::size_t i = 0; i < words.size(); ++i) {
      Vec3 colour = base;
      for (int k = 0; k < 3; ++k) colour[k] += int(random() % 41) - 20;
      words[i] = std::uint32_t(colour[0]) | std::uint32_t(colour[1]) << 8 | std::uint32_t(colour[2]) << 16 |
                 kSpread << 24;
    }
    model.upload(words);
    colours_ = std::move(words);
    submit([&](Recorder& recorder) { evidence.recordBackground(recorder, model); });
    draw([](int, int, const Vec3& background) { return background; });
  }

  /// Sets every pixel from its place and its background.
  void draw(const std::function<Vec3(int, int, const Vec3&)>& colour) {
    for (std::size_t c = 0; c < rig.cameraCount(); ++c) {
      const GpuCamera& camera = rig.camera(c);
      const std::span<std::uint8_t> image = rig.image(images.host(), c);
      for (std::size_t i = 0; i < image.size() / 3; ++i) {
        const std::uint32_t word = colours_[camera.pixels_before + i];
        const Vec3 seen = colour(int(i % camera.width), int(i / camera.width),
                                 Vec3(word & 255, word >> 8 & 255, word >> 16 & 255));
        for (int k = 0; k < 3; ++k)
          image[3 * i + std::size_t(k)] = std::uint8_t(std::clamp(std::floor(seen[k] + 0.5), 0.0, 255.0));
      }
    }
  }
  void submit(const std::function<void(Recorder&)>& record) {
    recorder_.begin();
    record(recorder_);
    recorder_.submitAndWait();
    EXPECT_TRUE(hazards(recorder_.commands()).empty());
  }
  std::vector<GpuTileRegion> wholeImages() const {
    std::vector<GpuTileRegion> regions;
    for (std::size_t c = 0; c < rig.cameraCount(); ++c) regions.push_back(evidence.wholeImage(c));
    return regions;
  }
  void update() {
    submit([&](Recorder& recorder) { evidence.record(recorder, images, model, wholeImages()); });
  }
  /// The evidence of the cells in a patch of camera 0, mean and extremes.
  struct Range {
    double mean = 0, least = 0, most = 0;
  };
  Range evidenceIn(const Patch& patch) const { return evidenceIn(patch, evidence, rig); }
  static Range evidenceIn(const Patch& patch, const Evidence& evidence, const GpuRig& rig) {
    const std::vector<std::uint32_t> words = evidence.evidence().download();
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
    const std::uint32_t columns = kTileCells * tilesOf(rig.camera(0))[0];
    Range range{0, kMaxEvidence, -kMaxEvidence};
    int count = 0;
    for (int y = patch.y / 2; y < (patch.y + patch.height) / 2; ++y)
      for (int x = patch.x / 2; x < (patch.x + patch.width) / 2; ++x, ++count) {
        const double value = evidenceOf(bytes[std::uint32_t(y) * columns + std::uint32_t(x)]);
        range = {range.mean + value, std::min(range.least, value), std::max(range.most, value)};
      }
    range.mean /= count;
    return range;
  }

  GpuRig rig;
  Evidence evidence;
  Buffer<std::uint32_t> model, images, masks;
  Buffer<vec4> forearms;

 private:
  Recorder recorder_;
  std::vector<std::uint32_t> colours_;
};

TEST(Evidence, GainsFollowExposureAndWhiteBalance) {
  Wall wall(ringRig(2, 640, 480), {120, 140, 160});
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 2.5);
  for (const Vec3& gain : {Vec3(0.9, 1, 1.1), Vec3(1.1, 0.9, 0.95), Vec3(1, 1, 1)}) {
    wall.draw([&](int x, int, const Vec3& background) {
      if (x < 160) return Vec3(30, 220, 90);  // a quarter of the image is covered
      return Vec3(gain.cwiseProduct(background) + Vec3(noise(random), noise(random), noise(random)));
    });
    wall.update();
    for (std::size_t c = 0; c < wall.rig.cameraCount(); ++c)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(wall.evidence.gains().host()[4 * c + k] / gain[Eigen::Index(k)], 1, 0.005);
    // what is left is the background
    EXPECT_LT(wall.evidenceIn({240, 40, 320, 400}).mean, -3);
  }
}

TEST(Evidence, AShadowIsTheBackgroundAndAnotherColourIsNot) {
  Wall wall;
  const Patch shadow{32, 48, 96, 96}, object{192, 48, 96, 96};
  wall.draw([&](int x, int y, const Vec3& background) {
    if (shadow.contains(x, y)) return Vec3(0.6 * background);
    if (object.contains(x, y)) return Vec3(Vec3(150, 110, 70));
    return background;
  });
  wall.update();
  EXPECT_LT(wall.evidenceIn({48, 64, 64, 64}).most, 0);
  EXPECT_GT(wall.evidenceIn({200, 56, 80, 80}).least, 2);
  EXPECT_LT(wall.evidenceIn({0, 160, 320, 80}).most, 0);
}

// As in the paper's studio: masks take the place of images.
TEST(Evidence, MasksAsImagesAreEvidenceForTheHand) {
  const GpuRig rig(testGpu(), ringRig(2));
  MaskImages mask_images(testGpu(), rig);
  Evidence evidence(testGpu(), rig);
  Buffer<std::uint32_t> masks(testGpu(), rig.maskWords(), Memory::kHost);
  const std::vector<Silhouette> silhouettes = sphereMasks(rig.rig(), Vec3::Zero(), 0.1);
  rig.pack(silhouettes, masks.host());
  Recorder recorder(testGpu());
  recorder.begin();
  mask_images.record(recorder, masks);
  evidence.recordBackground(recorder, mask_images.background());
  evidence.record(recorder, mask_images.images(), mask_images.background(),
                  std::vector<GpuTileRegion>{evidence.wholeImage(0), evidence.wholeImage(1)});
  evidence.recordMasks(recorder, masks);
  recorder.submitAndWait();
  EXPECT_TRUE(hazards(recorder.commands()).empty());
  const std::vector<Silhouette> found = rig.unpack(masks.host());
  for (std::size_t c = 0; c < found.size(); ++c) {
    std::size_t different = 0, whole = 0;
    for (int y = 0; y < found[c].height; y += 2)
      for (int x = 0; x < found[c].width; x += 2) {
        int expected = 0, set = 0;  // of the cell's pixels
        for (int k = 0; k < 4; ++k) {
          expected += silhouettes[c].contains(x + k % 2, y + k / 2);
          set += found[c].contains(x + k % 2, y + k / 2);
        }
        whole += expected == 4;
        different += expected % 4 == 0 && set != expected;
      }
    EXPECT_GT(whole, 300u);
    EXPECT_EQ(different, 0u);
  }
  EXPECT_GT(Wall::evidenceIn({152, 112, 16, 16}, evidence, rig).least, 2);
  EXPECT_LT(Wall::evidenceIn({0, 0, 64, 64}, evidence, rig).most, -2);
}

TEST(Evidence, LearningTellsTheHandFromTheBackgroundAndFromOtherThings) {
  Wall wall;
  // a hand almost of the wall's colour, and something bright that moves
  const Patch hand{48, 48, 96, 96}, other{208, 48, 80, 96};
  wall.draw([&](int x, int y, const Vec3& background) {
    if (hand.contains(x, y)) return Vec3(background + Vec3(6, 0, -6));
    if (other.contains(x, y)) return Vec3(Vec3(210, 200, 40));
    return background;
  });
  wall.update();
  const Wall::Range hand_before = wall.evidenceIn(hand), other_before = wall.evidenceIn(other);
  EXPECT_GT(other_before.least, 2);  // any change may be the hand

  std::vector<Silhouette> masks;
  for (const Camera& camera : wall.rig.rig().cameras) {
    masks.push_back(emptySilhouette(camera));
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        if (hand.contains(x, y)) masks.back().pixels[std::size_t(y * camera.width + x)] = 255;
  }
  wall.rig.pack(masks, wall.masks.host());
  wall.submit(
      [&](Recorder& recorder) { wall.evidence.recordLearning(recorder, 0, wall.masks, wall.forearms, 1); });
  wall.update();
  EXPECT_GT(wall.evidenceIn(hand).mean, hand_before.mean + 1);
  EXPECT_LT(wall.evidenceIn(other).most, -1);

  wall.evidence.forgetColours();
  wall.update();
  EXPECT_NEAR(wall.evidenceIn(hand).mean, hand_before.mean, 1e-9);
}

TEST(Evidence, ALastingChangeBecomesTheBackground) {
  Wall wall;
  const Patch object{64, 64, 64, 64};
  wall.draw([&](int x, int y, const Vec3& background) {
    return object.contains(x, y) ? Vec3(150, 110, 70) : background;
  });
  wall.update();
  const auto visit = [&](std::uint32_t times) {
    for (std::uint32_t i = 0; i < times; ++i)
      wall.submit([&](Recorder& recorder) {
        for (std::uint32_t phase = 0; phase < kAdaptRows; ++phase)
          wall.evidence.recordAdaptation(recorder, wall.images, wall.model, false);
      });
    wall.update();
  };
  visit(kAdaptVisits / 2);
  EXPECT_GT(wall.evidenceIn(object).least, 2);
  visit(kAdaptVisits);
  EXPECT_LT(wall.evidenceIn(object).most, 0);
}

}  // namespace
}  // namespace airclay
