// SPDX-License-Identifier: MIT
// PLY, STL and glTF as cages: every encoding gives the same cube, and damage is named with its place.
#include <gtest/gtest.h>

#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "engine/core/error.h"
#include "engine/mesh/cage_file.h"
#include "engine/mesh/mesh_export.h"
#include "tests/support/cage_files.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

struct CageFormats : ::testing::Test {
  TemporaryFolder folder;
  CageReading read(const std::string& name, const std::string& content,
                   const CageReadOptions& options = {}) const {
    return readCage(folder.write(name, content), options);
  }
  std::string refusal(const std::string& name, const std::string& content) const {
    return messageOf([&] { read(name, content); });
  }
};

double volumeOf(const PolygonMesh& cage) {
  TriangleMesh triangles{cage.points, triangulated(cage)};
  return massProperties(triangles).volume_m3;
}

TEST_F(CageFormats, EveryFormatGivesTheSameCube) {
  CageReadOptions options;  // the same for all
  options.units = LengthUnit::kMetre;
  options.up = UpAxis::kZ;
  for (const auto& [name, content] : cageFiles(cubeCage(0.25))) {
    const CageReading reading = read(name, content, options);
    EXPECT_EQ(reading.cage.points.size(), 8u) << name;
    EXPECT_TRUE(reading.is_closed) << name;
    EXPECT_NEAR(volumeOf(reading.cage), 0.25 * 0.25 * 0.25, 1e-12) << name;
    const bool keeps_quads = name.ends_with(".obj") || name.ends_with(".ply");
    EXPECT_EQ(reading.cage.faces.size(), keeps_quads ? 6u : 12u) << name;
    EXPECT_EQ(reading.hints.size(), keeps_quads ? 0u : 1u) << name;  // triangles
    // Its one loose edge.
    EXPECT_EQ(reading.repairs.size(), name.ends_with(".ply") ? 1u : 0u) << name;
  }
}

TEST_F(CageFormats, NamesTheFormat) {
  std::vector<std::string> formats;
  for (const auto& [name, content] : cageFiles(cubeCage(0.2))) formats.push_back(read(name, content).format);
  EXPECT_EQ(formats, (std::vector<std::string>{"OBJ", "PLY, text", "PLY, binary little endian",
                                               "PLY, binary big endian", "STL, text", "STL, binary",
                                               "glTF, text", "glTF, binary"}));
}

TEST_F(CageFormats, ExtensionsInAnyCaseAndUnusualNames) {
  for (const auto& [name, content] : cageFiles(cubeCage(0.2))) {
    std::string capitals = name;
    for (char& c : capitals) c = char(std::toupper(static_cast<unsigned char>(c)));
    for (const std::string& unusual : {capitals, "my cage #1 " + name, "Töpfchen/粘土 " + name})
      EXPECT_EQ(read(unusual, content).cage.points.size(), 8u) << unusual;
  }
}

TEST_F(CageFormats, UnitsAndAxesOfTheFormat) {
  // Millimetres in STL, as our own export writes it.
  EXPECT_NEAR(volumeOf(read("a.stl", stlBinaryOf(cubeCage(200))).cage), 0.008, 1e-9);
  EXPECT_TRUE(
      contains(read("a.stl", stlBinaryOf(cubeCage(0.2))).hints[0], "they look like m (0.2 m): --units m"));
  // y up in glTF.
  PolygonMesh slab = cubeCage(0.2);
  for (Vec3& point : slab.points) point.y() /= 4;
  for (const PolygonMesh& cage : {read("a.glb", glbOf(slab)).cage, read("a.gltf", gltfOf(slab)).cage}) {
    Eigen::AlignedBox3d box;
    for (const Vec3& point : cage.points) box.extend(point);
    EXPECT_LT((box.sizes() - Vec3(0.2, 0.2, 0.05)).norm(), 1e-6);
    EXPECT_NEAR(volumeOf(cage), 0.002, 1e-9);
  }
}

TEST_F(CageFormats, ReadsWhatItExports) {
  const PolygonMesh vase = meshAtLevel(presetCage("vase"), 1, SubdivisionRule::kCatmullClark);
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.glb"}) {
    const MeshExport written = exportMesh(folder / name, vase);
    const CageReading reading = readCage(folder / name);
    EXPECT_EQ(reading.cage.points.size(), vase.points.size()) << name;
    EXPECT_EQ(reading.cage.faces.size(), written.faces) << name;
    EXPECT_TRUE(reading.repairs.empty()) << name << ": " << reading.repairs[0];
    EXPECT_NEAR(volumeOf(reading.cage), written.volume_m3, 1e-5 * written.volume_m3) << name;
  }
}

TEST_F(CageFormats, ReadsFormsOfPly) {
  const std::string text = plyOf(cubeCage(0.2), PlyEncoding::kText);
  EXPECT_EQ(read("a.ply", replaced(text, "vertex_indices", "vertex_index")).cage.faces.size(), 6u);
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(read("a.ply", windows).cage.faces.size(), 6u);
  const CageReading reading = read("a.ply", text.substr(0, text.size() - 1));
  EXPECT_EQ(reading.cage.faces.size(), 6u);  // without the last newline
}

