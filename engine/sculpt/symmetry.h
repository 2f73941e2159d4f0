// SPDX-License-Identifier: MIT
// Symmetry: whatever the hand does to the clay is done mirrored too, about the planes through the workspace's
// centre that are the clay's own: they turn with it (engine/clay/clay.h).
//
// The hand has up to eight images, itself among them. A data point meets an image of the hand where the
// point's own mirror image meets the hand; so each tool looks at a point's images with the one hand, and
// mirrors back what they are to do. That asks nothing of the mesh. When images want different things of a
// point, it does, along each axis, the larger one where they agree and the sum where they pull against each
// other: nothing is done twice near a plane, a point on it stays on it, and the rule itself is symmetric,
// which choosing one image would not be.
//
// A cage that is symmetric stays so: rounding, which contact's decisions would magnify, is averaged away over
// the control points that are each other's images.
#pragma once

#include <optional>

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/mesh/mesh.h"
#include "shaders/sculpt/symmetry_io.h"

namespace airclay {

/// The axes whose sign is turned: x mirrors about the plane x = 0, right to left.
struct Symmetry {
  bool x = false, y = false, z = false;
  bool operator==(const Symmetry&) const = default;
};

/// All images of the hand, packed as symmetry_io.h says: 2, 4 or 8 of them with 1, 2 or 3 axes.
std::uint32_t mirrorsOf(const Symmetry& symmetry);
std::uint32_t imageCount(std::uint32_t mirrors);
/// The signs of x, y and z in image `image`.
Vec3 mirrorOf(std::uint32_t mirrors, std::uint32_t image);
/// What a point does when its images want these displacements.
Vec3 agreedDisplacement(const std::vector<Vec3>& wanted);

/// The control points that are each other's images.
struct SymmetryOrbits {
  std::uint32_t mirrors = 0;
  std::vector<std::uint32_t> points;  ///< imageCount(mirrors) an orbit, in the images' order
};

/// How far a control point may lie from its image: what a file with five decimals of a metre rounds to.
inline constexpr double kSymmetryTolerance_m = 1e-5;

/// Of a cage about the origin, over those axes of `symmetry` in which it is symmetric, points and faces;
/// without any axis left, none.
SymmetryOrbits symmetryOrbits(const PolygonMesh& cage, const Symmetry& symmetry);

/// Makes the control points of each orbit exact images of one another: the twin of symmetry_average.
void averageOrbits(const SymmetryOrbits& orbits, std::vector<Vec3>& control_points);

/// The same on the GPU.
class SymmetryKeeper {
 public:
  explicit SymmetryKeeper(Gpu& gpu);
  /// \pre nothing recorded before is still running
  void setOrbits(const SymmetryOrbits& orbits);
  const SymmetryOrbits& orbits() const { return orbits_; }
  /// Records it for as many workgroups as stand on the device; those beyond the orbits do nothing.
  void recordIndirect(Recorder& recorder, const Buffer<double>& exact_points,
                      const Buffer<vec3>& control_points, const RawBuffer& groups, std::uint64_t byte_offset);

 private:
  Gpu& gpu_;
  Kernel<SymmetryAverageArgs> average_;
  SymmetryOrbits orbits_;
  Buffer<std::uint32_t> points_;
};

}  // namespace airclay
