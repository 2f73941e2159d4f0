// SPDX-License-Identifier: MIT
// Offscreen images of the clay, the hand and the cameras in a studio: a soft key light, a seamless backdrop,
// and a ground that receives shadows.
//
//     Renderer renderer(gpu, {.width = 1280, .height = 720});
//     Scene scene;
//     scene.meshes.push_back({.surface = surfaceOf(clay)});
//     scene.hand = SceneHand{&skin, workspace_from_hand};
//     renderer.record(recorder, scene, orbitView({}));
//     recorder.submitAndWait();
//     renderer.pixels()
//
// All points and poses are in metres in the workspace frame: the world frame moved to the workspace's centre.
#pragma once

#include <memory>
#include <optional>

#include "engine/camera/rig.h"
#include "engine/clay/subdivide.h"
#include "engine/gpu/graphics.h"
#include "engine/hand/hand_model.h"
#include "engine/mesh/distance_grid.h"
#include "shaders/render/renderer_io.h"

namespace airclay {

class Carver;
struct RenderVoxelArgs;

// ----------------------------------------------------------------------------------------------------------
// views

/// A pinhole camera.
struct View {
  Pose camera_from_workspace = Pose::Identity();  ///< OpenCV axes: x right, y down, z forward
  double vertical_fov_rad = 0.5;
  /// The principal point relative to the image centre, right and down, in image heights.
  Vec2 axis_shift = Vec2::Zero();
};

/// The view from `eye` towards `target`, z up (y up when looking straight down or up).
View lookAt(const Vec3& eye, const Vec3& target, double vertical_fov_rad = 0.5);

/// A view around a target: azimuth from x towards y, elevation from the horizontal plane.
struct Orbit {
  Vec3 target = Vec3::Zero();
  double azimuth_rad = -1.05, elevation_rad = 0.42, distance_m = 1.0;
  double vertical_fov_rad = 0.5;
};
View orbitView(const Orbit& orbit);

/// Views from -y, +x and +z, in which the workspace cube fills 90 % of the image's height.
View frontView(const Workspace& workspace);
View sideView(const Workspace& workspace);
View topView(const Workspace& workspace);

/// A rig camera's view without lens distortion; for a fisheye lens, limited to what a pinhole camera can
/// show.
View cameraView(const Camera& camera, const Workspace& workspace);

Pose workspaceFromWorld(const Workspace& workspace);

// ---------------------------------------------------------------------------------------------------------
// scenes

/// A surface in device memory: three indices per triangle, counterclockwise seen from outside; unit normals.
struct SurfaceBuffers {
  const Buffer<vec3>* positions = nullptr;
  const Buffer<vec3>* normals = nullptr;
  const Buffer<std::uint32_t>* triangles = nullptr;
};

/// A triangle mesh uploaded for drawing.
class RenderMesh {
 public:
  /// Smooth shading, with vertexNormals(). Triangles are sorted so that adjacent ones are close in memory.
  RenderMesh(Gpu& gpu, const TriangleMesh& mesh);
  /// The same with a signed distance grid around the mesh, for the contact shadow of a hand.
  static RenderMesh withDistances(Gpu& gpu, const TriangleMesh& mesh);
  /// Flat shading, for cages and subdivision levels.
  static RenderMesh faceted(Gpu& gpu, const PolygonMesh& mesh);

  SurfaceBuffers surface() const { return {&positions_, &normals_, &triangles_}; }
  /// Without values if there is no grid.
  const DistanceGrid& grid() const { return grid_; }
  const Buffer<float>& gridValues() const { return grid_values_; }

 private:
  RenderMesh(Gpu& gpu, const TriangleMesh& mesh, const std::vector<Vec3>& normals);

  Buffer<vec3> positions_, normals_;
  Buffer<std::uint32_t> triangles_;
  DistanceGrid grid_;
  Buffer<float> grid_values_;
};

/// Limits of the subdivision levels that are drawn, independent of the clay's own levels.
struct DisplayDetail {
  int refine_below_points = 12'000;    ///< up to two levels finer while the points do not exceed this
  int coarsen_above_points = 1 << 30;  ///< coarser, down to level 1, while the points exceed this
};

/// The clay's surface for display, subdivided further than its data points so that no facets show.
class DisplaySurface {
 public:
  DisplaySurface(Gpu& gpu, const PolygonMesh& cage, SubdivisionRule rule, int levels,
                 const DisplayDetail& detail = {});

