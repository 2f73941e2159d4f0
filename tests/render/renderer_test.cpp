// SPDX-License-Identifier: MIT
// Images compared with geometry: areas, positions, counts, order, light and shadow.
#include "engine/render/renderer.h"

#include <cmath>

#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/hull/carve.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

constexpr int kWidth = 320, kHeight = 240;

struct Pixel {
  int r, g, b;
  int sum() const { return r + g + b; }
  bool operator==(const Pixel&) const = default;
};

class Painting {
 public:
  explicit Painting(const RendererOptions& options = {.width = kWidth,
                                                      .height = kHeight,
                                                      .multisample = false})
      : renderer_(testGpu(), options), recorder_(testGpu()) {}

  const Painting& paint(const Scene& scene, const View& view) {
    recorder_.begin();
    renderer_.record(recorder_, scene, view);
    recorder_.submitAndWait();
    EXPECT_TRUE(hazards(recorder_.commands()).empty());
    pixels_.assign(renderer_.pixels().begin(), renderer_.pixels().end());
    return *this;
  }
  Pixel at(int x, int y) const {
    const std::uint32_t p = pixels_[static_cast<std::size_t>(y * renderer_.width() + x)];
    return {int(p & 255), int(p >> 8 & 255), int(p >> 16 & 255)};
  }
  const std::vector<std::uint32_t>& pixels() const { return pixels_; }
  const Renderer& renderer() const { return renderer_; }
  /// Number of commands in the last image.
  std::size_t commands() const { return recorder_.commands().size(); }

 private:
  Renderer renderer_;
  Recorder recorder_;
  std::vector<std::uint32_t> pixels_;
};

/// Number of different pixels.
int differing(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

TriangleMesh sphere(const Vec3& center, double radius_m) {
  constexpr int kAround = 128, kUp = 64;
  TriangleMesh mesh;
  for (int j = 0; j <= kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const double latitude = M_PI * (double(j) / kUp - 0.5), longitude = 2 * M_PI * i / kAround;
      mesh.vertices.push_back(center + radius_m * Vec3(std::cos(latitude) * std::cos(longitude),
                                                       std::cos(latitude) * std::sin(longitude),
                                                       std::sin(latitude)));
      if (j == kUp) continue;
      const int a = i + kAround * j, b = (i + 1) % kAround + kAround * j;
      mesh.triangles.push_back({a, b, b + kAround});
      mesh.triangles.push_back({a, b + kAround, a + kAround});
    }
  return mesh;
}

/// A horizontal square facing up, finely divided, because light is computed per vertex.
TriangleMesh plate(double half_m, double z_m) {
  constexpr int kCells = 80;
  TriangleMesh mesh;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      mesh.vertices.emplace_back(half_m * (2.0 * i / kCells - 1), half_m * (2.0 * j / kCells - 1), z_m);
      if (i == kCells || j == kCells) continue;
      const int low = i + (kCells + 1) * j, high = low + kCells + 1;
      mesh.triangles.push_back({low, low + 1, high + 1});
      mesh.triangles.push_back({low, high + 1, high});
    }
  return mesh;
}

SceneMesh solid(const RenderMesh& mesh, const vec3& albedo = clayColor()) {
  SceneMesh result;
  result.surface = mesh.surface();
  result.albedo = albedo;
  result.open = false;
  return result;
}

View fromTheFront(double distance_m) {
  return lookAt(Vec3(0, -distance_m, 0), Vec3::Zero());
}

TEST(Renderer, SphereSilhouetteHasTheConeArea) {
  const double radius_m = 0.1, distance_m = 0.6;
  const RenderMesh ball(testGpu(), sphere(Vec3::Zero(), radius_m));
  Scene scene;
  Painting painting({.width = 1000, .height = 800, .multisample = false});
  const View view = fromTheFront(distance_m);
  const std::vector<std::uint32_t> empty = painting.paint(scene, view).pixels();
  scene.meshes.push_back(solid(ball));
  painting.paint(scene, view);
  // the cone tangent to the sphere has the half angle asin(r / d)
  const double focal = 400 / std::tan(0.5 * view.vertical_fov_rad);
  const double radius_px = focal * std::tan(std::asin(radius_m / distance_m));
  EXPECT_NEAR(differing(painting.pixels(), empty) / (M_PI * radius_px * radius_px), 1, 0.003);
}

