// SPDX-License-Identifier: MIT
// Pictures for the eyes: the one place where the commands meet the renderer.
#pragma once

#include <filesystem>
#include <optional>

#include "capture/images/image_file.h"
#include "engine/pipeline.h"
#include "engine/render/renderer.h"

namespace airclay {

/// RGBA bytes, rows from the top.
struct Picture {
  PictureSize size;
  std::vector<std::uint8_t> rgba;
};

void save(const std::filesystem::path& file, const Picture& picture);

/// Draws scenes one at a time.
class Painter {
 public:
  Painter(Gpu& gpu, PictureSize size);
  Picture paint(const Scene& scene, const View& view);

 private:
  Renderer renderer_;
  Recorder recorder_;
};

/// A hand's skin on the device, and for a built-in hand the forearm that goes on behind it.
class DrawnHand {
 public:
  DrawnHand(Gpu& gpu, const HandModel& hand, const std::optional<TriangleMesh>& forearm);
  SceneHand at(const Pose& workspace_from_hand) const;
  /// Distances to the skin, in the hand's frame.
  const DistanceGrid& grid() const { return skin_.grid(); }

 private:
  DrawnMesh skin_;
  std::optional<DrawnMesh> forearm_;
};

/// What a sculpting looks like: its clay on a ground, the hand where it was found.
class SculptPictures {
 public:
  static constexpr PictureSize kSize = {960, 540};

  /// `pipeline` must outlive this, and was made with `clay`.
  SculptPictures(Gpu& gpu, const Pipeline& pipeline, const ClayState& clay,
                 const std::optional<TriangleMesh>& forearm);
  /// The clay as it is now, the hand where there is one.
  Picture frame(const std::optional<Pose>& world_from_hand);
  /// The rig around it: cameras, cube, voxels, cage and data points too.
  Picture workings(const std::optional<Pose>& world_from_hand);

 private:
  Scene scene(const std::optional<Pose>& world_from_hand);

  const Pipeline& pipeline_;
  Painter painter_;
  DrawnHand hand_;
  Gpu& gpu_;
  SubdivisionRule rule_;
  std::unique_ptr<DisplaySurface> surface_;  ///< of the form that the clay had in the last picture
  std::size_t control_points_ = 0;
  int levels_ = 0;
  double ground_z_m_ = 0;  ///< workspace frame: the clay's lowest point at the start
};

}  // namespace airclay