  /// Records the surface of these control points (clay frame, metres: Clay::controlPoints()).
  void record(Recorder& recorder, const Buffer<vec3>& control_points) {
    evaluator_.record(recorder, control_points);
  }
  /// The same in a separate submission, for control points in the world frame, metres.
  void evaluate(const std::vector<Vec3>& control_points, const Workspace& workspace);

  SurfaceBuffers surface() const {
    return {&evaluator_.dataPoints(), &evaluator_.normals(), &evaluator_.triangles()};
  }

 private:
  Gpu& gpu_;
  SurfaceEvaluator evaluator_;
};

/// Linear RGB of an sRGB colour (0 to 255).
vec3 colorFromSrgb(int red, int green, int blue);

/// The colour of plasticine: a warm terracotta grey.
vec3 clayColor();
vec3 skinColor();

/// An opaque mesh, such as the clay.
struct SceneMesh {
  SurfaceBuffers surface;
  Pose workspace_from_mesh = Pose::Identity();
  vec3 albedo = clayColor();
  bool open = true;         ///< an open surface, lit on both sides
  bool shows_touch = true;  ///< tinted where the hand's skin is within 3 mm or inside
};

struct SceneHand {
  const RenderMesh* skin = nullptr;
  Pose workspace_from_hand = Pose::Identity();
  const RenderMesh* forearm = nullptr;  ///< optional; hand frame
  double opacity = 0.42;                ///< at normal incidence; 1 is opaque
  vec3 albedo = skinColor();
};

/// Lines (two points each) or dots, from device or host memory.
struct SceneStrokes {
  const Buffer<vec3>* points = nullptr;
  const Buffer<std::uint32_t>* indices = nullptr;  ///< two per line, one per dot; null: all points in order
  std::vector<Vec3> host_points;                   ///< used if `points` is null
  Pose workspace_from_strokes = Pose::Identity();
  vec3 color = vec3(0.02f, 0.02f, 0.025f);
  double width_px = 2;  ///< line width or dot diameter in an image 720 pixels high
  double hidden = 0;    ///< opacity of parts that are occluded
  bool dots = false;
};

/// The twelve edges of the workspace cube.
SceneStrokes cubeEdges(const Workspace& workspace);
/// The circle in which the symmetry plane through the origin, perpendicular to `axis`, intersects a sphere
/// around the origin.
SceneStrokes symmetryRing(int axis, double radius_m);
/// The rig's cameras as pyramids of the given length.
SceneStrokes cameraFrusta(const Rig& rig, double length_m);
/// Two point indices per edge of a polygon mesh, each edge once.
std::vector<std::uint32_t> edgeIndices(const std::vector<std::vector<int>>& faces);
/// The edges of a polygon mesh, which is in the world frame.
SceneStrokes meshEdges(const PolygonMesh& mesh, const Workspace& workspace);

/// A capsule from a to b; with radius 0 at b, a cone.
struct SceneCapsule {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double radius_a_m = 0.003, radius_b_m = 0.003;
  vec3 albedo = vec3(0.7f, 0.66f, 0.58f);
};

/// The skeleton in its rest pose: bones and joints.
std::vector<SceneCapsule> skeletonCapsules(const HandModel& hand, const Pose& workspace_from_hand);

/// The content of an image. Pointers must stay valid until the recorded work is done.
struct Scene {
  Workspace workspace;
  std::vector<SceneMesh> meshes;
  std::optional<SceneHand> hand;
  const Carver* voxels = nullptr;
  vec3 voxel_albedo = vec3(0.20f, 0.33f, 0.42f);
  std::vector<SceneStrokes> strokes;
  std::vector<SceneCapsule> capsules;
  std::optional<double> ground_z_m;  ///< height of the ground; empty: no ground
  vec3 backdrop_top = colorFromSrgb(236, 233, 228), backdrop_bottom = colorFromSrgb(206, 201, 195);
};

// -------------------------------------------------------------------------------------------------------
// renderer

struct RendererOptions {
  int width = 1280, height = 720;  ///< pixels, at most kMaxImage
  bool multisample = true;         ///< 4 samples per pixel
  int shadow_map = 1024;           ///< texels along an edge
  int shadow_taps = 64;            ///< samples of the soft shadow's filter
  int ground_vertices = 64;        ///< along an edge; the ground's lighting is computed at these
  bool readback = true;            ///< for pixels(); otherwise a window copies image()
  /// Divides an image into submissions of about this many triangles, so that none takes long; 0: one
  /// submission.
  std::uint32_t max_submission_triangles = 0;

