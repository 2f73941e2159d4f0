// SPDX-License-Identifier: MIT
// Exported files as another library (assimp) reads them: positions, faces, normals, orientation, up axis;
// what a slicer would report; and rejected input.
#include "engine/mesh/mesh_export.h"

#include <assimp/GltfMaterial.h>
#include <assimp/commonMetaData.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <cstring>
#include <map>
#include <random>

#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using Corners = std::vector<Vec3>;

/// A file as assimp reads it: positions and normals of each face's corners, in file order.
struct Reread {
  std::vector<Corners> faces, normals;
  std::string generator;
  Eigen::Vector4d color = Eigen::Vector4d::Zero();
  double metallic = -1, roughness = -1;
  int two_sided = -1;
};

Vec3 toVec3(const aiVector3D& vector) {
  return {vector.x, vector.y, vector.z};
}

Reread reread(const std::filesystem::path& file) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (!scene || scene->mNumMeshes != 1) throw std::runtime_error(importer.GetErrorString());
  const aiMesh& mesh = *scene->mMeshes[0];
  Reread result;
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    Corners places, normals;
    for (unsigned j = 0; j < mesh.mFaces[i].mNumIndices; ++j) {
      places.push_back(toVec3(mesh.mVertices[mesh.mFaces[i].mIndices[j]]));
      if (mesh.mNormals) normals.push_back(toVec3(mesh.mNormals[mesh.mFaces[i].mIndices[j]]));
    }
    result.faces.push_back(places);
    result.normals.push_back(normals);
  }
  aiString generator;
  if (scene->mMetaData && scene->mMetaData->Get(AI_METADATA_SOURCE_GENERATOR, generator))
    result.generator = generator.C_Str();
  const aiMaterial& material = *scene->mMaterials[mesh.mMaterialIndex];
  aiColor4D color;
  float metallic = -1, roughness = -1;
  if (material.Get(AI_MATKEY_BASE_COLOR, color) == AI_SUCCESS)
    result.color = {color.r, color.g, color.b, color.a};
  if (material.Get(AI_MATKEY_METALLIC_FACTOR, metallic) == AI_SUCCESS) result.metallic = metallic;
  if (material.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness) == AI_SUCCESS) result.roughness = roughness;
  material.Get(AI_MATKEY_TWOSIDED, result.two_sided);
  return result;
}

/// Sum of signed tetrahedra; faces are fans from their first corner.
double volumeOf(const std::vector<Corners>& faces) {
  double volume = 0;
  for (const Corners& face : faces)
    for (std::size_t i = 2; i < face.size(); ++i) volume += face[0].dot(face[i - 1].cross(face[i])) / 6;
  return volume;
}

/// Edges that do not occur once in each direction.
int openEdgesOf(const std::vector<Corners>& faces) {
  using Place = std::array<double, 3>;
  std::map<std::pair<Place, Place>, int> runs;
  const auto place = [](const Vec3& p) { return Place{p.x(), p.y(), p.z()}; };
  for (const Corners& face : faces)
    for (std::size_t i = 0; i < face.size(); ++i)
      ++runs[{place(face[i]), place(face[(i + 1) % face.size()])}];
  int open = 0;
  for (const auto& [edge, count] : runs) {
    const auto back = runs.find({edge.second, edge.first});
    open += std::max(0, count - (back == runs.end() ? 0 : back->second));
  }
  return open;
}

PolygonMesh surface(const std::string& preset, int levels) {
  const PolygonMesh cage = presetCage(preset);
  const Subdivision subdivision = subdivide(cage, levels, SubdivisionRule::kCatmullClark);
  PolygonMesh mesh{dataPoints(subdivision.matrix, cage.points), {}};
  for (const std::array<int, 4>& quad : subdivision.quads) mesh.faces.emplace_back(quad.begin(), quad.end());
  return mesh;
}

std::vector<Vec3> normalsOf(const PolygonMesh& quads) {
  std::vector<std::array<int, 4>> faces;
  for (const std::vector<int>& face : quads.faces) faces.push_back({face[0], face[1], face[2], face[3]});
  return dataNormals(faces, quads.points);
}

double distance(const Vec3& a, const Vec3& b) {
  return (a - b).norm();
}

