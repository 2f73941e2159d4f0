// SPDX-License-Identifier: MIT
// Images of the clay and what surrounds it, offscreen: a studio with a soft key light, a seamless backdrop,
// a ground that catches shadows.
//
//     Renderer renderer(gpu, {.width = 1280, .height = 720});
//     Scene scene;
//     scene.meshes.push_back({.surface = surfaceOf(clay)});
//     scene.hand = SceneHand{&skin, workspace_from_hand};
//     renderer.record(recorder, scene, orbitView({}));
//     recorder.submitAndWait();
//     renderer.pixels()
//
// All points and poses are in metres in the workspace's frame: the world moved to the workspace's centre.
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

/// Where an image is taken from: a pinhole camera.
struct View {
  Pose camera_from_workspace = Pose::Identity();  ///< OpenCV's axes: x right, y down, z forward
  double vertical_fov_rad = 0.5;
  /// Where the optical axis meets the image: from its middle to the right and down, in image heights.
  Vec2 axis_shift = Vec2::Zero();
};

/// From `eye` at `target`, z up (or y up when looking straight down or up).
View lookAt(const Vec3& eye, const Vec3& target, double vertical_fov_rad = 0.5);

/// Around a target: azimuth from x towards y, elevation from the horizontal plane.
struct Orbit {
  Vec3 target = Vec3::Zero();
  double azimuth_rad = -1.05, elevation_rad = 0.42, distance_m = 1.0;
  double vertical_fov_rad = 0.5;
};
View orbitView(const Orbit& orbit);

/// Along -y, -x and -z, so that the workspace's cube fills the image's height.
View frontView(const Workspace& workspace);
View sideView(const Workspace& workspace);
View topView(const Workspace& workspace);

/// A rig camera's own view, without its lens' distortion; a fisheye is narrowed to what a pinhole can show.
View cameraView(const Camera& camera, const Workspace& workspace);

Pose workspaceFromWorld(const Workspace& workspace);

// ---------------------------------------------------------------------------------------------------------
// scenes

/// A surface in device memory: three indices a triangle, anticlockwise from outside; unit normals.
struct SurfaceBuffers {
  const Buffer<vec3>* positions = nullptr;
  const Buffer<vec3>* normals = nullptr;
  const Buffer<std::uint32_t>* triangles = nullptr;
};

/// A triangle mesh brought to the device to be drawn.
class DrawnMesh {
 public:
  /// Smooth, with vertexNormals(). Neighbouring triangles are stored close to each other.
  DrawnMesh(Gpu& gpu, const TriangleMesh& mesh);
  /// The same, with a signed distance grid around it, for the shadow of a near hand.
  static DrawnMesh withDistances(Gpu& gpu, const TriangleMesh& mesh);
  /// Every polygon flat: a subdivision's steps, a cage.
  static DrawnMesh faceted(Gpu& gpu, const PolygonMesh& mesh);

  SurfaceBuffers surface() const { return {&positions_, &normals_, &triangles_}; }
  /// Empty values when there is none.
  const DistanceGrid& grid() const { return grid_; }
  const Buffer<float>& gridValues() const { return grid_values_; }

 private:
  DrawnMesh(Gpu& gpu, const TriangleMesh& mesh, const std::vector<Vec3>& normals);

  Buffer<vec3> positions_, normals_;
  Buffer<std::uint32_t> triangles_;
  DistanceGrid grid_;
  Buffer<float> grid_values_;
};

/// How fine clay is drawn, whatever its own levels.
struct DisplayDetail {
  int finer_points = 12'000;     ///< up to two steps finer, while there are at most so many points
  int coarser_points = 1 << 30;  ///< with more than these it is coarser, by as many steps as there are
};

/// The clay as it is drawn: subdivided further than its data points, so that no facet shows.
class DisplaySurface {
 public:
  DisplaySurface(Gpu& gpu, const PolygonMesh& cage, SubdivisionRule rule, int levels,
                 const DisplayDetail& detail = {});

