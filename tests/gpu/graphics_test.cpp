// SPDX-License-Identifier: MIT
#include "engine/gpu/graphics.h"

#include <algorithm>

#include "engine/core/error.h"
#include "shaders/gpu/triangles.frag.h"
#include "shaders/gpu/triangles.vert.h"
#include "shaders/gpu/triangles_io.h"
#include "shaders/hull/carve_blocks.comp.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

constexpr std::uint32_t kWidth = 64, kHeight = 48;
const vec4 kBlack(0, 0, 0, 1), kGreen(0, 1, 0, 1), kRed(1, 0, 0, 1);

struct Pixel {
  int r, g, b, a;
  bool operator==(const Pixel&) const = default;
};

/// Draws triangles into a canvas and reads the image back.
class Drawing {
 public:
  explicit Drawing(const GraphicsOptions& options = {})
      : pipeline_(testGpu(), "triangles", {triangles_vert, triangles_frag}, options),
        canvas_(testGpu(), kWidth, kHeight),
        image_(testGpu(), kWidth * kHeight, Memory::kHost) {}

  void add(const std::vector<vec3>& corners, const vec4& color) {
    corners_.emplace_back(testGpu(), corners);
    colors_.push_back(color);
  }

  void draw(const vec4& background = kBlack) {
    Recorder recorder(testGpu());
    recorder.begin();
    recorder.stage("draw");
    std::vector<Draw> draws;
    for (std::size_t i = 0; i < corners_.size(); ++i)
      draws.push_back(airclay::draw(pipeline_, TrianglesArgs{corners_[i], colors_[i]},
                                    static_cast<std::uint32_t>(corners_[i].count())));
    render(recorder, canvas_.pass(background), draws);
    copyToBuffer(recorder, canvas_.resolved, image_.raw());
    recorder.submitAndWait();
    EXPECT_TRUE(hazards(recorder.commands()).empty());
  }

  Pixel at(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t p = image_.host()[y * kWidth + x];
    return {int(p & 255), int(p >> 8 & 255), int(p >> 16 & 255), int(p >> 24)};
  }

 private:
  GraphicsPipeline<TrianglesArgs> pipeline_;
  Canvas canvas_;
  Buffer<std::uint32_t> image_;
  std::vector<Buffer<vec3>> corners_;
  std::vector<vec4> colors_;
};

/// Covers the image from x = -1 to `right` (clip space), counterclockwise in the image.
std::vector<vec3> leftPart(float right, float depth) {
  return {{-1, -1, depth}, {-1, 1, depth},    {right, 1, depth},
          {-1, -1, depth}, {right, 1, depth}, {right, -1, depth}};
}

TEST(Graphics, TriangleCoversThePixelsInside) {
  Drawing drawing;
  // corners at pixels (0, 0), (0, 48) and (64, 48): covers the pixels below the image's diagonal
  drawing.add({{-1, -1, 0.5f}, {-1, 1, 0.5f}, {1, 1, 0.5f}}, kGreen);
  drawing.draw();
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      // the diagonal is y = 3/4 x; a pixel is fully inside or outside if its corners are on one side
      const bool all_inside = 4 * y >= 3 * (x + 1), all_outside = 4 * (y + 1) <= 3 * x;
      if (all_inside) {
        EXPECT_EQ(drawing.at(x, y), (Pixel{0, 255, 0, 255})) << x << ", " << y;
      } else if (all_outside) {
        EXPECT_EQ(drawing.at(x, y), (Pixel{0, 0, 0, 255})) << x << ", " << y;
      }
    }
}

TEST(Graphics, EdgesAreAveragedInLinearLight) {
  Drawing drawing;
  drawing.add(leftPart(1.0f / 32, 0.5f), vec4(1, 1, 1, 1));   // the right edge is at x = 33 pixels
  drawing.add(leftPart(-0.984375f, 0.4f), vec4(0, 0, 0, 0));  // and one at x = 0.5
  drawing.draw(vec4(0, 0, 0, 0));
  EXPECT_EQ(drawing.at(32, 20), (Pixel{255, 255, 255, 255}));
  EXPECT_EQ(drawing.at(33, 20), (Pixel{0, 0, 0, 0}));
  // two of four samples: half the light is 188 of 255 in sRGB (IEC 61966-2-1), half the coverage is 128
  const Pixel half = drawing.at(0, 20);
  EXPECT_NEAR(half.r, 188, 1);
  EXPECT_NEAR(half.a, 128, 1);
}

TEST(Graphics, DepthTestWorksInAnyOrder) {
  for (const bool near_first : {true, false}) {
    Drawing drawing;
    const auto near = leftPart(0, 0.2f), far = leftPart(1, 0.8f);
    drawing.add(near_first ? near : far, near_first ? kRed : kGreen);
    drawing.add(near_first ? far : near, near_first ? kGreen : kRed);
    drawing.draw();
    EXPECT_EQ(drawing.at(10, 10), (Pixel{255, 0, 0, 255}));
    EXPECT_EQ(drawing.at(50, 10), (Pixel{0, 255, 0, 255}));
  }
}