TEST_F(CageFormats, RefusesPlyWithThePlace) {
  const std::string text = plyOf(cubeCage(0.2), PlyEncoding::kText);
  const std::string little = plyOf(cubeCage(0.2), PlyEncoding::kLittleEndian);
  struct Case {
    std::string content, expected;
  };
  const Case cases[] = {
      {"plx\n", ":1: a PLY file begins"},
      {"ply\nformat ascii 1.0\n", ":3: `end_header` is missing"},
      {replaced(text, "ascii", "xml"), ":2: format 'xml' is unknown"},
      {replaced(text, "format ascii 1.0\n", ""), "no `format` line"},
      {replaced(text, "double x", "real x"), ":8: 'real' is not a PLY type"},
      {replaced(text, "double x", "double u"), "no property x"},
      {replaced(text, "int vertex_indices", "int corners"), "no list vertex_indices"},
      {replaced(text, "comment", "coment"), ":3: 'coment' is not a statement"},
      {replaced(text, "vertex 8", "vertex -8"), ":7: an element needs a name and a count"},
      {replaced(text, "0.2 nan 0 0 255", "nan nan 0 0 255"), ":22: coordinate x of vertex 2"},
      {replaced(text, "0 4 0 2 3 1", "0 4 0 2 3 8"),
       ":29: face 1: vertex index 8 is out of range; expected 0 to 7"},
      {replaced(text, "0 4 0 2 3 1", "0 4 0 2 3 1.5"), ":29: face 1: vertex index 1.5"},
      {replaced(text, "0 4 0 2 3 1", "0 2 0 2"), ":29: face 1 has 2 corners"},
      {text.substr(0, text.size() - 3), "truncated"},
      {little.substr(0, little.size() - 9), "it is truncated"},
      {replaced(little, std::string("\0\x04\0\0\0\0\x02", 7), std::string("\0\x04\x09\0\0\0\x02", 7)),
       ": byte "},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
       "end_header\n1 2 3\n",
       "no faces"},
  };
  for (const Case& bad : cases)
    EXPECT_TRUE(contains(refusal("a.ply", bad.content), bad.expected))
        << refusal("a.ply", bad.content) << "\nexpected " << bad.expected;
}

TEST_F(CageFormats, RefusesCountsThatTheFileCannotContain) {
  const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
  const std::string properties =
      "\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\n"
      "property list uint uint vertex_indices\nend_header\n";
  EXPECT_TRUE(contains(refusal("a.ply", head + "4000000000" + properties + "1234"),
                       "the header declares 4000000000 of element 'vertex', but only 4 bytes follow"));
  const std::string one = head + "1" + properties + std::string(12, '\0');
  EXPECT_TRUE(contains(refusal("a.ply", one), "4000000000 of element 'face'"));
  const std::string long_face = replaced(one, "4000000000", "1") + "\xff\xff\xff\x7f";
  EXPECT_TRUE(contains(refusal("a.ply", long_face), "corner count 2147483647 is out of range"));
  std::string stl = stlBinaryOf(cubeCage(0.2));
  stl[83] = '\x7f';
  EXPECT_TRUE(contains(refusal("a.stl", stl), "declares 2130706444 triangles"));
  EXPECT_TRUE(
      contains(refusal("a.gltf", replaced(gltfOf(cubeCage(0.2)), "\"count\":24", "\"count\":4000000000")),
               "extends beyond its buffer"));
}

TEST_F(CageFormats, ReadsFormsOfStl) {
  // Some programs begin the header of a binary file as a text begins.
  EXPECT_EQ(read("a.stl", stlBinaryOf(cubeCage(200), "solid cube")).cage.points.size(), 8u);
  EXPECT_EQ(read("a.stl", stlBinaryOf(cubeCage(200)) + "trailing").repairs,
            std::vector<std::string>{"ignored 8 bytes after the last triangle"});
  std::string capitals = stlTextOf(cubeCage(200));
  for (char& c : capitals) c = c == '\n' ? c : char(std::toupper(static_cast<unsigned char>(c)));
  EXPECT_EQ(read("a.stl", capitals).cage.points.size(), 8u);
  PolygonMesh moved = cubeCage(200);
  for (Vec3& point : moved.points) point.x() += 1000;
  EXPECT_EQ(read("a.stl", stlTextOf(cubeCage(200)) + stlTextOf(moved)).cage.points.size(), 16u);
}

