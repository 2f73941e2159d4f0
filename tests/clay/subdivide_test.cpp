// SPDX-License-Identifier: MIT
// Eq. (3)-(5): closed forms for both rules, a naive subdivision of positions, and OpenSubdiv's own evaluator.
#include "engine/clay/subdivide.h"

#include <gtest/gtest.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/mesh/manifold.h"

namespace airclay {
namespace {

constexpr SubdivisionRule kRules[] = {SubdivisionRule::kCatmullClark, SubdivisionRule::kPrinted};

/// A flat open grid of n x n quads, points at integers.
PolygonMesh grid(int n) {
  PolygonMesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.points.emplace_back(x, y, 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int corner = y * (n + 1) + x;
      mesh.faces.push_back({corner, corner + 1, corner + n + 2, corner + n + 1});
    }
  return mesh;
}

/// An open cage with a triangle, a pentagon, a hexagon, quads, interior points of valence 3 and 5,
/// and corners of a single face.
PolygonMesh mixedCage() {
  PolygonMesh mesh;
  mesh.points = {{0, 0, 0.3}};
  for (int i = 0; i < 5; ++i) {  // a ring of five around point 0
    const double angle = 2 * std::numbers::pi * i / 5;
    mesh.points.emplace_back(std::cos(angle), std::sin(angle), 0.1 * i);
  }
  for (int i = 0; i < 5; ++i) mesh.faces.push_back({0, 1 + i, 1 + (i + 1) % 5});
  const auto add = [&](double x, double y, double z) {
    mesh.points.emplace_back(x, y, z);
    return int(mesh.points.size()) - 1;
  };
  const int a = add(2, 0.2, 0.1), b = add(2, 1.5, 0), c = add(1.2, 2.2, 0.2), d = add(0.3, 2, -0.1);
  mesh.faces.push_back({1, a, b, c, 2});  // makes a pentagon next to the ring
  mesh.faces.push_back({2, c, d, 3});     // 2 becomes an interior point of valence 4
  const int e = add(-2, 1, 0), f = add(-2.5, 0, 0.4), g = add(-2, -1, 0.2);
  mesh.faces.push_back({3, d, e, f, g, 4});  // a hexagon
  return mesh;
}

/// Three faces of a cube: an open cage around a point of valence 3.
PolygonMesh threeQuads() {
  PolygonMesh mesh;
  mesh.points = {{1, 1, 1}, {0, 1, 1}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2, 3}, {0, 3, 4, 5}, {0, 5, 6, 1}};
  return mesh;
}

double weight(const StencilMatrix& matrix, int row, int column) {
  return matrix.coeff(row, column);
}

/// The row's weights, largest first.
std::vector<double> sortedWeights(const StencilMatrix& matrix, int row) {
  std::vector<double> weights;
  for (StencilMatrix::InnerIterator entry(matrix, row); entry; ++entry)
    if (entry.value() != 0) weights.push_back(entry.value());
  std::sort(weights.rbegin(), weights.rend());
  return weights;
}

void expectWeights(const StencilMatrix& matrix, int row, const std::vector<double>& expected) {
  const std::vector<double> weights = sortedWeights(matrix, row);
  ASSERT_EQ(weights.size(), expected.size()) << "row " << row;
  for (size_t i = 0; i < weights.size(); ++i) EXPECT_NEAR(weights[i], expected[i], 1e-14) << "row " << row;
}

TEST(Subdivide, CubeMasksEqualClosedForm) {
  const PolygonMesh cube = presetCage("cube");
  for (const SubdivisionRule rule : kRules) {
    const StencilMatrix matrix = subdivide(cube, 1, rule).matrix;
    ASSERT_EQ(matrix.rows(), 6 + 12 + 8);
    ASSERT_EQ(matrix.cols(), 8);
    for (int face = 0; face < 6; ++face) {
      expectWeights(matrix, face, {0.25, 0.25, 0.25, 0.25});
      for (const int corner : cube.faces[size_t(face)])
        EXPECT_NEAR(weight(matrix, face, corner), 0.25, 1e-15);
    }
    // (3): half the midpoint and a quarter of each centroid.
    for (int edge = 6; edge < 18; ++edge)
      expectWeights(matrix, edge, {3.0 / 8, 3.0 / 8, 1.0 / 16, 1.0 / 16, 1.0 / 16, 1.0 / 16});
    // (4), valence 3: the point, its three neighbours, the three points diagonal to it; not the
    // opposite one.
    const bool printed = rule == SubdivisionRule::kPrinted;
    const double own = printed ? 13.0 / 24 : 5.0 / 12, near = printed ? 5.0 / 36 : 1.0 / 6,
                 across = printed ? 1.0 / 72 : 1.0 / 36;
    for (int point = 0; point < 8; ++point)
      for (int other = 0; other < 8; ++other) {
        const double steps = (cube.points[size_t(point)] - cube.points[size_t(other)]).cwiseAbs().sum() / 0.2;
        const double expected[] = {own, near, across, 0};
        EXPECT_NEAR(weight(matrix, 18 + point, other), expected[std::lround(steps)], 1e-15);
      }
  }
}

TEST(Subdivide, RegularGridMasksEqualClosedForm) {
  constexpr int n = 4;
  const PolygonMesh cage = grid(n);
  const int faces = n * n, edges = 2 * n * (n + 1);
  for (const SubdivisionRule rule : kRules) {
    const StencilMatrix matrix = subdivide(cage, 1, rule).matrix;
    ASSERT_EQ(matrix.rows(), faces + edges + (n + 1) * (n + 1));
    const bool printed = rule == SubdivisionRule::kPrinted;
    const double own = printed ? 13.0 / 24 : 9.0 / 16, near = printed ? 5.0 / 48 : 3.0 / 32,
                 across = printed ? 1.0 / 96 : 1.0 / 64;
    int borders = 0;
    for (int edge = faces; edge < faces + edges; ++edge) {
      const bool border = sortedWeights(matrix, edge).size() == 2;
      borders += border;
      expectWeights(matrix, edge,
                    border ? std::vector<double>{0.5, 0.5}
                           : std::vector<double>{3.0 / 8, 3.0 / 8, 1.0 / 16, 1.0 / 16, 1.0 / 16, 1.0 / 16});
    }
    EXPECT_EQ(borders, 4 * n);
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) {
        const int point = y * (n + 1) + x, row = faces + edges + point;
        const bool border = x == 0 || y == 0 || x == n || y == n;
        if (border)  // also a corner of a single face
          expectWeights(matrix, row, {0.75, 0.125, 0.125});
        else
          expectWeights(matrix, row, {own, near, near, near, near, across, across, across, across});
        EXPECT_NEAR(weight(matrix, row, point), border ? 0.75 : own, 1e-14);
        if (!border) {
          EXPECT_NEAR(weight(matrix, row, point + 1), near, 1e-14);
        }
      }
  }
}