/// A planar polygon as a mesh in space.
PolygonMesh inSpace(const std::vector<Vec2>& corners) {
  const Mat3 turn = rotationFromVector({0.3, -0.8, 1.1});
  PolygonMesh mesh;
  mesh.faces.emplace_back();
  for (const Vec2& corner : corners) {
    mesh.faces[0].push_back(int(mesh.points.size()));
    mesh.points.push_back(turn * Vec3(corner.x(), corner.y(), 0) + Vec3(1, 2, 3));
  }
  return mesh;
}

double shoelace(const std::vector<Vec2>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

/// The polygon's triangles cover it without folds: all have its orientation, and their areas add up to its
/// own.
void expectCovers(const std::vector<Vec2>& corners) {
  const auto triangles = triangulated(inSpace(corners));
  ASSERT_EQ(triangles.size(), corners.size() - 2);
  double area = 0;
  for (const auto& [a, b, c] : triangles) {
    const double part = shoelace({corners[std::size_t(a)], corners[std::size_t(b)], corners[std::size_t(c)]});
    EXPECT_GT(part, 0);
    area += part;
  }
  EXPECT_NEAR(area, shoelace(corners), 1e-12 * shoelace(corners));
}

TEST(MeshExport, StlIsClosedOutwardAndInMillimetres) {
  const TemporaryFolder folder;
  const PolygonMesh mesh = surface("ball", 3);
  const MeshExport report = exportMesh(folder / "ball.stl", mesh);
  const Reread read = reread(folder / "ball.stl");
  ASSERT_EQ(read.faces.size(), 2 * mesh.faces.size());
  EXPECT_EQ(report.faces, read.faces.size());
  EXPECT_EQ(report.triangles, read.faces.size());
  EXPECT_EQ(openEdgesOf(read.faces), 0);
  EXPECT_TRUE(report.watertight());
  double volume_m3 = 0;  // each quad along its shorter diagonal
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    Corners quad;
    for (const int corner : mesh.faces[i]) quad.push_back(mesh.points[std::size_t(corner)]);
    if (distance(quad[1], quad[3]) < distance(quad[0], quad[2]))
      std::rotate(quad.begin(), quad.begin() + 1, quad.end());
    volume_m3 += volumeOf({quad});
    for (std::size_t j = 0; j < 2; ++j) {
      const Corners& triangle = read.faces[2 * i + j];
      for (const Vec3& corner : triangle) {
        double nearest = 1e9;
        for (const Vec3& own : quad) nearest = std::min(nearest, distance(corner, 1000 * own));
        EXPECT_LT(nearest, 1e-4);  // mm
      }
      const Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
      EXPECT_LT(distance(read.normals[2 * i + j][0], normal), 1e-5);
      EXPECT_GT(normal.dot(triangle[0]), 0);  // the ball is at the origin
    }
  }
  EXPECT_NEAR(volumeOf(read.faces), 1e9 * volume_m3, 1e-6 * 1e9 * volume_m3);
  EXPECT_NEAR(report.volume_m3, volume_m3, 1e-6 * volume_m3);
}

TEST(MeshExport, StlOfACubeHasItsVolume) {
  const TemporaryFolder folder;
  const MeshExport report = exportMesh(folder / "cube.STL", presetCage("cube"));
  const Reread read = reread(folder / "cube.STL");
  const Vec3 size_mm = 1000 * report.size_m;
  EXPECT_EQ(read.faces.size(), 12u);
  EXPECT_NEAR(volumeOf(read.faces), size_mm.prod(), 1e-6 * size_mm.prod());
  EXPECT_GT(size_mm.minCoeff(), 100);  // about 0.2 m
  EXPECT_EQ(readWhole(folder / "cube.STL", 1 << 20).size(), 84u + 50 * 12);
  EXPECT_FALSE(readWhole(folder / "cube.STL", 1 << 20).starts_with("solid"));
}

TEST(MeshExport, PlyKeepsPolygonsAndHasSmoothNormals) {
  const TemporaryFolder folder;
  const PolygonMesh mesh = surface("vase", 2);
  const std::vector<Vec3> normals = normalsOf(mesh);
  const MeshExport report = exportMesh(folder / "vase.ply", mesh);
  const Reread read = reread(folder / "vase.ply");
  ASSERT_EQ(read.faces.size(), mesh.faces.size());
  EXPECT_EQ(report.faces, mesh.faces.size());
  EXPECT_EQ(report.vertices, mesh.points.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    ASSERT_EQ(read.faces[i].size(), 4u);
    for (std::size_t j = 0; j < 4; ++j) {
      const auto corner = std::size_t(mesh.faces[i][j]);
      EXPECT_LT(distance(read.faces[i][j], mesh.points[corner]), 1e-7);
      EXPECT_LT(distance(read.normals[i][j], normals[corner]), 1e-6);
    }
  }
}