TEST(Renderer, CameraViewMatchesTheProjection) {
  Rig rig = ringRig(4, kWidth, kHeight);
  rig.workspace.center = Vec3(0.03, -0.02, 0.05);
  for (Camera& camera : rig.cameras) {
    camera.lens.distortion = {};
    camera.lens = withMonotonicRange(camera.lens);
    const Vec3 point_in_world(0.08, 0.05, -0.1);
    Scene scene;
    scene.workspace = rig.workspace;
    Painting painting;
    const View view = cameraView(camera, rig.workspace);
    const std::vector<std::uint32_t> empty = painting.paint(scene, view).pixels();
    SceneStrokes dot;
    dot.dots = true;
    dot.width_px = 24;
    dot.workspace_from_strokes = Eigen::Translation3d(0.1, -0.3, 0.2) * Eigen::AngleAxisd(2, Vec3::UnitY());
    dot.host_points = {dot.workspace_from_strokes.inverse() * (point_in_world - rig.workspace.center)};
    scene.strokes = {dot};
    painting.paint(scene, view);
    Vec2 sum = Vec2::Zero();
    int count = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (painting.pixels()[static_cast<std::size_t>(y * kWidth + x)] !=
            empty[static_cast<std::size_t>(y * kWidth + x)]) {
          sum += Vec2(x, y);
          ++count;
        }
    ASSERT_GT(count, 20);
    EXPECT_LT((sum / count - project(camera, point_in_world).value()).norm(), 0.25) << camera.name;
  }
}

TEST(Renderer, ShadowedClayIsDarker) {
  const RenderMesh ground(testGpu(), plate(0.25, -0.1)), ball(testGpu(), sphere(Vec3(0, 0, 0.08), 0.05));
  Scene scene;
  scene.meshes.push_back(solid(ground));
  const View view = lookAt(Vec3(0, -0.8, 0.8), Vec3::Zero());
  Painting lit, shaded;
  lit.paint(scene, view);
  scene.meshes.push_back(solid(ball));
  shaded.paint(scene, view);
  int darker = 0, same = 0;
  for (int y = kHeight / 2; y < kHeight; ++y)  // the ball is in the upper half
    for (int x = 0; x < kWidth; ++x) {
      const int change = shaded.at(x, y).sum() - lit.at(x, y).sum();
      EXPECT_LE(change, 6);
      darker += change < -120;
      same += std::abs(change) <= 6;
    }
  EXPECT_GT(darker, 300);
  EXPECT_GT(same, 15000);
}

TEST(Renderer, NearerSurfaceHidesTheFarther) {
  const RenderMesh near(testGpu(), sphere(Vec3(0, -0.15, 0), 0.05)),
      far(testGpu(), sphere(Vec3(0, 0.1, 0), 0.12));
  const vec3 red(0.6f, 0.02f, 0.02f), green(0.02f, 0.6f, 0.02f);
  for (const bool near_first : {true, false}) {
    Scene scene;
    scene.meshes.push_back(near_first ? solid(near, red) : solid(far, green));
    scene.meshes.push_back(near_first ? solid(far, green) : solid(near, red));
    SceneStrokes hidden;  // runs between the balls, behind the near one
    hidden.host_points = {Vec3(-0.02, -0.05, 0), Vec3(0.02, -0.05, 0)};
    hidden.color = vec3(0, 0, 1);
    hidden.width_px = 6;
    scene.strokes = {hidden};
    Painting painting;
    painting.paint(scene, fromTheFront(0.8));
    const Pixel middle = painting.at(kWidth / 2, kHeight / 2),
                side = painting.at(kWidth / 2 + 50, kHeight / 2);
    EXPECT_GT(middle.r, 2 * middle.g);
    EXPECT_GT(middle.r, 2 * middle.b);
    EXPECT_GT(side.g, 2 * side.r);
  }
}