  static constexpr int kMaxImage = 4096;

  /// Settings that a software device can draw in real time.
  static RendererOptions live(int width, int height) {
    return {.width = width,
            .height = height,
            .multisample = false,
            .shadow_map = 512,
            .shadow_taps = 16,
            .max_submission_triangles = 30'000};
  }
};

class Renderer {
 public:
  /// \throw Error if the size is out of bounds.
  Renderer(Gpu& gpu, const RendererOptions& options);
  ~Renderer();

  /// Records the image of a scene; pixels() returns it once the recorded work is done. One image per
  /// submission; a large one may divide it. \pre earlier recorded work is done
  void record(Recorder& recorder, const Scene& scene, const View& view);

  int width() const { return options_.width; }
  int height() const { return options_.height; }
  /// The image, of the size in the options; its kind is ImageKind::kScreen without readback.
  Image& image() { return options_.multisample ? resolved_ : color_; }
  /// sRGB with alpha, one word per pixel, red in the lowest byte, rows from the top. \pre the recorded work
  /// is done
  std::span<const std::uint32_t> pixels() const { return pixels_.host(); }
  /// The same as bytes.
  std::span<const std::uint8_t> bytes() const;
  /// The number of voxels in the last image. \pre the recorded work is done
  std::uint32_t drawnVoxelCount() const;

 private:
  struct Pipelines;
  struct LitMesh;
  struct Voxels;

  /// Eye and key light of the image being recorded, workspace frame.
  struct Transforms {
    Eigen::Matrix4d clip_from_workspace, light_from_workspace;
    Vec3 eye, key_direction;                       ///< key_direction: towards the light
    double light_radius_m = 0, light_depth_m = 0;  ///< radius and depth range that the shadow map covers
  };

  void prepare(const Scene& scene);
  void setTransforms(const Scene& scene, const View& view);
  void writeFrame(const Scene& scene);
  void writeStrokes(const Scene& scene);
  void recordVoxelList(Recorder& recorder, const Scene& scene);
  void recordDensities(Recorder& recorder, const Scene& scene);
  void recordShadowMap(Recorder& recorder, const Scene& scene);
  void recordLights(Recorder& recorder, const Scene& scene);
  void recordBackdrop(Recorder& recorder, const Scene& scene);
  void recordFrame(Recorder& recorder, const Scene& scene);
  std::uint32_t remainingTriangles() const;
  void countTriangles(Recorder& recorder, std::uint32_t count);
  void divideIfLarge(Recorder& recorder);
  void drawDivided(Recorder& recorder, RenderPass pass, const std::vector<Draw>& draws);
  RenderMeshArgs meshArgs(const LitMesh& mesh, bool from_light) const;
  RenderCapsuleArgs capsuleArgs(bool from_light) const;
  RenderVoxelArgs voxelArgs(const Scene& scene, bool from_light) const;
  RenderBackdropArgs backdropArgs(const Scene& scene) const;
  void addStrokes(std::vector<Draw>& draws, const Scene& scene, bool hidden) const;

  Gpu& gpu_;
  RendererOptions options_;
  Transforms transforms_;
  std::unique_ptr<Pipelines> pipelines_;
  Image color_, depth_, resolved_, backdrop_, shadow_image_;
  vec3 backdrop_top_ = vec3::Constant(-1), backdrop_bottom_ = vec3::Zero();  ///< colours in backdrop_
  Buffer<float> shadow_map_;
  Buffer<RenderFrame> frame_;
  Buffer<vec3> ground_positions_, ground_normals_;
  Buffer<std::uint32_t> ground_triangles_;
  Buffer<VertexLight> ground_lights_, lights_;
  Buffer<std::uint32_t> areas_;
  Buffer<float> densities_;
  Buffer<vec3> stroke_points_;
  Buffer<RenderCapsule> capsules_;
  std::unique_ptr<Voxels> voxels_;
  std::uint32_t submission_triangles_ = 0;  ///< since the start of the image or the last division
  std::vector<LitMesh> lit_meshes_;         ///< of the image being recorded; the hand's parts last
  Buffer<std::uint32_t> pixels_;
};

}  // namespace airclay