TEST(MeshExport, PlySupportsFacesWithOver255Corners) {
  const TemporaryFolder folder;
  std::vector<Vec2> circle;
  for (int i = 0; i < 300; ++i) circle.push_back({std::cos(i * M_PI / 150), std::sin(i * M_PI / 150)});
  const PolygonMesh disc = inSpace(circle);
  const MeshExport report = exportMesh(folder / "disc.ply", disc);
  EXPECT_EQ(report.open_edges, 300u);
  const Reread read = reread(folder / "disc.ply");
  ASSERT_EQ(read.faces.size(), 1u);
  ASSERT_EQ(read.faces[0].size(), 300u);
  for (std::size_t i = 0; i < 300; ++i) EXPECT_LT(distance(read.faces[0][i], disc.points[i]), 1e-6);
}

TEST(MeshExport, GlbIsYUpInMetresWithNormalsAndClayMaterial) {
  const TemporaryFolder folder;
  const PolygonMesh mesh = surface("vase", 2);
  const std::vector<Vec3> normals = normalsOf(mesh);
  const auto triangles = triangulated(mesh);
  const MeshExport report = exportMesh(folder / "vase.glb", mesh);
  const Reread read = reread(folder / "vase.glb");
  ASSERT_EQ(read.faces.size(), triangles.size());
  EXPECT_EQ(report.faces, triangles.size());
  const auto y_up = [](const Vec3& p) { return Vec3(p.x(), p.z(), -p.y()); };
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto corner = std::size_t(triangles[i][j]);
      EXPECT_LT(distance(read.faces[i][j], y_up(mesh.points[corner])), 1e-7);
      EXPECT_LT(distance(read.normals[i][j], y_up(normals[corner])), 1e-6);
    }
  EXPECT_EQ(read.generator, "Airclay");
  EXPECT_EQ(read.metallic, 0);
  EXPECT_GT(read.roughness, 0.5);
  EXPECT_EQ(read.color[3], 1);
  EXPECT_GT(read.color[0], read.color[2]);  // warm
  EXPECT_EQ(read.two_sided, report.watertight() ? 0 : 1);
}

TEST(MeshExport, GlbOfABallIsOutwardAndWellFormed) {
  const TemporaryFolder folder;
  const PolygonMesh mesh = surface("ball", 2);
  const MeshExport report = exportMesh(folder / "ball.glb", mesh);
  const Reread read = reread(folder / "ball.glb");
  EXPECT_NEAR(volumeOf(read.faces), report.volume_m3, 1e-6 * report.volume_m3);
  EXPECT_GT(report.volume_m3, 0.003);  // a ball of about 0.2 m
  EXPECT_EQ(read.two_sided, 0);
  // Khronos, glTF 2.0, section 4.4: the header's length, chunks of whole 32-bit words.
  const std::string bytes = readWhole(folder / "ball.glb", 1 << 24);
  std::array<std::uint32_t, 5> header{};
  std::memcpy(header.data(), bytes.data(), sizeof header);
  EXPECT_EQ(header[2], bytes.size());
  EXPECT_EQ(bytes.size() % 4, 0u);
  EXPECT_EQ(header[3] % 4, 0u);
}