TEST(Renderer, ClayIsVisibleThroughTheHand) {
  const RenderMesh clay(testGpu(), sphere(Vec3(0, 0.1, 0), 0.12));
  const RenderMesh skin = RenderMesh::withDistances(testGpu(), sphere(Vec3(0, -0.15, 0), 0.05));
  const auto middle = [&](const vec3& albedo, double opacity) {
    Scene scene;
    scene.meshes.push_back(solid(clay, albedo));
    SceneHand hand;
    hand.skin = &skin;
    hand.opacity = opacity;
    scene.hand = hand;
    Painting painting;
    return painting.paint(scene, fromTheFront(0.8)).at(kWidth / 2, kHeight / 2);
  };
  const vec3 red(0.6f, 0.02f, 0.02f), green(0.02f, 0.6f, 0.02f);
  const Pixel before_red = middle(red, 0.4), before_green = middle(green, 0.4);
  EXPECT_GT(before_red.r, before_green.r + 20);
  EXPECT_LT(before_red.g, before_green.g - 20);
  // the hand is visible, too
  EXPECT_GT(before_green.r, 60);
  EXPECT_EQ(middle(red, 1), middle(green, 1));
}

TEST(Renderer, DrawsEverySurfaceVoxel) {
  const Rig rig = ringRig(5);
  const GpuRig gpu_rig(testGpu(), rig);
  for (const int voxels : {40, 64}) {
    Carver carver(testGpu(), gpu_rig, voxels);
    Buffer<std::uint32_t> masks(testGpu(), gpu_rig.maskWords(), Memory::kHost);
    gpu_rig.pack(sphereMasks(rig, Vec3(0.05, 0.02, -0.03), 0.13), masks.host());
    Recorder recorder(testGpu());
    recorder.begin();
    carver.record(recorder, masks);
    recorder.submitAndWait();
    const VoxelGrid grid = carver.download();
    const auto filled = [&](int x, int y, int z) {
      const bool inside = x >= 0 && y >= 0 && z >= 0 && x < voxels && y < voxels && z < voxels;
      return inside && grid.at(x, y, z);
    };
    std::uint32_t surface = 0;
    for (int z = 0; z < voxels; ++z)
      for (int y = 0; y < voxels; ++y)
        for (int x = 0; x < voxels; ++x)
          surface += filled(x, y, z) && !(filled(x - 1, y, z) && filled(x + 1, y, z) && filled(x, y - 1, z) &&
                                          filled(x, y + 1, z) && filled(x, y, z - 1) && filled(x, y, z + 1));
    ASSERT_GT(surface, 500u);
    Scene scene;
    Painting painting;
    const std::vector<std::uint32_t> empty = painting.paint(scene, fromTheFront(1)).pixels();
    scene.voxels = &carver;
    painting.paint(scene, fromTheFront(1));
    EXPECT_EQ(painting.renderer().drawnVoxelCount(), surface);
    EXPECT_GT(differing(painting.pixels(), empty), 3000);
  }
}

/// Clay, hand, ground, strokes and capsules together.
struct Everything {
  RenderMesh clay{testGpu(), sphere(Vec3(0, 0, 0), 0.09)};
  HandModel hand = builtInHand(false);
  RenderMesh skin = RenderMesh::withDistances(testGpu(), hand.skin);

  Scene scene(const Pose& workspace_from_hand) const {
    Scene result;
    result.meshes.push_back(solid(clay));
    SceneHand drawn;
    drawn.skin = &skin;
    drawn.workspace_from_hand = workspace_from_hand;
    result.hand = drawn;
    result.capsules = skeletonCapsules(hand, workspace_from_hand);
    result.strokes = {cubeEdges(result.workspace), meshEdges(presetCage("tube"), result.workspace)};
    result.strokes.back().hidden = 0.3;
    result.ground_z_m = -0.12;
    return result;
  }
};

TEST(Renderer, EqualScenesGiveEqualImages) {
  const Everything everything;
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(0.05, -0.1, 0.1);
  for (const bool multisample : {false, true}) {
    const RendererOptions options{.width = kWidth, .height = kHeight, .multisample = multisample};
    Painting first(options), second(options);
    const View view = orbitView({});
    first.paint(everything.scene(pose), view);
    second.paint(everything.scene(pose), view);
    EXPECT_EQ(differing(first.pixels(), second.pixels()), 0);
    second.paint(everything.scene(pose), view);
    EXPECT_EQ(differing(first.pixels(), second.pixels()), 0);
    Pose moved = pose;
    moved.translation().x() += 0.03;
    second.paint(everything.scene(moved), view);
    EXPECT_GT(differing(first.pixels(), second.pixels()), 1000);
  }
}

