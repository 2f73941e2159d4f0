// SPDX-License-Identifier: MIT
// Builds the matrix A of eq. (5) on OpenSubdiv's refined topology: with OpenSubdiv's stencils for
// `catmull-clark`, and for `printed` as a product of one matrix per level, with the weights of eq. (3) and
// (4) as printed in the paper.
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "engine/clay/subdivide.h"
#include "engine/core/error.h"
#include "engine/core/task.h"
#include "engine/mesh/manifold.h"

namespace airclay {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// A matrix of 4.8 GB; more results only from polygons with thousands of corners, whose points all depend on
// each other.
constexpr long kMaxWeights = 400'000'000;

constexpr int kMaxLevels = 15;  // OpenSubdiv stores the level in four bits

/// The number of data points after `levels` steps: V' = V + E + F, F' = corners, E' = 2E + corners. Stops
/// counting above kMaxDataPoints.
long countDataPoints(const PolygonMesh& cage, int levels) {
  long corners = 0;
  std::vector<std::pair<int, int>> sides;
  for (const std::vector<int>& face : cage.faces)
    for (size_t k = 0; k < face.size(); ++k)
      sides.push_back(std::minmax(face[k], face[(k + 1) % face.size()]));
  corners = long(sides.size());
  std::sort(sides.begin(), sides.end());
  long edges = std::unique(sides.begin(), sides.end()) - sides.begin();
  long points = long(cage.points.size());
  long faces = long(cage.faces.size());
  for (int level = 0; level < levels && points <= kMaxDataPoints; ++level) {
    points += edges + faces;
    edges = 2 * edges + corners;
    faces = corners;
    corners = 4 * faces;
  }
  return points;
}

/// An upper bound of the number of weights in A: a face of s corners becomes s 4^(levels - 1) quads, whose
/// points depend only on the control points of the faces that touch it. Stops counting above kMaxWeights.
double boundWeights(const PolygonMesh& cage, int levels) {
  std::vector<std::vector<int>> faces_of_point(cage.points.size());
  for (size_t f = 0; f < cage.faces.size(); ++f)
    for (const int corner : cage.faces[f]) faces_of_point[size_t(corner)].push_back(int(f));
  std::vector<int> last_seen_by(cage.points.size(), -1);
  double weights = 0;
  for (size_t f = 0; f < cage.faces.size() && weights <= double(kMaxWeights); ++f) {
    double support = 0;
    for (const int corner : cage.faces[f])
      for (const int neighbour : faces_of_point[size_t(corner)])
        for (const int point : cage.faces[size_t(neighbour)])
          if (std::exchange(last_seen_by[size_t(point)], int(f)) != int(f)) ++support;
    weights += support * double(cage.faces[f].size()) * std::pow(4.0, levels - 1);
  }
  return weights;
}

void checkSize(const PolygonMesh& cage, int levels) {
  if (levels < 1 || levels > kMaxLevels)
    throw Error("subdivision level " + std::to_string(levels) + " must be 1 to " +
                std::to_string(kMaxLevels));
  if (countDataPoints(cage, levels) > kMaxDataPoints)
    throw Error("subdivision level " + std::to_string(levels) + " of a cage of " +
                std::to_string(cage.points.size()) + " points results in more than " +
                std::to_string(kMaxDataPoints) + " data points; use a lower level");
  if (boundWeights(cage, levels) > double(kMaxWeights))
    throw Error("subdivision level " + std::to_string(levels) + " of this cage results in more than " +
                std::to_string(kMaxWeights) + " weights; use a lower level or split its largest polygons");
}

/// Refines the cage's connectivity uniformly; at each level face points come first, then edge points, then
/// vertex points.
std::unique_ptr<Far::TopologyRefiner> refine(const PolygonMesh& cage, int levels) {
  std::vector<int> sizes, corners;
  for (const std::vector<int>& face : cage.faces) {
    sizes.push_back(int(face.size()));
    corners.insert(corners.end(), face.begin(), face.end());
  }
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = int(cage.points.size());
  descriptor.numFaces = int(cage.faces.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = corners.data();

  Sdc::Options rules;
  rules.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  // OpenSubdiv prints errors by default; the exception below replaces them.
  Far::SetErrorCallback([](Far::ErrorType, const char*) {});
  Far::SetWarningCallback([](const char*) {});
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK, rules)));
  if (!refiner) throw Error("OpenSubdiv rejects the cage's connectivity; expected a manifold polygon mesh");
  Far::TopologyRefiner::UniformOptions options(levels);
  options.orderVerticesFromFacesFirst = true;
  refiner->RefineUniform(options);
  return refiner;
}

/// OpenSubdiv's stencils of the last level in terms of the control points.
StencilMatrix catmullClarkMatrix(const Far::TopologyRefiner& refiner) {
  using Factory = Far::StencilTableFactoryReal<double>;
  Factory::Options options;
  options.generateIntermediateLevels = false;
  options.factorizeIntermediateLevels = true;
  options.maxLevel = unsigned(refiner.GetMaxLevel()) & 0xf;
  const std::unique_ptr<const Far::StencilTableReal<double>> table(Factory::Create(refiner, options));

  StencilMatrix matrix(table->GetNumStencils(), table->GetNumControlVertices());
  matrix.reserve(Eigen::Index(table->GetWeights().size()));
  const int* columns = table->GetControlIndices().data();
  const double* weights = table->GetWeights().data();
  std::vector<std::pair<int, double>> row;
  for (int r = 0; r < table->GetNumStencils(); ++r) {
    reportProgress(size_t(r), size_t(table->GetNumStencils()));
    const int size = table->GetSizes()[size_t(r)];
    row.clear();
    for (int k = 0; k < size; ++k) row.emplace_back(columns[k], weights[k]);
    std::sort(row.begin(), row.end());
    matrix.startVec(r);
    for (const auto& [column, weight] : row) matrix.insertBack(r, column) = weight;
    columns += size;
    weights += size;
  }
  matrix.finalize();
  return matrix;
}