TEST(Subdivide, RowsSumToOne) {
  for (const SubdivisionRule rule : kRules)
    for (const PolygonMesh& cage : {presetCage("vase"), mixedCage(), threeQuads(), presetCage("tube")})
      for (int levels = 1; levels <= 4; ++levels) {
        const StencilMatrix matrix = subdivide(cage, levels, rule).matrix;
        const Eigen::VectorXd sums = matrix * Eigen::VectorXd::Ones(matrix.cols());
        EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-13);
        EXPECT_GE(matrix.coeffs().minCoeff(), 0);
      }
}

/// One step on positions, from faces only: face points, then edge points in the order of their ends, then
/// vertex points.
PolygonMesh naiveStep(const PolygonMesh& mesh, SubdivisionRule rule) {
  struct Edge {
    std::vector<size_t> faces;
    int index = 0;
  };
  std::map<std::pair<int, int>, Edge> edges;
  std::vector<Vec3> centroids;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    Vec3 centroid = Vec3::Zero();
    for (size_t k = 0; k < mesh.faces[f].size(); ++k) {
      centroid += mesh.points[size_t(mesh.faces[f][k])] / double(mesh.faces[f].size());
      edges[std::minmax(mesh.faces[f][k], mesh.faces[f][(k + 1) % mesh.faces[f].size()])].faces.push_back(f);
    }
    centroids.push_back(centroid);
  }
  PolygonMesh next;
  next.points = centroids;
  const auto midpoint = [&](const std::pair<int, int>& ends) {
    return Vec3((mesh.points[size_t(ends.first)] + mesh.points[size_t(ends.second)]) / 2);
  };
  for (auto& [ends, edge] : edges) {
    edge.index = int(next.points.size());
    next.points.push_back(
        edge.faces.size() == 1
            ? midpoint(ends)
            : Vec3((centroids[edge.faces[0]] + centroids[edge.faces[1]]) / 4 + midpoint(ends) / 2));
  }
  const int first_vertex = int(next.points.size());
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    Vec3 centroid_sum = Vec3::Zero(), midpoint_sum = Vec3::Zero(), border_sum = Vec3::Zero();
    double face_count = 0, edge_count = 0, border_count = 0;
    for (size_t f = 0; f < mesh.faces.size(); ++f)
      if (std::count(mesh.faces[f].begin(), mesh.faces[f].end(), int(v)))
        centroid_sum += centroids[f], ++face_count;
    for (const auto& [ends, edge] : edges) {
      if (ends.first != int(v) && ends.second != int(v)) continue;
      midpoint_sum += midpoint(ends), ++edge_count;
      if (edge.faces.size() == 1) border_sum += midpoint(ends), ++border_count;
    }
    const Vec3 p = mesh.points[v], a = centroid_sum / face_count, m = midpoint_sum / edge_count;
    if (border_count > 0)
      next.points.push_back(p / 2 + border_sum / 4);
    else if (rule == SubdivisionRule::kPrinted)
      next.points.push_back((a + 4 * m + p) / 6);
    else
      next.points.push_back((a + 2 * m + (edge_count - 3) * p) / edge_count);
  }
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::vector<int>& face = mesh.faces[f];
    for (size_t k = 0; k < face.size(); ++k) {
      const int before = face[(k + face.size() - 1) % face.size()], after = face[(k + 1) % face.size()];
      next.faces.push_back({first_vertex + face[k], edges[std::minmax(face[k], after)].index, int(f),
                            edges[std::minmax(before, face[k])].index});
    }
  }
  return next;
}