TEST(Graphics, AlphaBlendsWithTheBackground) {
  GraphicsOptions options;
  options.blend = Blend::kAlpha;
  Drawing drawing(options);
  drawing.add(leftPart(1, 0.5f), vec4(1, 1, 1, 0.5f));
  drawing.draw(kBlack);
  EXPECT_NEAR(drawing.at(5, 5).g, 188, 1);
  EXPECT_EQ(drawing.at(5, 5).a, 255);
}

TEST(Graphics, CullsBackFacesOnRequest) {
  GraphicsOptions options;
  options.cull = VK_CULL_MODE_BACK_BIT;
  Drawing drawing(options);
  drawing.add({{-1, -1, 0.5f}, {-1, 1, 0.5f}, {0, -1, 0.5f}}, kGreen);  // counterclockwise: visible
  drawing.add({{1, -1, 0.5f}, {1, 1, 0.5f}, {0, -1, 0.5f}}, kRed);      // clockwise: culled
  drawing.draw();
  EXPECT_EQ(drawing.at(2, 2), (Pixel{0, 255, 0, 255}));
  EXPECT_EQ(drawing.at(61, 2), (Pixel{0, 0, 0, 255}));
}

TEST(Graphics, ConstantsSpecializeTheShaders) {
  GraphicsOptions options;
  options.constants = {1};
  Drawing drawing(options);
  drawing.add(leftPart(1, 0.5f), vec4(1, 1, 1, 1));
  drawing.draw();
  EXPECT_EQ(drawing.at(5, 5), (Pixel{255, 0, 0, 255}));
}

TEST(Graphics, DepthPassWritesDepth) {
  Gpu& gpu = testGpu();
  GraphicsOptions options;
  options.has_color = false;
  options.samples = 1;
  const GraphicsPipeline<TrianglesArgs> pipeline(gpu, "depths", {triangles_vert, {}}, options);
  Image depth(gpu, ImageKind::kDepth, kWidth, kHeight);
  const Buffer<vec3> corners(gpu, leftPart(0, 0.25f));
  Buffer<float> depths(gpu, kWidth * kHeight, Memory::kHost);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("draw");
  render(recorder, {.depth = &depth, .clear_depth = 1.0f}, {draw(pipeline, TrianglesArgs{corners, kRed}, 6)});
  copyToBuffer(recorder, depth, depths.raw());
  recorder.submitAndWait();
  EXPECT_EQ(depths.host()[5 * kWidth + 5], 0.25f);
  EXPECT_EQ(depths.host()[5 * kWidth + 60], 1.0f);
}

TEST(Graphics, DepthOnlyDrawOccludes) {
  Gpu& gpu = testGpu();
  GraphicsOptions options;
  options.blend = Blend::kDepthOnly;
  const GraphicsPipeline<TrianglesArgs> hides(gpu, "hides", {triangles_vert, {}}, options),
      paints(gpu, "paints", {triangles_vert, triangles_frag});
  Canvas canvas(gpu, kWidth, kHeight);
  const Buffer<vec3> near(gpu, leftPart(0, 0.2f)), far(gpu, leftPart(1, 0.8f));
  Buffer<std::uint32_t> image(gpu, kWidth * kHeight, Memory::kHost);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("draw");
  render(recorder, canvas.pass(kBlack),
         {draw(hides, TrianglesArgs{near, kRed}, 6), draw(paints, TrianglesArgs{far, kGreen}, 6)});
  copyToBuffer(recorder, canvas.resolved, image.raw());
  recorder.submitAndWait();
  EXPECT_EQ(image.host()[10 * kWidth + 5], 0xFF000000u);
  EXPECT_EQ(image.host()[10 * kWidth + 60], 0xFF00FF00u);
}

TEST(Graphics, SupportsIndirectCounts) {
  Gpu& gpu = testGpu();
  const GraphicsPipeline<TrianglesArgs> pipeline(gpu, "triangles", {triangles_vert, triangles_frag});
  Canvas canvas(gpu, kWidth, kHeight);
  const Buffer<vec3> corners(gpu, leftPart(1, 0.5f));  // two triangles, of which one is drawn
  Buffer<std::uint32_t> counts(gpu, 4), image(gpu, kWidth * kHeight, Memory::kHost);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("draw");
  const std::uint32_t one_triangle[4] = {3, 1, 0, 0};
  recorder.update(counts.raw(), one_triangle, sizeof one_triangle);
  render(recorder, canvas.pass(kBlack),
         {drawCounted(pipeline, TrianglesArgs{corners, kGreen}, counts.raw())});
  copyToBuffer(recorder, canvas.resolved, image.raw());
  recorder.submitAndWait();
  EXPECT_TRUE(recorder.commands()[1].barrier_before);
  EXPECT_EQ(image.host()[40 * kWidth + 5], 0xFF00FF00u);  // below the diagonal
  EXPECT_EQ(image.host()[5 * kWidth + 60], 0xFF000000u);
}