/// Builds the matrix of one subdivision step, from a level's points to those of the next.
class PrintedStep {
 public:
  explicit PrintedStep(const Far::TopologyLevel& level) : level_(level) {
    for (int f = 0; f < level.GetNumFaces(); ++f) facePoint(f);
    for (int e = 0; e < level.GetNumEdges(); ++e) edgePoint(e);
    for (int v = 0; v < level.GetNumVertices(); ++v) vertexPoint(v);
  }

  StencilMatrix matrix() const {
    StencilMatrix step(level_.GetNumFaces() + level_.GetNumEdges() + level_.GetNumVertices(),
                       level_.GetNumVertices());
    step.setFromTriplets(weights_.begin(), weights_.end());  // sums duplicate entries
    return step;
  }

 private:
  void add(int row, int point, double weight) { weights_.emplace_back(row, point, weight); }

  void addCentroid(int row, int face, double weight) {
    const Far::ConstIndexArray corners = level_.GetFaceVertices(face);
    for (int k = 0; k < corners.size(); ++k) add(row, corners[k], weight / corners.size());
  }

  void addMidpoint(int row, int edge, double weight) {
    const Far::ConstIndexArray ends = level_.GetEdgeVertices(edge);
    add(row, ends[0], weight / 2);
    add(row, ends[1], weight / 2);
  }

  void facePoint(int f) { addCentroid(level_.GetFaceChildVertex(f), f, 1); }

  void edgePoint(int e) {
    const int row = level_.GetEdgeChildVertex(e);
    if (level_.IsEdgeBoundary(e)) return addMidpoint(row, e, 1);
    const Far::ConstIndexArray faces = level_.GetEdgeFaces(e);
    addMidpoint(row, e, 0.5);  // (3) edge point, (a + m) / 2
    for (int k = 0; k < faces.size(); ++k) addCentroid(row, faces[k], 0.5 / faces.size());
  }

  void vertexPoint(int v) {
    const int row = level_.GetVertexChildVertex(v);
    const Far::ConstIndexArray edges = level_.GetVertexEdges(v);
    if (level_.IsVertexBoundary(v)) {
      // The standard border rule, 1/8, 3/4, 1/8: half the point plus a quarter of each border edge's
      // midpoint.
      add(row, v, 0.5);
      for (int k = 0; k < edges.size(); ++k)
        if (level_.IsEdgeBoundary(edges[k])) addMidpoint(row, edges[k], 0.25);
      return;
    }
    const Far::ConstIndexArray faces = level_.GetVertexFaces(v);
    add(row, v, 1.0 / 6);  // (4) vertex point, as printed: (a + 4m + p) / 6
    for (int k = 0; k < edges.size(); ++k) addMidpoint(row, edges[k], 4.0 / 6 / edges.size());
    for (int k = 0; k < faces.size(); ++k) addCentroid(row, faces[k], 1.0 / 6 / faces.size());
  }

  const Far::TopologyLevel& level_;
  std::vector<Eigen::Triplet<double>> weights_;
};

StencilMatrix printedMatrix(const Far::TopologyRefiner& refiner) {
  StencilMatrix matrix = PrintedStep(refiner.GetLevel(0)).matrix();
  for (int level = 1; level < refiner.GetMaxLevel(); ++level) {
    reportProgress(double(level) / refiner.GetMaxLevel());
    matrix = StencilMatrix(PrintedStep(refiner.GetLevel(level)).matrix() * matrix);
  }
  return matrix;
}

std::vector<std::array<int, 4>> lastQuads(const Far::TopologyRefiner& refiner) {
  const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
  std::vector<std::array<int, 4>> quads(size_t(level.GetNumFaces()));
  for (int f = 0; f < level.GetNumFaces(); ++f) {
    const Far::ConstIndexArray corners = level.GetFaceVertices(f);
    quads[size_t(f)] = {corners[0], corners[1], corners[2], corners[3]};
  }
  return quads;
}

}  // namespace

Subdivision subdivide(const PolygonMesh& cage, int levels, SubdivisionRule rule) {
  checkCage(cage, "control cage");
  checkSize(cage, levels);
  reportProgress(0.0);  // OpenSubdiv reports no progress
  const std::unique_ptr<Far::TopologyRefiner> refiner = refine(cage, levels);
  return {rule == SubdivisionRule::kCatmullClark ? catmullClarkMatrix(*refiner) : printedMatrix(*refiner),
          lastQuads(*refiner)};
}

PolygonMesh surfaceMesh(const Subdivision& subdivision, const std::vector<Vec3>& control_points) {
  PolygonMesh surface;
  surface.points = dataPoints(subdivision.matrix, control_points);
  surface.faces.reserve(subdivision.quads.size());
  for (const std::array<int, 4>& quad : subdivision.quads)
    surface.faces.emplace_back(quad.begin(), quad.end());
  return surface;
}

PolygonMesh meshAtLevel(const PolygonMesh& cage, int levels, SubdivisionRule rule) {
  return levels == 0 ? cage : surfaceMesh(subdivide(cage, levels, rule), cage.points);
}

}  // namespace airclay
