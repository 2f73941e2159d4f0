// SPDX-License-Identifier: MIT
// Symmetry: the hand's effect on the clay is mirrored at planes through the workspace's centre, which rotate
// with the clay (engine/clay/clay.h).
//
// The hand has up to eight images, including itself. A data point touches an image of the hand if the point's
// mirror image touches the hand; so each tool tests a point's images against the one hand, and mirrors their
// displacements back. This requires nothing of the mesh. If images request different displacements of a
// point, it moves along each axis by the larger one if they agree in sign, and by the sum if they oppose each
// other: nothing is applied twice near a plane, a point on the plane stays on it, and the rule itself is
// symmetric, unlike the choice of one image.
//
// A symmetric cage stays symmetric: rounding differences, which contact decisions would amplify, are averaged
// over control points that are each other's images.
#pragma once

#include <optional>

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/mesh/mesh.h"
#include "shaders/sculpt/symmetry_io.h"

namespace airclay {

/// The axes that are mirrored: x mirrors at the plane x = 0, left to right.
struct Symmetry {
  bool x = false, y = false, z = false;
  bool operator==(const Symmetry&) const = default;
};

/// All images of the hand, packed as in symmetry_io.h: 2, 4 or 8 images for 1, 2 or 3 axes.
std::uint32_t mirrorsOf(const Symmetry& symmetry);
std::uint32_t imageCount(std::uint32_t mirrors);
/// The signs of x, y and z in an image.
Vec3 mirrorOf(std::uint32_t mirrors, std::uint32_t image);
/// The displacement of a point whose images request these displacements.
Vec3 combinedDisplacement(const std::vector<Vec3>& requests);

/// Sets of control points that are each other's images.
struct SymmetryOrbits {
  std::uint32_t mirrors = 0;
  std::vector<std::uint32_t> points;  ///< imageCount(mirrors) per orbit, in the order of the images
};

/// The largest distance between a control point and the mirror image of its partner: the rounding of a file
/// with five decimals of a metre.
inline constexpr double kSymmetryTolerance_m = 1e-5;

/// The orbits of a cage centred at the origin, over those axes of `symmetry` in which its points and faces
/// are symmetric; empty if there is no such axis.
SymmetryOrbits symmetryOrbits(const PolygonMesh& cage, const Symmetry& symmetry);

/// Makes the control points of each orbit exact images of one another: the reference implementation of
/// symmetry_average.
void averageOrbits(const SymmetryOrbits& orbits, std::vector<Vec3>& control_points);

/// The same on the GPU.
class SymmetryKeeper {
 public:
  explicit SymmetryKeeper(Gpu& gpu);
  /// \pre earlier recorded work is done
  void setOrbits(const SymmetryOrbits& orbits);
  const SymmetryOrbits& orbits() const { return orbits_; }
  /// Records averageOrbits() with workgroup counts from device memory; surplus workgroups do nothing.
  void recordIndirect(Recorder& recorder, const Buffer<double>& exact_points,
                      const Buffer<vec3>& control_points, const RawBuffer& groups, std::uint64_t byte_offset);

 private:
  Gpu& gpu_;
  Kernel<SymmetryAverageArgs> average_;
  SymmetryOrbits orbits_;
  Buffer<std::uint32_t> points_;
};

}  // namespace airclay