  /// Records the surface of control points in the workspace's frame, as engine/clay/clay.h has them.
  void record(Recorder& recorder, const Buffer<vec3>& control_points) {
    evaluator_.record(recorder, control_points);
  }
  /// The same with a submission of its own, for control points in the world.
  void evaluate(const std::vector<Vec3>& control_points, const Workspace& workspace);

  SurfaceBuffers surface() const {
    return {&evaluator_.dataPoints(), &evaluator_.normals(), &evaluator_.triangles()};
  }

 private:
  Gpu& gpu_;
  SurfaceEvaluator evaluator_;
};

/// A colour given as on a screen (sRGB, 0 to 255), in linear light.
vec3 fromScreen(int red, int green, int blue);

/// Plasticine: a warm terracotta grey.
vec3 clayColor();
vec3 skinColor();

/// Something solid, the clay above all.
struct SceneMesh {
  SurfaceBuffers surface;
  Pose workspace_from_mesh = Pose::Identity();
  vec3 albedo = clayColor();
  bool open = true;         ///< an open sheet: lit on both sides
  bool shows_touch = true;  ///< warm where the hand's skin is within 3 mm, or the hand inside
};

struct SceneHand {
  const DrawnMesh* skin = nullptr;
  Pose workspace_from_hand = Pose::Identity();
  const DrawnMesh* forearm = nullptr;  ///< optional, in the hand's frame
  double opacity = 0.42;               ///< looked at straight on; 1 is solid
  vec3 albedo = skinColor();
};

/// Lines, two points each, or dots. Either from device memory or from here.
struct SceneStrokes {
  const Buffer<vec3>* points = nullptr;
  const Buffer<std::uint32_t>* indices = nullptr;  ///< two a line, one a dot; none: all points in order
  std::vector<Vec3> own_points;                    ///< when `points` is not given
  Pose workspace_from_strokes = Pose::Identity();
  vec3 color = vec3(0.02f, 0.02f, 0.025f);
  double width_px = 2;  ///< at an image 720 pixels high; the dots' diameter
  double hidden = 0;    ///< how much of it shows through what is before it
  bool dots = false;
};

/// The cube's twelve edges.
SceneStrokes cubeEdges(const Workspace& workspace);
/// Where a plane of symmetry, through the origin across `axis`, meets a ball about it.
SceneStrokes mirrorRing(int axis, double radius_m);
/// The rig's cameras as pyramids with the given length.
SceneStrokes cameraFrusta(const Rig& rig, double length_m);
/// The ends of a polygon mesh's edges, two an edge, each edge once.
std::vector<std::uint32_t> edgeEnds(const std::vector<std::vector<int>>& faces);
/// The edges of a polygon mesh in the world.
SceneStrokes meshEdges(const PolygonMesh& mesh, const Workspace& workspace);

/// A ball pulled along a link. Radius 0 at b is a cone.
struct SceneCapsule {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double radius_a_m = 0.003, radius_b_m = 0.003;
  vec3 albedo = vec3(0.7f, 0.66f, 0.58f);
};

/// The skeleton in its rest pose: links and joint balls.
std::vector<SceneCapsule> skeletonCapsules(const HandModel& hand, const Pose& workspace_from_hand);

/// What is in an image. What is pointed to must live until the recorded work is done.
struct Scene {
  Workspace workspace;
  std::vector<SceneMesh> meshes;
  std::optional<SceneHand> hand;
  const Carver* voxels = nullptr;
  vec3 voxel_albedo = vec3(0.20f, 0.33f, 0.42f);
  std::vector<SceneStrokes> strokes;
  std::vector<SceneCapsule> capsules;
  std::optional<double> ground_z_m;  ///< height of the ground; none: no ground
  vec3 backdrop_top = fromScreen(236, 233, 228), backdrop_bottom = fromScreen(206, 201, 195);
};

// -------------------------------------------------------------------------------------------------------
// renderer

