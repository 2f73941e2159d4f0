// SPDX-License-Identifier: MIT
// Rendered images: the only place where commands use the renderer.
#pragma once

#include <filesystem>
#include <optional>

#include "capture/images/image_file.h"
#include "engine/pipeline.h"
#include "engine/render/renderer.h"

namespace airclay {

/// RGBA bytes, rows from the top.
struct RgbaImage {
  ImageSize size;
  std::vector<std::uint8_t> rgba;
};

void save(const std::filesystem::path& file, const RgbaImage& image);

/// Draws scenes one at a time.
class OffscreenRenderer {
 public:
  OffscreenRenderer(Gpu& gpu, ImageSize size);
  RgbaImage paint(const Scene& scene, const View& view);

 private:
  Renderer renderer_;
  Recorder recorder_;
};

/// A hand's skin on the device, with the forearm of a built-in hand.
class DrawnHand {
 public:
  DrawnHand(Gpu& gpu, const HandModel& hand, const std::optional<TriangleMesh>& forearm);
  SceneHand at(const Pose& workspace_from_hand) const;
  /// Distances to the skin, in the hand's frame.
  const DistanceGrid& grid() const { return skin_.grid(); }

 private:
  RenderMesh skin_;
  std::optional<RenderMesh> forearm_;
};

/// Renders the clay on a ground, with the tracked hand.
class SculptRenderer {
 public:
  static constexpr ImageSize kSize = {960, 540};

  /// `pipeline` must outlive this and contain `clay`.
  SculptRenderer(Gpu& gpu, Pipeline& pipeline, const ClayState& clay,
                 const std::optional<TriangleMesh>& forearm);
  /// The current clay and the first of `hands`.
  RgbaImage frame(std::span<const HandPose> hands);
  /// Also shows cameras, workspace, voxels, cage and data points.
  RgbaImage workings(std::span<const HandPose> hands);

 private:
  Scene scene(std::span<const HandPose> hands);

  Pipeline& pipeline_;
  OffscreenRenderer painter_;
  DrawnHand hand_;
  Gpu& gpu_;
  SubdivisionRule rule_;
  std::unique_ptr<DisplaySurface> surface_;  ///< for the clay structure of the last image
  std::size_t control_points_ = 0;
  int levels_ = 0;
  double ground_z_m_ = 0;  ///< workspace frame: the clay's lowest point at the start
};

}  // namespace airclay
