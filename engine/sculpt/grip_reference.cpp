// SPDX-License-Identifier: MIT
// The reference implementation of grip_find: point by point, in double precision.
#include "engine/sculpt/grip.h"

namespace airclay {

std::uint32_t gripReference(const DistanceGrid& hand, const ContactPose& now, std::uint32_t mirrors,
                            const Vec3& data_point, double reach_m) {
  std::uint32_t images = 0;
  for (std::uint32_t image = 0; image < imageCount(mirrors); ++image) {
    const Vec3 mirrored = mirrorOf(mirrors, image).cwiseProduct(data_point);
    if (sample(hand, now.rotation.conjugate() * (mirrored - now.position)) <= reach_m) images |= 1u << image;
  }
  return images;
}

Vec3 gripTarget(const ContactPose& gripped, const ContactPose& now, std::uint32_t mirrors,
                std::uint32_t images, const Vec3& start) {
  std::vector<Vec3> requested;
  for (std::uint32_t image = 0; image < imageCount(mirrors); ++image) {
    if ((images >> image & 1) == 0) continue;
    const Vec3 mirror = mirrorOf(mirrors, image);
    const Vec3 in_hand = gripped.rotation.conjugate() * (mirror.cwiseProduct(start) - gripped.position);
    requested.push_back(mirror.cwiseProduct(now.rotation * in_hand + now.position) - start);
  }
  return start + combinedDisplacement(requested);
}

}  // namespace airclay
