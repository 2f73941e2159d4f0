// SPDX-License-Identifier: MIT
#include "tests/support/hand_scene.h"

#include "tests/support/gpu_fixture.h"

namespace airclay {

HandCameras::HandCameras(const Rig& rig, const std::vector<TriangleMesh>& meshes)
    : rig_(testGpu(), rig), sensor_(testGpu(), rig_, meshes), recorder_(testGpu()) {}

std::vector<Silhouette> HandCameras::masks(const Pose& world_from_hand) {
  sensor_.draw(recorder_, world_from_hand, {});
  std::vector<Silhouette> masks;
  for (std::size_t c = 0; c < rig_.cameraCount(); ++c) {
    const Camera& camera = rig_.rig().cameras[c];
    Silhouette mask{camera.width, camera.height, {}};
    for (const double covered : sensor_.coverage(c)) mask.pixels.push_back(covered >= 0.5 ? 255 : 0);
    masks.push_back(std::move(mask));
  }
  return masks;
}

Rig turned(const Rig& rig, const Eigen::Quaterniond& turn) {
  Rig result = rig;
  for (Camera& camera : result.cameras)
    camera.camera_from_world = camera.camera_from_world * turn.conjugate();
  return result;
}

PoseError poseError(const Pose& found, const Pose& truth, const Vec3& center_of_mass_in_hand) {
  return {(found * center_of_mass_in_hand - truth * center_of_mass_in_hand).norm(),
          angleBetween(found.linear(), truth.linear()) * 180 / M_PI};
}

}  // namespace airclay
