// SPDX-License-Identifier: MIT
// Which images of several cameras make a frame, by the times at which they were taken. Cameras may differ in
// rate, miss frames and start at different times.
#pragma once

#include <cstdint>
#include <vector>

namespace airclay {

/// The images of one instant.
struct ImageSet {
  /// Index of each camera's image. For a missing camera, its last image before.
  std::vector<int> images;
  std::vector<double> times_s;        ///< per camera, seconds; for a missing camera, the mean of the others
  std::uint32_t missing_cameras = 0;  ///< bit k: camera k has no image of this instant
};

/// Matches images by FrameMatcher, with half a frame of the fastest camera as the allowed skew. The first and
/// the last set are complete; between them at least two cameras have an image. Empty if there is no complete
/// set. \param camera_times_s  when each camera took its images, seconds on one clock, strictly increasing
std::vector<ImageSet> matchImages(const std::vector<std::vector<double>>& camera_times_s);

/// Whether image k of all cameras was taken at the same time, within a quarter of a frame, for every k that
/// all cameras have, at one constant rate: then images can be matched by their numbers.
bool matchesByNumber(const std::vector<std::vector<double>>& camera_times_s);

}  // namespace airclay
