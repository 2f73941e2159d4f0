// SPDX-License-Identifier: MIT
// Remeshing: a new control cage of even quads whose subdivided surface lies on a given surface. Overlapping
// lobes fuse.
#pragma once

#include <string>

#include "engine/clay/clay_state.h"

namespace airclay {

struct RemeshOptions {
  double edge_m = 0;     ///< the square root of the mean area of the new cage's faces; 0: from `faces`
  int faces = 1600;      ///< if edge_m is 0: about as many, within a few percent
  double thicken_m = 0;  ///< an open surface becomes a wall of this thickness first; 0: it is refused
  SubdivisionRule rule = SubdivisionRule::kCatmullClark;  ///< that the new cage will be subdivided by
};

inline constexpr int kMinRemeshFaces = 50, kMaxRemeshFaces = 100'000;

struct Remeshing {
  PolygonMesh cage;  ///< quads; a closed, orientable 2-manifold, outwards; in the surface's frame
  double edge_m = 0;
  /// The largest distance between the solid's surface and the cage's at level 2, sampled in both directions
  /// at a quarter of an edge or denser.
  double hausdorff_m = 0;
  double input_volume_m3 = 0;  ///< of the solid: the union of overlapping lobes
  double volume_m3 = 0;        ///< of the cage's surface at level 2
  int lost_parts = 0;          ///< separate parts that are too small for an edge

  double volumeChangePercent() const { return 100 * (volume_m3 / input_volume_m3 - 1); }
};

/// Remeshes the solid inside `surface`; where it overlaps itself, the solid is the union (winding number
/// above 0). Separate parts that do not overlap stay separate. The result does not depend on the number of
/// cores. Reports progress, and can be cancelled by it (engine/core/task.h).
///
/// 1. Dual contouring on a lattice gives a closed, manifold net of quads (engine/mesh/dual_contour.h).
/// 2. Its points spread evenly over the surface (engine/mesh/even_net.h).
/// 3. The control points move until the subdivided surface passes through the net's points: progressive
///    iterative approximation (Lin, Maekawa and Deng 2018, "Survey on geometric iterative methods and their
///    applications"). The remaining difference of volume is spread over the surface. Where sharp edges are
///    cut, the surface is pulled towards them.
///
/// \throw Error if an option is out of range or does not fit the surface, with a value that fits; if the
/// surface is open and thicken_m is 0, or closed and it is not; or if it encloses no volume.
Remeshing remesh(const TriangleMesh& surface, const RemeshOptions& options);

/// The surface of a cage at a level that is fine enough to be remeshed with `options`.
/// \throw Error like subdivide()
TriangleMesh fineSurface(const PolygonMesh& cage, SubdivisionRule rule, const RemeshOptions& options);

/// The clay with a new cage of about `faces` quads for the same solid. Rule, solve method and rotation stay;
/// the level drops to at most the one with about 10,000 data points. \throw Error like remesh(), or if there
/// would be more control points than the solve method supports
ClayState remesh(const ClayState& state, int faces);

/// The number of faces that the studio's remeshing makes: kStudioFaces, or as many as the cage has if it has
/// more.
int remeshFaces(const ClayState& state);

}  // namespace airclay
