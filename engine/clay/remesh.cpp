// SPDX-License-Identifier: MIT
#include "engine/clay/remesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/clay/remesh_fit.h"
#include "engine/core/error.h"
#include "engine/core/task.h"
#include "engine/mesh/even_net.h"
#include "engine/mesh/manifold.h"
#include "engine/mesh/mesh_export.h"
#include "engine/mesh/outer_surface.h"
#include "engine/mesh/thicken.h"

namespace airclay {
namespace {

constexpr int kStudioFaces = 1600;
constexpr std::size_t kStudioDataPoints = 12'000;
constexpr double kMaxLatticePoints = 64e6;  // one byte each
// Faces per squared spacing and area, for random directions, after collapseRhombi().
constexpr double kFacesPerSquare = 1.25;
constexpr double kMinEdgesPerWall = 2;  // thinner walls may fall between the lattice's points
// Edges: distances above the first are worth another step, which reduces those above the second.
constexpr double kCutEdges = 0.15, kTolerance = 0.08;
constexpr double kMaxVolumeChangePercent = 0.4;
constexpr double kStructureSpacing = 0.25, kVolumeSpacing = 0.125;  // of the net's spacing

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", 1000 * metres);
  return text;
}

double areaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm() / 2;
  return area;
}

double volumeOf(const TriangleMesh& mesh) {
  double volume = 0;
  const Vec3 origin = mesh.vertices.empty() ? Vec3(Vec3::Zero()) : mesh.vertices[0];
  for (const auto& [a, b, c] : mesh.triangles)
    volume +=
        (mesh.vertices[a] - origin).dot((mesh.vertices[b] - origin).cross(mesh.vertices[c] - origin)) / 6;
  return volume;
}

Eigen::AlignedBox3d boxOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles)
    for (const int corner : triangle) box.extend(mesh.vertices[corner]);
  return box;
}

/// The edge that the options ask for. \throw Error with one that fits if it does not
double edgeFor(const RemeshOptions& options, double area, const Eigen::AlignedBox3d& box) {
  if (options.edge_m == 0 && (options.faces < kMinRemeshFaces || options.faces > kMaxRemeshFaces))
    throw Error("remesh: " + std::to_string(options.faces) + " faces; expected " +
                std::to_string(kMinRemeshFaces) + " to " + std::to_string(kMaxRemeshFaces) + " (--faces)");
  const double edge = options.edge_m > 0 ? options.edge_m : std::sqrt(area / options.faces);
  const double shortest = std::max(std::sqrt(area / kMaxRemeshFaces),
                                   std::cbrt((box.sizes().array() + 5 * edge).prod() / kMaxLatticePoints));
  const double longest = std::sqrt(area / kMinRemeshFaces);
  const double side = box.sizes().maxCoeff() / (kMaxLatticeSide * kVolumeSpacing - 5);
  if (options.edge_m > 0 && (edge > longest || edge < std::max(shortest, side)))
    throw Error("remesh: an edge of " + millimetres(edge) + " mm gives about " +
                std::to_string(std::llround(area / edge / edge)) + " faces; expected --edge-mm from " +
                millimetres(1.01 * std::max(shortest, side)) + " to " + millimetres(0.99 * longest));
  if (edge < std::max(shortest, side)) {
    const double fits = std::max(shortest, side);
    throw Error("remesh: " + std::to_string(options.faces) +
                " faces are too fine for a surface of this shape; expected at most " +
                std::to_string(std::llround(0.95 * area / fits / fits)) + " (--faces)");
  }
  if (options.thicken_m > 0 && options.thicken_m < 0.999 * kMinEdgesPerWall * edge)
    throw Error("remesh: a wall of " + millimetres(options.thicken_m) + " mm needs edges of at most " +
                millimetres(options.thicken_m / kMinEdgesPerWall) + " mm, not " + millimetres(edge) +
                ": use --edge-mm " + millimetres(options.thicken_m / kMinEdgesPerWall) + " or --thicken " +
                millimetres(1.01 * kMinEdgesPerWall * edge));
  return edge;
}