TEST(MeshExport, ObjKeepsPolygonsAndDigits) {
  const TemporaryFolder folder;
  const PolygonMesh mesh = surface("slab", 1);
  exportMesh(folder / "slab.obj", mesh);
  const Reread read = reread(folder / "slab.obj");
  ASSERT_EQ(read.faces.size(), mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    for (std::size_t j = 0; j < 4; ++j)
      EXPECT_LT(distance(read.faces[i][j], mesh.points[std::size_t(mesh.faces[i][j])]), 1e-7);
}

TEST(MeshExport, CountsOpenEdges) {
  const TemporaryFolder folder;
  // The tube's two rims: 7 edges each, doubled twice.
  EXPECT_EQ(exportMesh(folder / "a.stl", surface("tube", 2)).open_edges, 56u);
  PolygonMesh cube = presetCage("cube");
  const std::size_t faces = cube.faces.size();
  EXPECT_EQ(exportMesh(folder / "a.stl", cube).open_edges, 0u);
  std::reverse(cube.faces[0].begin(), cube.faces[0].end());
  EXPECT_EQ(exportMesh(folder / "a.stl", cube).open_edges,
            8u);  // twice in the same direction along each of four
  cube.faces.erase(cube.faces.begin());
  EXPECT_EQ(exportMesh(folder / "a.stl", cube).open_edges, 4u);
  EXPECT_EQ(openEdgesOf(reread(folder / "a.stl").faces), 4);
  EXPECT_EQ(reread(folder / "a.stl").faces.size(), 2 * (faces - 1));
}

TEST(MeshExport, StlMergesCoincidentPoints) {
  const TemporaryFolder folder;
  const PolygonMesh cube = presetCage("cube");
  PolygonMesh apart;  // each face with its own points
  for (const std::vector<int>& face : cube.faces) {
    apart.faces.emplace_back();
    for (const int corner : face) {
      apart.faces.back().push_back(int(apart.points.size()));
      apart.points.push_back(cube.points[std::size_t(corner)]);
    }
  }
  const MeshExport report = exportMesh(folder / "apart.stl", apart);
  EXPECT_TRUE(report.watertight());
  EXPECT_EQ(report.vertices, apart.points.size());
}

TEST(MeshExport, NegativeVolumeMeansInsideOut) {
  const TemporaryFolder folder;
  PolygonMesh ball = surface("ball", 1);
  const double volume = exportMesh(folder / "ball.ply", ball).volume_m3;
  for (std::vector<int>& face : ball.faces) std::reverse(face.begin(), face.end());
  const MeshExport report = exportMesh(folder / "ball.ply", ball);
  EXPECT_NEAR(report.volume_m3, -volume, 1e-12);
  EXPECT_TRUE(report.watertight());
}

TEST(MeshExport, StlOmitsZeroAreaTriangles) {
  const TemporaryFolder folder;
  // A tetrahedron with one edge that is a collapsed quad.
  PolygonMesh mesh;
  mesh.points = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}, {0, 0, 0}, {0.1, 0, 0}};
  mesh.faces = {{0, 2, 1}, {4, 5, 3}, {1, 2, 3}, {0, 3, 2}, {0, 1, 5, 4}};
  const MeshExport stl = exportMesh(folder / "a.stl", mesh);
  EXPECT_EQ(stl.faces, 4u);
  EXPECT_TRUE(stl.watertight());
  const Reread read = reread(folder / "a.stl");
  EXPECT_EQ(read.faces.size(), 4u);
  EXPECT_NEAR(volumeOf(read.faces), 1e6 / 6, 1);
  EXPECT_EQ(exportMesh(folder / "a.ply", mesh).faces, 5u);
}

TEST(MeshExport, QuadsAreSplitInside) {
  expectCovers({{0, 0}, {2, 0}, {2, 1}, {0, 1}});
  expectCovers({{0, 0}, {1, 0}, {2, 0}, {1, 10}});    // a straight corner; the diagonal over it is shorter
  expectCovers({{0, 0}, {1, 0.2}, {2, 0}, {1, 10}});  // an arrowhead
  expectCovers({{1, 10}, {0, 0}, {1, 0.2}, {2, 0}});  // with another first corner
  const PolygonMesh kite = inSpace({{0, 0}, {1, -0.1}, {3, 0}, {1, 0.1}});
  EXPECT_EQ(triangulated(kite), (std::vector<std::array<int, 3>>{{0, 1, 3}, {1, 2, 3}}));
}

TEST(MeshExport, PolygonsAreSplitInside) {
  expectCovers({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}});                  // an L
  expectCovers({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {2, 1}, {1, 1}, {0, 1}});  // straight corners
  expectCovers({{0, 0},
                {5, 0},
                {5, 5},
                {1, 5},
                {1, 2},
                {3, 2},
                {3, 3},
                {2, 3},
                {2, 4},
                {4, 4},
                {4, 1},
                {0, 1}});  // a spiral
  std::mt19937 random(5);
  for (int trial = 0; trial < 200; ++trial) {  // stars about the origin
    const int count = 5 + int(random() % 60);
    std::vector<Vec2> star;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * M_PI * i / count;
      const double radius = std::uniform_real_distribution<>(0.1, 1)(random);
      star.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    expectCovers(star);
  }
}

