// SPDX-License-Identifier: MIT
// Synthetic cameras: images of a hand in a studio as a rig's cameras would record them, with lens distortion
// and noise.
#pragma once

#include <map>
#include <optional>

#include "engine/camera/gpu_rig.h"
#include "engine/gpu/graphics.h"
#include "engine/mesh/mesh.h"
#include "shaders/synthetic/sensor_io.h"

namespace airclay {

/// Per-frame settings. Equal settings give identical bytes.
struct SensorFrame {
  std::uint32_t seed = 1, frame = 0;  ///< seeds of the noise
  double noise_sigma = 2.5;           ///< standard deviation on a scale of 255: an ordinary camera indoors
  double brightness = 1;              ///< factor for the whole image: 1.02 is 2 % brighter
};

/// Draws rigid meshes (a hand's skin, a forearm) in front of a cloth backdrop, for every camera of a rig.
class Sensor {
 public:
  /// `meshes` are in the hand frame, metres, and move together. Distortion is applied per vertex, so
  /// triangles should be small (1 cm is). `rig` must outlive this. \throw Error if there are no triangles.
  Sensor(Gpu& gpu, const GpuRig& rig, const std::vector<TriangleMesh>& meshes);

  /// Records a camera's image; without a pose the workspace is empty. Record camera 0 first: it computes the
  /// shadow for all cameras.
  void record(Recorder& recorder, std::size_t camera, const std::optional<Pose>& world_from_hand,
              const SensorFrame& frame);
  /// Draws all cameras' images, one submission each, so that other threads' submissions can run in between.
  void draw(Recorder& recorder, const std::optional<Pose>& world_from_hand, const SensorFrame& frame);

  /// The images, BGR, in GpuRig's layout, in host-visible memory.
  const Buffer<std::uint32_t>& images() const { return images_; }
  /// One camera's image, BGR, 3 bytes per pixel, rows from the top. \pre the recorded work is done
  std::span<const std::uint8_t> image(std::size_t camera) const;
  /// The fraction of each pixel that the hand covers, 0 to 1, row by row. \pre the recorded work is done, and
  /// had a pose
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
  std::map<std::pair<std::uint32_t, std::uint32_t>, Canvas> canvases_;  ///< by image size
  Buffer<vec3> positions_, spots_;
  Buffer<vec4> normals_;
  Buffer<std::uint32_t> indices_;
  Buffer<std::uint32_t> backdrop_;  ///< two words per pixel
  Buffer<float> shadow_;
  Buffer<std::uint64_t> noise_;
  Buffer<std::uint32_t> hand_;  ///< RGBA of all cameras, one word per pixel
  Buffer<std::uint32_t> images_;
  double floor_z_ = 0, wall_radius_ = 0;  ///< metres, workspace frame
};

/// The ambient visibility of each vertex, 0 (occluded) to 1, with every vertex as a disc (Bunnell 2005,
/// "Dynamic Ambient Occlusion and Indirect Lighting", GPU Gems 2, chapter 14). `normals`: unit, one per
/// vertex.
std::vector<double> openness(const TriangleMesh& mesh, const std::vector<Vec3>& normals);

}  // namespace airclay