TEST(Renderer, NearHandDarkensFacingClay) {
  const RenderMesh clay(testGpu(), plate(0.25, 0));
  const TriangleMesh ball = sphere(Vec3::Zero(), 0.04);
  const RenderMesh skin = RenderMesh::withDistances(testGpu(), ball);
  // from below, through the plate's back face, nothing stands between the eye and the clay
  const auto under = [&](double gap_m) {
    Scene scene;
    scene.meshes.push_back(solid(clay));
    scene.meshes.back().open = true;
    SceneHand hand;
    hand.skin = &skin;
    hand.workspace_from_hand.translation() = Vec3(0, 0, -0.04 - gap_m);
    hand.opacity = 0.02;
    scene.hand = hand;
    Painting painting;
    return painting.paint(scene, lookAt(Vec3(0, 0, -0.9), Vec3::Zero())).at(kWidth / 2, kHeight / 2).sum();
  };
  const int nearest = under(0.006), near = under(0.02), far = under(0.1);  // none of them touches
  EXPECT_LT(nearest, near - 10);
  EXPECT_LT(near, far - 10);
}

TEST(Renderer, ClayIsWarmOnlyAtTheContact) {
  constexpr double kRadius = 0.04;
  const RenderMesh clay(testGpu(), plate(0.25, 0));
  const RenderMesh skin = RenderMesh::withDistances(testGpu(), sphere(Vec3::Zero(), kRadius));
  // a ball of skin over a plate: at r from its lowest point the plate is sqrt(r² + h²) - radius away from it.
  // Seen from below, where the plate hides the skin; how much redder than grey clay of the same light a point
  // is tells its tint.
  const auto tint = [&](double height_m, double r_m, bool shows) {
    Scene scene;
    scene.meshes.push_back(solid(clay, vec3::Constant(0.4f)));
    scene.meshes.back().open = true;
    scene.meshes.back().shows_touch = shows;
    SceneHand hand;
    hand.skin = &skin;
    hand.workspace_from_hand.translation() = Vec3(0, 0, height_m);
    scene.hand = hand;
    Painting painting;
    const View view = lookAt(Vec3(0, 0, -0.9), Vec3::Zero());
    const Vec3 seen = view.camera_from_workspace * Vec3(r_m, 0, 0);
    const double focal_px = 0.5 * kHeight / std::tan(0.5 * view.vertical_fov_rad);
    const Pixel pixel = painting.paint(scene, view)
                            .at(static_cast<int>(0.5 * kWidth + focal_px * seen.x() / seen.z()),
                                static_cast<int>(0.5 * kHeight + focal_px * seen.y() / seen.z()));
    return double(pixel.r) / std::max(pixel.b, 1);
  };
  const double untinted = tint(kRadius, 0, false);
  EXPECT_GT(tint(kRadius, 0, true), 1.5 * untinted);                           // the ball touches the plate
  EXPECT_GT(tint(kRadius - 0.01, 0, true), 1.5 * untinted);                    // and penetrates it by 1 cm
  EXPECT_GT(tint(kRadius, 0.012, true), 1.2 * untinted);                       // 1.8 mm away
  EXPECT_NEAR(tint(kRadius, 0.030, true), tint(kRadius, 0.030, false), 0.01);  // 10 mm
  EXPECT_NEAR(tint(kRadius + 0.02, 0, true), tint(kRadius + 0.02, 0, false), 0.01);
  EXPECT_NEAR(tint(kRadius + 0.005, 0, true), tint(kRadius + 0.005, 0, false), 0.02);
}

TEST(Renderer, DisplaySurfaceIsAFurtherSubdivision) {
  const PolygonMesh cage = presetCage("tube");
  Workspace workspace;
  workspace.center = Vec3(0.1, 0.2, -0.3);
  DisplaySurface display(testGpu(), cage, SubdivisionRule::kPrinted, 2);
  display.evaluate(cage.points, workspace);
  const Subdivision finer = subdivide(cage, 4, SubdivisionRule::kPrinted);
  const std::vector<Vec3> expected = dataPoints(finer.matrix, cage.points);
  const std::vector<vec3> points = display.surface().positions->download();
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((points[i].cast<double>() + workspace.center - expected[i]).norm(), 1e-6);
  // no finer than asked for
  DisplaySurface coarse(testGpu(), cage, SubdivisionRule::kPrinted, 2, {.refine_below_points = 400});
  EXPECT_EQ(coarse.surface().positions->count(), 364u);
}

