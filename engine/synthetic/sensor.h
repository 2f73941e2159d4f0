// SPDX-License-Identifier: MIT
// Synthetic cameras: what a rig would see of a hand in a studio, through its own lenses, as bytes with noise.
#pragma once

#include <map>
#include <optional>

#include "engine/camera/gpu_rig.h"
#include "engine/gpu/graphics.h"
#include "engine/mesh/mesh.h"
#include "shaders/synthetic/sensor_io.h"

namespace airclay {

/// What differs from frame to frame. The same values give the same bytes.
struct SensorFrame {
  std::uint32_t seed = 1, frame = 0;  ///< of the noise
  double noise_sigma = 2.5;           ///< of 255: an ordinary camera indoors
  double brightness = 1;              ///< of the whole image: 1.02 is 2 % brighter
};

/// Draws rigid meshes (a hand's skin, its forearm) before a cloth backdrop, in every camera of a rig.
class Sensor {
 public:
  /// `meshes` are in the hand's frame and move together; triangles should be small beside the lens'
  /// curvature (a centimetre is). `rig` must outlive this. \throw Error when there is no triangle.
  Sensor(Gpu& gpu, const GpuRig& rig, const std::vector<TriangleMesh>& meshes);

  /// Records a camera's image; without a pose the workspace is empty. Camera 0 comes first: its part makes
  /// the shadow for all.
  void record(Recorder& recorder, std::size_t camera, const std::optional<Pose>& world_from_hand,
              const SensorFrame& frame);
  /// Draws all cameras' images, a submission each, so that a software device finds time for others'.
  void draw(Recorder& recorder, const std::optional<Pose>& world_from_hand, const SensorFrame& frame);

  /// The images, BGR, in GpuRig's layout, in memory that the host sees.
  const Buffer<std::uint32_t>& images() const { return images_; }
  /// One camera's, BGR, 3 bytes a pixel, rows from the top. \pre the recorded work is done
  std::span<const std::uint8_t> image(std::size_t camera) const;
  /// How much of each pixel the hand covers, 0 to 1, row by row. \pre the recorded work is done, with a pose
  std::vector<double> coverage(std::size_t camera) const;

 private:
  void bakeBackdrop();
  void uploadMeshes(const std::vector<TriangleMesh>& meshes);
  void recordHand(Recorder& recorder, std::size_t camera, const Pose& world_from_hand);
  void recordShadow(Recorder& recorder, const Pose& world_from_hand);
  Pose workspaceFromWorld() const;

  Gpu& gpu_;
  const GpuRig& rig_;
  GraphicsPipeline<SensorMeshArgs> mesh_pipeline_;
  Kernel<ShadowArgs> shadow_kernel_;
  Kernel<ComposeArgs> compose_hand_, compose_empty_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Canvas> canvases_;  ///< by the image's size
  Buffer<vec3> positions_, spots_;
  Buffer<vec4> normals_;
  Buffer<std::uint32_t> indices_;
  Buffer<std::uint32_t> backdrop_;  ///< two words a pixel
  Buffer<float> shadow_;
  Buffer<std::uint64_t> noise_;
  Buffer<std::uint32_t> hand_;  ///< RGBA of all cameras, one pixel a word
  Buffer<std::uint32_t> images_;
  double floor_z_ = 0, wall_radius_ = 0;  ///< metres, workspace frame
};

/// How open each vertex is to light from all around, 0 to 1, where the others are in the way (Bunnell 2005,
/// "Dynamic Ambient Occlusion and Indirect Lighting", GPU Gems 2, chapter 14: every vertex a disc).
std::vector<double> openness(const TriangleMesh& mesh, const std::vector<Vec3>& normals);

}  // namespace airclay