/// The closed surface to remesh.
TriangleMesh solidOf(const TriangleMesh& surface, double thicken_m) {
  if (surface.triangles.empty()) throw Error("remesh: the surface has no faces");
  const std::size_t open = openEdges(surface);
  if (open > 0 && !(thicken_m > 0))
    throw Error("remesh: the surface is open at " + std::to_string(open) +
                " edges; close it, or make it a wall with --thicken MM");
  if (open == 0 && thicken_m > 0) throw Error("remesh: the surface is closed; --thicken is for open ones");
  TriangleMesh solid = thicken_m > 0 ? thickened(surface, thicken_m) : surface;
  if (openEdges(solid) > 0) throw Error("remesh: neighbouring faces of the surface disagree in orientation");
  return solid;
}

/// Parts that overlap, and their net and surface.
struct Group {
  TriangleMesh mesh;
  bool overlaps = false;
  QuadNet net;
};

std::vector<Group> groupsOf(const TriangleMesh& mesh, const SolidStructure& structure) {
  std::vector<Group> groups(std::size_t(structure.groups));
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    TriangleMesh& part = groups[std::size_t(structure.group_of_triangle[t])].mesh;
    std::array<int, 3> triangle = mesh.triangles[t];
    for (int& corner : triangle) {
      int& index = new_index[std::size_t(corner)];  // a vertex belongs to one part
      if (index < 0) {
        index = int(part.vertices.size());
        part.vertices.push_back(mesh.vertices[std::size_t(corner)]);
      }
      corner = index;
    }
    part.triangles.push_back(triangle);
  }
  for (std::size_t g = 0; g < groups.size(); ++g) groups[g].overlaps = structure.overlaps[g];
  return groups;
}

struct NetSize {
  std::size_t quads = 0;
  double area = 0;
};

NetSize contourAll(std::vector<Group>& groups, double spacing_m) {
  NetSize size;
  for (Group& group : groups) {
    group.net = dualContour(group.mesh, latticeAround(boxOf(group.mesh), spacing_m));
    collapseRhombi(group.net);
    size.quads += group.net.quads.size();
    for (const auto& quad : group.net.quads) size.area += areaVector(group.net, quad).norm();
  }
  return size;
}

/// Makes the groups' nets; returns their spacing. The number of faces is a function of the spacing with small
/// jumps: a few steps of a secant-like iteration get within a few percent.
double makeNets(std::vector<Group>& groups, const RemeshOptions& options, double edge) {
  constexpr int kTries = 5;
  constexpr double kCloseEnough = 0.01;
  double spacing = edge * std::sqrt(kFacesPerSquare), best_spacing = spacing, best_error = 1e300;
  double contoured = 0;  // the spacing of the groups' nets
  for (int attempt = 0; attempt < kTries && best_error > kCloseEnough; ++attempt) {
    const NetSize size = contourAll(groups, contoured = spacing);
    if (size.quads == 0) {
      spacing *= 0.7;
      continue;
    }
    const double wanted = options.edge_m > 0 ? size.area / (edge * edge) : double(options.faces);
    const double ratio = double(size.quads) / wanted, error = std::abs(std::log(ratio));
    if (error < best_error) best_error = error, best_spacing = spacing;
    if (error > kCloseEnough) spacing *= std::sqrt(ratio);
  }
  if (contoured != best_spacing) contourAll(groups, best_spacing);
  return best_spacing;
}

PolygonMesh joined(const std::vector<Group>& groups) {
  PolygonMesh all;
  for (const Group& group : groups) {
    const int first = int(all.points.size());
    all.points.insert(all.points.end(), group.net.points.begin(), group.net.points.end());
    for (const auto& [a, b, c, d] : group.net.quads)
      all.faces.push_back({first + a, first + b, first + c, first + d});
  }
  return all;
}

/// Sets the result's measures from its control points.
void measure(const Subdivision& subdivision, const std::vector<Triangle>& outer, Remeshing& result) {
  const PolygonMesh remeshed = surfaceMesh(subdivision, result.cage.points);
  const TriangleMesh triangles{remeshed.points, triangulated(remeshed)};
  result.volume_m3 = volumeOf(triangles);
  result.edge_m = std::sqrt(areaOf(triangles) / double(result.cage.faces.size()));
  result.hausdorff_m = hausdorffDistance(outer, triangles, result.edge_m / 4);
}

}  // namespace