TEST(MeshExport, TriangulationTerminatesForDegeneratePolygons) {
  EXPECT_EQ(triangulated(inSpace({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}})).size(), 3u);
  EXPECT_EQ(triangulated(inSpace({{0, 0}, {2, 2}, {2, 0}, {0, 2}, {1, 3}, {-1, 1}})).size(), 4u);
}

TEST(MeshExport, CancellingNormalsPointUp) {
  PolygonMesh sheet;  // both sides of one triangle
  sheet.points = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  sheet.faces = {{0, 1, 2}, {2, 1, 0}};
  EXPECT_EQ(smoothNormals(sheet)[0], Vec3(0, 0, 1));
}

TEST(MeshExport, LevelZeroIsTheCage) {
  const PolygonMesh cage = presetCage("tube");
  EXPECT_EQ(meshAtLevel(cage, 0, SubdivisionRule::kPrinted).faces, cage.faces);
  EXPECT_EQ(meshAtLevel(cage, 2, SubdivisionRule::kPrinted).points.size(), 364u);
  EXPECT_THROW(meshAtLevel(cage, -1, SubdivisionRule::kPrinted), Error);
}

TEST(MeshExport, RejectsUnrepresentableMeshes) {
  const TemporaryFolder folder;
  const PolygonMesh cube = presetCage("cube");
  const auto errorOf = [&](const std::string& name, const PolygonMesh& mesh) {
    return messageOf([&] { exportMesh(folder / name, mesh); });
  };
  for (const char* name : {"a.xyz", "a", "a.stl.gz", ".stl"}) {
    const std::string message = errorOf(name, cube);
    for (const char* ending : {".obj", ".ply", ".stl", ".glb"})
      EXPECT_NE(message.find(ending), std::string::npos) << name << ": " << message;
  }
  PolygonMesh far = cube, nowhere = cube, torn = cube;
  far.points[2].y() = 1e300;
  nowhere.points[2].y() = std::nan("");
  torn.faces[3][1] = 99;
  EXPECT_NE(errorOf("a.stl", far).find("a.stl: point 3"), std::string::npos);
  EXPECT_NE(errorOf("a.glb", nowhere).find("a.glb: point 3"), std::string::npos);
  EXPECT_NE(errorOf("a.ply", torn).find("a.ply: face 4 has a corner 100"), std::string::npos);
  EXPECT_NE(errorOf("a.ply", {cube.points, {}}).find("no face"), std::string::npos);
  std::vector<Vec2> circle;
  for (int i = 0; i < 10'001; ++i) circle.push_back({std::cos(i * 6e-4), std::sin(i * 6e-4)});
  EXPECT_NE(errorOf("a.stl", inSpace(circle)).find("10001 corners"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(MeshExport, FullDiskKeepsTheOldFile) {
  const TemporaryFolder folder;
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.glb"}) {
    exportMesh(folder / name, presetCage("cube"));
    const std::string before = readWhole(folder / name, 1 << 20);
    // No file of this process may exceed 2,000 bytes: the same error in the middle of a file.
    signal(SIGXFSZ, SIG_IGN);
    rlimit usual{};
    getrlimit(RLIMIT_FSIZE, &usual);
    const rlimit small{2000, usual.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string message = messageOf([&] { exportMesh(folder / name, surface("ball", 3)); });
    setrlimit(RLIMIT_FSIZE, &usual);
    EXPECT_NE(message.find(std::string(name) + ": cannot be written"), std::string::npos) << message;
    EXPECT_EQ(readWhole(folder / name, 1 << 20), before);
    std::filesystem::remove(folder / name);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << name;
  }
  std::filesystem::create_symlink("/dev/full", folder / "b.stl");
  EXPECT_NE(messageOf([&] { exportMesh(folder / "b.stl", presetCage("cube")); }).find("No space left"),
            std::string::npos);
}

TEST(MeshExport, ReadOnlyFolderIsAOneLineError) {
  const TemporaryFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  const bool is_root = geteuid() == 0;  // root may write to any folder
  ASSERT_EQ(is_root ? seteuid(65534) : 0, 0);
  const std::string message = messageOf([&] { exportMesh(folder / "a.stl", presetCage("cube")); });
  ASSERT_EQ(is_root ? seteuid(0) : 0, 0);
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  EXPECT_NE(message.find("a.stl: cannot be written: Permission denied"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace airclay