struct RendererOptions {
  int width = 1280, height = 720;  ///< pixels, at most kMaxImage
  bool multisample = true;         ///< 4 samples a pixel: smooth edges
  int shadow_map = 1024;           ///< texels along an edge
  int shadow_taps = 64;            ///< of the soft shadow's kernel
  int ground_vertices = 64;        ///< along an edge: the ground's light is found at these
  bool readback = true;            ///< pixels() is wanted; else a window copies image()
  /// An image is divided where about so many triangles have been drawn, so that none of its submissions is
  /// long; 0: it is one submission.
  std::uint32_t triangles_a_piece = 0;

  static constexpr int kMaxImage = 4096;

  /// What a software device can keep up with.
  static RendererOptions live(int width, int height) {
    return {.width = width,
            .height = height,
            .multisample = false,
            .shadow_map = 512,
            .shadow_taps = 16,
            .triangles_a_piece = 30'000};
  }
};

class Renderer {
 public:
  /// \throw Error when the size is out of bounds.
  Renderer(Gpu& gpu, const RendererOptions& options);
  ~Renderer();

  /// Records the image of a scene; pixels() shows it when the recorded work is done. One image a
  /// submission; a large one may divide it. \pre what was recorded before is done
  void record(Recorder& recorder, const Scene& scene, const View& view);

  int width() const { return options_.width; }
  int height() const { return options_.height; }
  /// The image itself, as large as the options say; ImageKind::kScreen when it is not to be read back.
  Image& image() { return options_.multisample ? resolved_ : color_; }
  /// RGBA, a word a pixel, red in the lowest byte, sRGB, rows from the top. \pre the recorded work is done
  std::span<const std::uint32_t> pixels() const { return pixels_.host(); }
  /// The same as bytes.
  std::span<const std::uint8_t> bytes() const;
  /// How many voxels the last image drew. \pre the recorded work is done
  std::uint32_t drawnVoxels() const;

 private:
  struct Pipelines;
  struct LitMesh;
  struct Voxels;

  /// Where eye and key light stand; all in the workspace's frame.
  struct Aim {
    Eigen::Matrix4d clip_from_workspace, light_from_workspace;
    Vec3 eye, key_direction;                       ///< the direction is towards the light
    double light_radius_m = 0, light_depth_m = 0;  ///< of the ball that the shadow map holds; of its depth
  };

  void prepare(const Scene& scene);
  void aim(const Scene& scene, const View& view);
  void writeFrame(const Scene& scene);
  void writeStrokes(const Scene& scene);
  void recordVoxelList(Recorder& recorder, const Scene& scene);
  void recordDensities(Recorder& recorder, const Scene& scene);
  void recordShadowMap(Recorder& recorder, const Scene& scene);
  void recordLights(Recorder& recorder, const Scene& scene);
  void recordBackdrop(Recorder& recorder, const Scene& scene);
  void recordFrame(Recorder& recorder, const Scene& scene);
  std::uint32_t room() const;
  void spend(Recorder& recorder, std::uint32_t count);
  void endPart(Recorder& recorder);
  void drawInPieces(Recorder& recorder, RenderPass pass, const std::vector<Draw>& draws);
  RenderMeshArgs meshArgs(const LitMesh& mesh, bool from_light) const;
  RenderCapsuleArgs capsuleArgs(bool from_light) const;
  RenderVoxelArgs voxelArgs(const Scene& scene, bool from_light) const;
  RenderBackdropArgs backdropArgs(const Scene& scene) const;
  void addStrokes(std::vector<Draw>& draws, const Scene& scene, bool hidden) const;

  Gpu& gpu_;
  RendererOptions options_;
  Aim aim_;
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
  std::uint32_t spent_triangles_ = 0;  ///< since the image was begun or divided
  std::vector<LitMesh> lit_meshes_;    ///< of the image being recorded: the hand's parts last
  Buffer<std::uint32_t> pixels_;
};

}  // namespace airclay