Remeshing remesh(const TriangleMesh& surface, const RemeshOptions& options) {
  if (!(options.edge_m >= 0 && options.thicken_m >= 0))
    throw Error("remesh: --edge-mm and --thicken must be positive");
  const TriangleMesh solid = solidOf(surface, options.thicken_m);
  const Eigen::AlignedBox3d box = boxOf(solid);
  const double edge = edgeFor(options, areaOf(solid), box);
  const SolidStructure structure = solidStructure(solid, latticeAround(box, kStructureSpacing * edge));
  std::vector<Group> groups = groupsOf(solid, structure);
  reportProgress(0.2);
  const double spacing = makeNets(groups, options, edge);

  Remeshing result;
  std::vector<Triangle> outer;
  for (Group& group : groups) {
    const std::vector<Triangle> triangles =
        group.overlaps ? outerTriangles(group.mesh, spacing / 2) : cornersOf(group.mesh);
    outer.insert(outer.end(), triangles.begin(), triangles.end());
    if (group.net.quads.empty() || triangles.empty()) {
      ++result.lost_parts;
      group.net = {};
      continue;
    }
    spreadEvenly(group.net, TriangleTree(triangles), spacing / std::sqrt(kFacesPerSquare));
  }
  result.cage = joined(groups);
  const bool overlaps =
      std::any_of(groups.begin(), groups.end(), [](const Group& group) { return group.overlaps; });
  result.input_volume_m3 =
      overlaps ? solidStructure(solid, latticeAround(box, kVolumeSpacing * edge)).volume_m3 : volumeOf(solid);
  if (result.cage.faces.empty() || !(result.input_volume_m3 > 0))
    throw Error("remesh: the surface encloses no volume, or one that is thinner than an edge of " +
                millimetres(edge) + " mm; a smaller --edge-mm keeps thin parts");
  checkCage(result.cage, "remesh");
  const Subdivision subdivision = subdivide(result.cage, 2, options.rule);
  result.cage.points = controlPointsThrough(subdivision, result.cage.points, result.input_volume_m3, spacing);
  measure(subdivision, outer, result);
  if (result.hausdorff_m > kCutEdges * result.edge_m) {
    Remeshing closer = result;
    approachSamples(subdivision, outer, closer.edge_m / 4, kTolerance * closer.edge_m, result.input_volume_m3,
                    closer.cage.points);
    measure(subdivision, outer, closer);
    if (closer.hausdorff_m < result.hausdorff_m &&
        std::abs(closer.volumeChangePercent()) < kMaxVolumeChangePercent)
      result = closer;
  }
  return result;
}

TriangleMesh fineSurface(const PolygonMesh& cage, SubdivisionRule rule, const RemeshOptions& options) {
  constexpr double kTrianglesPerFace = 24;
  constexpr int kCoarsest = 2;
  double wanted = options.faces;
  if (options.edge_m > 0) {
    const PolygonMesh coarse = meshAtLevel(cage, kCoarsest, rule);
    wanted = areaOf({coarse.points, triangulated(coarse)}) / (options.edge_m * options.edge_m);
  }
  if (wanted > kMaxRemeshFaces) wanted = 0;  // remesh() will refuse it
  wanted *= kTrianglesPerFace;
  double triangles = 0;
  for (const std::vector<int>& face : cage.faces) triangles += 2 * double(face.size());
  int level = 1;
  for (; (level < kCoarsest || triangles < wanted) && 4 * triangles < double(kMaxDataPoints); ++level)
    triangles *= 4;
  const PolygonMesh fine = meshAtLevel(cage, level, rule);
  return {fine.points, triangulated(fine)};
}

ClayState remesh(const ClayState& state, int faces) {
  RemeshOptions options;
  options.faces = faces;
  options.rule = state.rule;
  ClayState remeshed = state;
  remeshed.cage = remesh(fineSurface(state.cage, state.rule, options), options).cage;
  const std::size_t limit = std::min(std::size_t(state.solve->max_control_points), kMaxStatePoints);
  if (remeshed.cage.points.size() > limit)
    throw Error("remeshing results in " + std::to_string(remeshed.cage.points.size()) +
                " control points; expected at most " + std::to_string(limit) +
                (state.solve->fits_unmoved ? " for this solve; the solve 'touched' supports more" : ""));
  std::size_t data_points = 4 * remeshed.cage.faces.size();
  remeshed.levels = 1;
  for (; remeshed.levels < state.levels && 4 * data_points <= kStudioDataPoints; ++remeshed.levels)
    data_points *= 4;
  return remeshed;
}

int remeshFaces(const ClayState& state) {
  return std::clamp(int(state.cage.faces.size()), kStudioFaces, kMaxRemeshFaces);
}

}  // namespace airclay