/// Each quad's centroid and vector area, sorted: independent of the order of the points.
std::vector<std::array<double, 6>> quadSignatures(const std::vector<Vec3>& points,
                                                  const std::vector<std::vector<int>>& quads) {
  std::vector<std::array<double, 6>> signatures;
  for (const std::vector<int>& quad : quads) {
    const auto at = [&](size_t k) { return points[size_t(quad[k])]; };
    const Vec3 centroid = (at(0) + at(1) + at(2) + at(3)) / 4;
    const Vec3 area = (at(2) - at(0)).cross(at(3) - at(1));
    const auto rounded = [](double value) { return std::round(value * 1e9) / 1e9 + 0.0; };
    signatures.push_back({rounded(centroid.x()), rounded(centroid.y()), rounded(centroid.z()),
                          rounded(area.x()), rounded(area.y()), rounded(area.z())});
  }
  std::sort(signatures.begin(), signatures.end());
  return signatures;
}

TEST(Subdivide, AgreesWithNaiveSubdivision) {
  for (const SubdivisionRule rule : kRules)
    for (const PolygonMesh& cage : {mixedCage(), threeQuads(), presetCage("vase"), presetCage("tube")}) {
      PolygonMesh naive = cage;
      for (int levels = 1; levels <= 3; ++levels) {
        naive = naiveStep(naive, rule);
        const Subdivision subdivision = subdivide(cage, levels, rule);
        std::vector<std::vector<int>> quads;
        for (const std::array<int, 4>& quad : subdivision.quads) quads.emplace_back(quad.begin(), quad.end());
        const auto ours = quadSignatures(dataPoints(subdivision.matrix, cage.points), quads);
        const auto theirs = quadSignatures(naive.points, naive.faces);
        ASSERT_EQ(ours.size(), theirs.size());
        for (size_t i = 0; i < ours.size(); ++i)
          for (size_t k = 0; k < 6; ++k) EXPECT_NEAR(ours[i][k], theirs[i][k], 3e-9);
      }
    }
}