TEST(Graphics, SupportsIndices) {
  Gpu& gpu = testGpu();
  const GraphicsPipeline<TrianglesArgs> pipeline(gpu, "triangles", {triangles_vert, triangles_frag});
  Canvas canvas(gpu, kWidth, kHeight);
  const Buffer<vec3> corners(gpu,
                             std::vector<vec3>{{-1, -1, 0.5f}, {1, -1, 0.5f}, {-1, 1, 0.5f}, {1, 1, 0.5f}});
  Buffer<std::uint32_t> indices(gpu, std::size_t(6)), image(gpu, kWidth * kHeight, Memory::kHost);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("draw");
  const std::uint32_t square[6] = {0, 2, 3, 0, 3, 1};
  recorder.update(indices.raw(), square, sizeof square);
  render(recorder, canvas.pass(kBlack), {drawIndexed(pipeline, TrianglesArgs{corners, kGreen}, indices)});
  copyToBuffer(recorder, canvas.resolved, image.raw());
  recorder.submitAndWait();
  EXPECT_TRUE(recorder.commands()[1].barrier_before);
  EXPECT_EQ(std::count(image.host().begin(), image.host().end(), 0xFF00FF00u), kWidth * kHeight);
}

TEST(Graphics, DrawWaitsForTheKernelThatWritesItsBuffer) {
  Gpu& gpu = testGpu();
  const GraphicsPipeline<TrianglesArgs> pipeline(gpu, "triangles", {triangles_vert, triangles_frag});
  Canvas canvas(gpu, kWidth, kHeight);
  const Buffer<vec3> corners(gpu, 3);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("draw");
  recorder.fill(corners.raw(), 0);
  render(recorder, canvas.pass(kBlack), {draw(pipeline, TrianglesArgs{corners, kRed}, 3)});
  recorder.fill(corners.raw(), 0);
  recorder.submitAndWait();
  ASSERT_EQ(recorder.commands().size(), 3u);
  EXPECT_TRUE(recorder.commands()[1].barrier_before);
  EXPECT_TRUE(recorder.commands()[2].barrier_before);
}

TEST(Graphics, ScreenImageIsBgraAndCopiedCompletely) {
  Gpu& gpu = testGpu();
  GraphicsOptions options;
  options.color_kind = ImageKind::kScreen;
  options.has_depth = false;
  options.depth_test = false;
  options.samples = 1;
  const GraphicsPipeline<TrianglesArgs> pipeline(gpu, "screen", {triangles_vert, triangles_frag}, options);
  Image drawn(gpu, ImageKind::kScreen, kWidth, kHeight), copied(gpu, ImageKind::kScreen, kWidth, kHeight);
  const Buffer<vec3> corners(gpu, leftPart(0, 0.5f));
  Buffer<std::uint32_t> words(gpu, kWidth * kHeight, Memory::kHost);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("draw");
  render(recorder, {.color = &drawn, .clear_color = kBlack},
         {draw(pipeline, TrianglesArgs{corners, kRed}, 6)});
  copyImage(recorder, drawn, copied);
  copyToBuffer(recorder, copied, words.raw());
  recorder.submitAndWait();
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x)
      ASSERT_EQ(words.host()[y * kWidth + x], x < kWidth / 2 ? 0xFFFF0000u : 0xFF000000u) << x << ", " << y;
}

TEST(Graphics, RejectsInvalidDraws) {
  Gpu& gpu = testGpu();
  EXPECT_THROW(Image(gpu, ImageKind::kColor, 0, 10), Error);
  EXPECT_THROW(Image(gpu, ImageKind::kColor, 10, 1u << 30), Error);
  // a shader that writes through an argument
  EXPECT_THROW(RawGraphicsPipeline(gpu, "writes", {carve_blocks_comp, triangles_frag}, {}, 128), Error);
  Image image(gpu, ImageKind::kColor, 8, 8);
  const Buffer<std::uint32_t> small(gpu, 63);
  Recorder recorder(gpu);
  recorder.begin();
  EXPECT_THROW(copyToBuffer(recorder, image, small.raw()), Error);
  Image other(gpu, ImageKind::kScreen, 8, 8), larger(gpu, ImageKind::kColor, 8, 9);
  EXPECT_THROW(copyImage(recorder, image, other), Error);
  EXPECT_THROW(copyImage(recorder, image, larger), Error);
  recorder.submitAndWait();
}

}  // namespace
}  // namespace airclay