TEST_F(CageFormats, RefusesStlWithThePlace) {
  const std::string text = stlTextOf(cubeCage(0.2)), binary = stlBinaryOf(cubeCage(0.2));
  std::string not_finite = binary;
  not_finite.replace(84 + 12 + 8, 4, "\xff\xff\xff\xff");
  struct Case {
    std::string content, expected;
  };
  const Case cases[] = {
      {"", "the file is empty"},
      {"not an STL file", "not an STL file"},
      {"solid a\nendsolid a\n", "no triangles"},
      {replaced(text, "vertex 0 0 0", "vertex 0 inf 0"), ":4: coordinate 'inf' is not a finite number"},
      {replaced(text, "vertex 0 0 0", "vertex 0 0"), ":4: a vertex has 2 coordinates"},
      {replaced(text, "outer loop", "inner loop"), ":3: 'inner' is not an STL statement"},
      {replaced(text, "   vertex 0 0 0\n", ""), ":6: a loop has 2 vertices"},
      {replaced(text, "  endloop\n", ""), ":7: `endloop` is missing"},
      {text.substr(0, text.find("endfacet", text.size() / 2)), "it is truncated"},
      {binary.substr(0, 500), "it is truncated"},
      {not_finite, ": byte 96: a coordinate of triangle 1"},
  };
  for (const Case& bad : cases)
    EXPECT_TRUE(contains(refusal("a.stl", bad.content), bad.expected))
        << refusal("a.stl", bad.content) << "\nexpected " << bad.expected;
}

TEST_F(CageFormats, ReadsFormsOfGltf) {
  const PolygonMesh cube = cubeCage(0.2);
  // The buffer in a file next to it, whose name is percent-encoded.
  folder.write("sub/my buffer #1.bin", gltfBuffer(cube));
  EXPECT_EQ(read("sub/a.gltf", gltfOf(cube, "my%20buffer%20%231.bin")).cage.points.size(), 8u);
  // Two nodes, one mirrored and moved: its faces are clockwise in the file's mesh, and outwards in the scene.
  const std::string nodes = R"("nodes":[{"mesh":0},{"mesh":0,"scale":[-1,1,1],"translation":[1,0,0]}])";
  std::string two = replaced(gltfOf(cube), R"("nodes":[{"mesh":0}])", nodes);
  two = replaced(two, R"([{"nodes":[0]}])", R"([{"nodes":[0,1]}])");
  const CageReading reading = read("two.gltf", two);
  EXPECT_EQ(reading.cage.points.size(), 16u);
  EXPECT_NEAR(volumeOf(reading.cage), 2 * 0.008, 1e-8);
  EXPECT_TRUE(reading.repairs.empty());
  // Images are of no use, missing or not; a node outside the scene is not part of it.
  EXPECT_EQ(read("image.gltf",
                 replaced(gltfOf(cube), "\"scene\":0,", R"("scene":0,"images":[{"uri":"none.png"}],)"))
                .cage.points.size(),
            8u);
  EXPECT_EQ(read("outside.gltf", replaced(gltfOf(cube), R"("nodes":[{"mesh":0}])", nodes)).cage.points.size(),
            8u);
}

TEST_F(CageFormats, RefusesGltfWithTheReason) {
  const PolygonMesh cube = cubeCage(0.2);
  const std::string text = gltfOf(cube), glb = glbOf(cube);
  struct Case {
    std::string name, content, expected;
  };
  const Case cases[] = {
      {"a.gltf", "{", "damaged glTF"},
      {"a.gltf", "[]", "damaged glTF"},
      {"a.gltf", R"({"asset":{"version":"2.0"}})", "no triangles"},
      {"a.gltf", gltfOf(cube, "none.bin"), "none.bin"},
      {"a.gltf", replaced(text, R"("nodes":[0])", R"("nodes":[7])"), "node 7 does not exist"},
      {"a.gltf", replaced(text, R"("nodes":[0])", R"("nodes":[0,0])"), "node 0 has two parents"},
      {"a.gltf", replaced(text, R"({"mesh":0})", R"({"mesh":3})"), "mesh 3 does not exist"},
      {"a.gltf", replaced(text, R"("POSITION":0)", R"("POSITION":9)"), "POSITION: no such accessor"},
      {"a.gltf", replaced(text, R"("type":"VEC3")", R"("type":"VEC2")"),
       "POSITION: an accessor of the wrong type"},
      {"a.gltf",
       replaced(text, "\"scene\":0,",
                "\"extras\":" + std::string(100000, '[') + std::string(100000, ']') + ","),
       "nested more than 100 levels"},
      {"a.glb", glb.substr(0, 100), "damaged glTF"},
      {"a.glb", glb.substr(0, 10), "damaged glTF"},
      {"a.glb", replaced(glb, "BIN", "BIM"), "damaged glTF"},
  };
  for (const Case& bad : cases) {
    const std::string message = refusal(bad.name, bad.content);
    EXPECT_TRUE(contains(message, bad.expected)) << message << "\nexpected " << bad.expected;
    EXPECT_LT(message.size(), 500u);
  }
  std::string out_of_range = gltfBuffer(cube);
  out_of_range[12 * 24] = 99;
  folder.write("range.bin", out_of_range);
  EXPECT_TRUE(contains(refusal("a.gltf", gltfOf(cube, "range.bin")), "index 99 at position 0 of accessor 1"));
  std::string not_finite = gltfBuffer(cube);
  not_finite.replace(24, 4, "\xff\xff\xff\xff");
  folder.write("nan.bin", not_finite);
  EXPECT_TRUE(contains(refusal("a.gltf", gltfOf(cube, "nan.bin")), "vertex 2 is not finite"));
}

}  // namespace
}  // namespace airclay