TEST(Subdivide, OrdersPointsByFacesEdgesVertices) {
  const PolygonMesh cage = mixedCage();
  for (const SubdivisionRule rule : kRules) {
    const std::vector<Vec3> ours = dataPoints(subdivide(cage, 1, rule).matrix, cage.points);
    const PolygonMesh naive = naiveStep(cage, rule);
    ASSERT_EQ(ours.size(), naive.points.size());
    const size_t faces = cage.faces.size(), vertices = cage.points.size();
    for (size_t f = 0; f < faces; ++f) EXPECT_LT((ours[f] - naive.points[f]).norm(), 1e-14);
    for (size_t v = ours.size() - vertices; v < ours.size(); ++v)
      EXPECT_LT((ours[v] - naive.points[v]).norm(), 1e-14);
  }
}

/// The result of OpenSubdiv's CPU evaluator, in float, from its own float stencils.
std::vector<Vec3> openSubdivPoints(const PolygonMesh& cage, int levels) {
  namespace Far = OpenSubdiv::Far;
  namespace Osd = OpenSubdiv::Osd;
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
  OpenSubdiv::Sdc::Options rules;
  rules.SetVtxBoundaryInterpolation(OpenSubdiv::Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(OpenSubdiv::Sdc::SCHEME_CATMARK, rules)));
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.orderVerticesFromFacesFirst = true;
  refiner->RefineUniform(uniform);
  Far::StencilTableFactoryReal<float>::Options options;
  options.generateIntermediateLevels = false;
  options.generateOffsets = true;
  const std::unique_ptr<const Far::StencilTableReal<float>> stencils(
      Far::StencilTableFactoryReal<float>::Create(*refiner, options));

  const std::unique_ptr<Osd::CpuVertexBuffer> source(
      Osd::CpuVertexBuffer::Create(3, int(cage.points.size())));
  const std::unique_ptr<Osd::CpuVertexBuffer> result(
      Osd::CpuVertexBuffer::Create(3, stencils->GetNumStencils()));
  std::vector<float> coordinates;
  for (const Vec3& point : cage.points)
    for (int axis = 0; axis < 3; ++axis) coordinates.push_back(float(point[axis]));
  source->UpdateData(coordinates.data(), 0, int(cage.points.size()));
  const Osd::BufferDescriptor xyz(0, 3, 3);
  EXPECT_TRUE(Osd::CpuEvaluator::EvalStencils(source.get(), xyz, result.get(), xyz, stencils.get()));
  std::vector<Vec3> points;
  const float* values = result->BindCpuBuffer();
  for (int i = 0; i < stencils->GetNumStencils(); ++i)
    points.emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  return points;
}

TEST(Subdivide, CatmullClarkAgreesWithOpenSubdivEvaluator) {
  for (const PolygonMesh& cage : {mixedCage(), threeQuads(), presetCage("tube"), presetCage("vase"), grid(3)})
    for (int levels = 1; levels <= 3; ++levels) {
      const std::vector<Vec3> ours =
          dataPoints(subdivide(cage, levels, SubdivisionRule::kCatmullClark).matrix, cage.points);
      const std::vector<Vec3> theirs = openSubdivPoints(cage, levels);
      ASSERT_EQ(ours.size(), theirs.size());
      for (size_t i = 0; i < ours.size(); ++i) EXPECT_LT((ours[i] - theirs[i]).norm(), 3e-6);
    }
}