TEST(Renderer, CoarserDisplaySurfaceHasFewerLevels) {
  const PolygonMesh cage = presetCage("tube");  // 28, 98, 364, 1400 points
  DisplayDetail detail;
  detail.coarsen_above_points = 500;
  const DisplaySurface coarse(testGpu(), cage, SubdivisionRule::kCatmullClark, 3, detail);
  EXPECT_EQ(coarse.surface().positions->count(), 364u);
  detail.coarsen_above_points = 20;  // one step is the least
  const DisplaySurface coarsest(testGpu(), cage, SubdivisionRule::kCatmullClark, 3, detail);
  EXPECT_EQ(coarsest.surface().positions->count(), 98u);
}

TEST(Renderer, DrawnAndCopiedBackdropsAreEqual) {
  // with samples it is drawn in each image, without them once and then copied
  Painting drawn({.width = kWidth, .height = kHeight, .multisample = true}), copied;
  for (const int grey : {236, 236, 120}) {
    Scene scene;
    scene.backdrop_top = colorFromSrgb(grey, 233, 228);
    EXPECT_EQ(differing(drawn.paint(scene, fromTheFront(1)).pixels(),
                        copied.paint(scene, fromTheFront(1)).pixels()),
              0);
  }
}

TEST(Renderer, TiledRenderingGivesTheSameImage) {
  const RenderMesh ball(testGpu(), sphere(Vec3(0.02, 0, 0), 0.1)), floor(testGpu(), plate(0.2, -0.12));
  const RenderMesh skin = RenderMesh::withDistances(testGpu(), sphere(Vec3(0, -0.1, 0.05), 0.04));
  Scene scene;
  scene.ground_z_m = -0.2;
  scene.meshes = {solid(ball), solid(floor)};
  scene.hand = SceneHand{&skin, Pose::Identity()};
  scene.strokes = {cubeEdges(scene.workspace)};
  RendererOptions options{.width = kWidth, .height = kHeight, .multisample = false};
  Painting whole(options);
  const std::vector<std::uint32_t> expected = whole.paint(scene, fromTheFront(0.8)).pixels();
  for (const std::uint32_t triangles : {1000u, 7001u, 30'000u, 300'000u}) {
    options.max_submission_triangles = triangles;
    Painting pieces(options);
    EXPECT_EQ(differing(pieces.paint(scene, fromTheFront(0.8)).pixels(), expected), 0) << triangles;
    EXPECT_EQ(pieces.commands() > whole.commands(), triangles < 300'000) << triangles;
  }
}

TEST(Renderer, GroundIsVisibleInShadow) {
  const RenderMesh ball(testGpu(), sphere(Vec3(0, 0, 0.05), 0.05));
  const auto image = [&](bool has_ground, bool has_ball) {
    Scene scene;
    if (has_ground) scene.ground_z_m = -0.1;
    if (has_ball) scene.meshes.push_back(solid(ball));
    Painting painting;
    return painting.paint(scene, lookAt(Vec3(0, -0.9, 0.5), Vec3::Zero())).pixels();
  };
  EXPECT_EQ(differing(image(true, false), image(false, false)), 0);  // no shadow: only the backdrop
  // the key light's shadow of the ball: a disc of 5 cm at 0.9 m or more covers at least some hundred pixels
  const int shaded = differing(image(true, true), image(false, true));
  EXPECT_GT(shaded, 300);
  EXPECT_LT(shaded, kWidth * kHeight / 2);
}

TEST(Renderer, RejectsInvalidImageSize) {
  EXPECT_THROW(Renderer(testGpu(), {.width = 0, .height = 10}), Error);
  EXPECT_THROW(Renderer(testGpu(), {.width = 10, .height = 5000}), Error);
  EXPECT_NO_THROW(Renderer(testGpu(), {.width = 1, .height = 1}));
}

}  // namespace
}  // namespace airclay