TEST(Subdivide, QuadsKeepTheTopology) {
  for (const std::string& name : presetNames()) {
    const PolygonMesh cage = presetCage(name);
    const Subdivision subdivision = subdivide(cage, 2, SubdivisionRule::kCatmullClark);
    PolygonMesh surface;
    surface.points = dataPoints(subdivision.matrix, cage.points);
    for (const std::array<int, 4>& quad : subdivision.quads)
      surface.faces.emplace_back(quad.begin(), quad.end());
    EXPECT_NO_THROW(checkCage(surface, name));
    EXPECT_EQ(surface.faces.size(), 16 * cage.faces.size());
    EXPECT_EQ(subdivision.quads, subdivide(cage, 2, SubdivisionRule::kPrinted).quads);
  }
}

TEST(Subdivide, AcceptsTwoSidedSheet) {
  PolygonMesh sheet = grid(1);
  sheet.faces.push_back({sheet.faces[0][3], sheet.faces[0][2], sheet.faces[0][1], sheet.faces[0][0]});
  for (const SubdivisionRule rule : kRules) {
    const Subdivision subdivision = subdivide(sheet, 2, rule);
    const std::vector<Vec3> points = dataPoints(subdivision.matrix, sheet.points);
    EXPECT_EQ(subdivision.quads.size(), 32u);
    for (const Vec3& point : points) EXPECT_TRUE((point.array() >= 0).all() && (point.array() <= 1).all());
  }
}

TEST(Subdivide, RejectsInvalidInput) {
  const PolygonMesh tube = presetCage("tube");
  for (const SubdivisionRule rule : kRules) {
    EXPECT_THROW(subdivide(tube, 0, rule), Error);
    EXPECT_THROW(subdivide(tube, 16, rule), Error);
    EXPECT_THROW(subdivide(tube, 10, rule), Error);  // 22 million
    EXPECT_THROW(subdivide(tube, 15, rule), Error);
    PolygonMesh disc;  // few data points, but each of 40,000 depends on 20,000 control points
    for (int i = 0; i < 20'000; ++i) disc.points.emplace_back(std::cos(i), std::sin(i), 0);
    disc.faces.emplace_back();
    for (int i = 0; i < 20'000; ++i) disc.faces[0].push_back(i);
    EXPECT_THROW(subdivide(disc, 2, rule), Error);
    PolygonMesh bad = tube;
    bad.faces.push_back(bad.faces[0]);
    EXPECT_THROW(subdivide(bad, 1, rule), Error);
    bad.faces.back() = {0, 1, 99};
    EXPECT_THROW(subdivide(bad, 1, rule), Error);
    EXPECT_THROW(subdivide({}, 1, rule), Error);
  }
}

TEST(Subdivide, NormalsOfPlaneAndBallAreExact) {
  const PolygonMesh plane = grid(3);
  const Subdivision flat = subdivide(plane, 2, SubdivisionRule::kCatmullClark);
  for (const Vec3& normal : dataNormals(flat.quads, dataPoints(flat.matrix, plane.points)))
    EXPECT_LT((normal - Vec3::UnitZ()).norm(), 1e-12);
  const PolygonMesh ball = presetCage("ball");
  const Subdivision round = subdivide(ball, 3, SubdivisionRule::kCatmullClark);
  const std::vector<Vec3> points = dataPoints(round.matrix, ball.points),
                          normals = dataNormals(round.quads, points);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(normals[i].norm(), 1, 1e-12);
    EXPECT_GT(normals[i].dot(points[i].normalized()), std::cos(0.1));
  }
}

TEST(Subdivide, NormalsAreAreaWeighted) {
  // Two quads that share the y axis, one upright and twice as large: their normals are 1 z and 2 x.
  const std::vector<Vec3> points = {{0, 0, 0}, {-1, 0, 0}, {-1, 1, 0}, {0, 1, 0}, {0, 0, -2}, {0, 1, -2}};
  const std::vector<std::array<int, 4>> quads = {{1, 0, 3, 2}, {0, 4, 5, 3}};
  const std::vector<Vec3> normals = dataNormals(quads, points);
  EXPECT_LT((normals[1] - Vec3(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((normals[4] - Vec3(1, 0, 0)).norm(), 1e-15);
  EXPECT_LT((normals[0] - Vec3(2, 0, 1).normalized()).norm(), 1e-15);
}

}  // namespace
}  // namespace airclay
