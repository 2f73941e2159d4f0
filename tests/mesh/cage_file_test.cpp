// SPDX-License-Identifier: MIT
// Cages as people have them: what is repaired, hinted at and refused, and that each is reported once.
#include "engine/mesh/cage_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "engine/clay/presets.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

// A cube of 0.2 m, its faces anticlockwise from outside.
const std::string kCubePoints =
    "v 0 0 0\nv .2 0 0\nv .2 .2 0\nv 0 .2 0\nv 0 0 .2\nv .2 0 .2\nv .2 .2 .2\nv 0 .2 .2\n";
const std::vector<std::string> kCubeFaces = {"4 3 2 1", "5 6 7 8", "1 2 6 5",
                                             "2 3 7 6", "3 4 8 7", "4 1 5 8"};

std::string cube() {
  std::string text = kCubePoints;
  for (const std::string& face : kCubeFaces) text += "f " + face + "\n";
  return text;
}

double volumeOf(const PolygonMesh& cage) {
  double volume = 0;
  for (const std::vector<int>& face : cage.faces)
    for (std::size_t k = 2; k < face.size(); ++k)
      volume += cage.points[std::size_t(face[0])].dot(
                    cage.points[std::size_t(face[k - 1])].cross(cage.points[std::size_t(face[k])])) /
                6;
  return volume;
}

struct CageFile : ::testing::Test {
  TemporaryFolder folder;
  CageReading read(const std::string& obj, const CageReadOptions& options = {}) const {
    return readCage(folder.write("cage.obj", obj), options);
  }
  std::string refusal(const std::string& obj) const {
    return messageOf([&] { read(obj); });
  }
};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(CageFile, ReadsAWholeCageWithoutANote) {
  const CageReading reading = read(cube());
  EXPECT_EQ(reading.notes(), std::vector<std::string>());
  EXPECT_EQ(reading.format, "OBJ");
  EXPECT_TRUE(reading.is_closed);
  EXPECT_EQ(reading.cage.points.size(), 8u);
  EXPECT_EQ(reading.cage.faces[1], (std::vector<int>{4, 5, 6, 7}));
  EXPECT_NEAR(volumeOf(reading.cage), 0.008, 1e-12);
}

TEST_F(CageFile, PresetsNeedNoRepair) {
  for (const std::string& name : presetNames()) {
    const PolygonMesh preset = presetCage(name);
    std::string text;
    for (const Vec3& point : preset.points)
      text += "v " + std::to_string(point.x()) + " " + std::to_string(point.y()) + " " +
              std::to_string(point.z()) + "\n";
    for (const std::vector<int>& face : preset.faces) {
      text += "f";
      for (const int corner : face) text += " " + std::to_string(corner + 1);
      text += "\n";
    }
    const CageReading reading = read(text);
    EXPECT_EQ(reading.cage.faces, preset.faces) << name;
    EXPECT_EQ(reading.notes(), std::vector<std::string>()) << name;
  }
}

TEST_F(CageFile, DropsLooseVerticesAndEdges) {
  const CageReading reading =
      read("v 9 9 9\n" + kCubePoints +
           "v 7 7 7\nl 1 10\nl 1 2 3\np 10\nf 5 4 3 2\nf 6 7 8 9\nf 2 3 7 6\nf 3 4 8 7\n"
           "f 4 5 9 8\nf 5 2 6 9\n");
  EXPECT_EQ(reading.cage.points.size(), 8u);
  EXPECT_EQ(reading.cage.points[0], Vec3::Zero());
  EXPECT_EQ(reading.cage.faces[0], (std::vector<int>{3, 2, 1, 0}));
  EXPECT_EQ(reading.notes(), std::vector<std::string>{"dropped 2 vertices and 3 edges without a face"});
}

TEST_F(CageFile, WeldsSeparateQuads) {
  // Six quads of four vertices each, 1e-8 apart at most: far below 1e-6 of 0.2 m.
  const std::vector<std::array<int, 4>> faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                 {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}};
  std::string text;
  for (const auto& face : faces)
    for (const int corner : face) {
      const std::string jitter = face == faces[0] ? "" : "00000001";
      text += std::string("v ") + (corner & 1 ? ".2" : ".0") + jitter + (corner & 2 ? " .2" : " .0") +
              (corner & 4 ? " .2\n" : " .0\n");
    }
  for (int f = 0; f < 6; ++f)
    text += "f " + std::to_string(4 * f + 1) + " " + std::to_string(4 * f + 2) + " " +
            std::to_string(4 * f + 3) + " " + std::to_string(4 * f + 4) + "\n";
  const CageReading reading = read(text);
  EXPECT_EQ(reading.cage.points.size(), 8u);
  EXPECT_EQ(reading.cage.faces.size(), 6u);
  EXPECT_TRUE(reading.is_closed);
  EXPECT_NEAR(volumeOf(reading.cage), 0.008, 1e-8);
  ASSERT_EQ(reading.notes().size(), 1u);
  EXPECT_TRUE(contains(reading.notes()[0], "welded 16 vertices")) << reading.notes()[0];
  EXPECT_TRUE(contains(reading.notes()[0], "8 remain")) << reading.notes()[0];
}

TEST_F(CageFile, WeldsOnlyWithinAMillionthOfTheSize) {
  // The seam of two quads, 2 m wide together: 1.9 um apart is welded, 2.1 um isn't, whichever cell they are
  // in.
  for (const double seam : {0.0, 0.3, 1e-5, 0.7231})
    for (const auto& [gap, points] : {std::pair(1.9e-6, 6u), std::pair(2.1e-6, 8u)}) {
      const std::string left = exactNumber(seam), right = exactNumber(seam + gap);
      const CageReading reading =
          read("v -1 0 0\nv " + left + " 0 0\nv " + left + " 1 0\nv -1 1 0\nv " + right +
               " 0 0\nv 1 0 0\nv 1 1 0\nv " + right + " 1 0\nf 1 2 3 4\nf 5 6 7 8\n");
      EXPECT_EQ(reading.cage.points.size(), points) << seam << " " << gap;
    }
}

TEST_F(CageFile, MakesTheWindingConsistent) {
  // Every subset of the cube's faces flipped gives the same cube, facing outwards.
  for (unsigned turned = 0; turned < 64; ++turned) {
    std::string text = kCubePoints;
    for (std::size_t f = 0; f < 6; ++f) {
      std::string face = kCubeFaces[f];
      if (turned >> f & 1) std::reverse(face.begin(), face.end());
      text += "f " + face + "\n";
    }
    const CageReading reading = read(text);
    EXPECT_NEAR(volumeOf(reading.cage), 0.008, 1e-12) << turned;
    const std::string count = std::to_string(std::popcount(turned));
    if (turned == 0)
      EXPECT_EQ(reading.notes().size(), 0u);
    else
      EXPECT_EQ(reading.notes(),
                std::vector<std::string>{"flipped " + count + " of 6 faces to face outwards"});
  }
}

TEST_F(CageFile, OpenPartsFollowMostOfTheirFaces) {
  const std::string points =
      "v 0 0 0\nv .1 0 0\nv .2 0 0\nv .3 0 0\nv 0 .1 0\nv .1 .1 0\nv .2 .1 0\nv .3 .1 0\n";
  const CageReading reading = read(points + "f 5 6 2 1\nf 2 3 7 6\nf 3 4 8 7\n");
  EXPECT_EQ(reading.notes(), std::vector<std::string>{"flipped 1 of 3 faces to agree with their neighbours"});
  EXPECT_EQ(reading.cage.faces[0], (std::vector<int>{4, 0, 1, 5}));
  EXPECT_EQ(reading.cage.faces[1], (std::vector<int>{1, 2, 6, 5}));
  EXPECT_FALSE(reading.is_closed);
  EXPECT_EQ(read(points + "f 5 6 2 1\nf 6 7 3 2\n").repairs.size(), 1u);  // the vertices without a face alone
}

TEST_F(CageFile, KeepsCavities) {
  std::string hollow = cube();
  for (const char* point : {".05 .05 .05", ".15 .05 .05", ".15 .15 .05", ".05 .15 .05", ".05 .05 .15",
                            ".15 .05 .15", ".15 .15 .15", ".05 .15 .15"})
    hollow += std::string("v ") + point + "\n";
  for (const std::vector<int>& face : read(cube()).cage.faces) {
    hollow += "f";
    for (auto corner = face.rbegin(); corner != face.rend(); ++corner)
      hollow += " " + std::to_string(*corner + 9);
    hollow += "\n";
  }
  const CageReading reading = read(hollow);
  EXPECT_EQ(reading.notes(), std::vector<std::string>());
  EXPECT_NEAR(volumeOf(reading.cage), 0.008 - 0.001, 1e-12);
}

TEST_F(CageFile, RemovesRepeatedCorners) {
  const CageReading reading = read("v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nv 0 0 0\nf 1 2 3 5\nf 1 3 4\n");
  EXPECT_EQ(reading.cage.faces, (std::vector<std::vector<int>>{{0, 1, 2}, {0, 2, 3}}));
  ASSERT_EQ(reading.repairs.size(), 2u);
  EXPECT_EQ(reading.repairs[1], "removed corners that repeat the previous one from 1 face");
}

TEST_F(CageFile, HintsAtTriangles) {
  const CageReading reading =
      read("v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  EXPECT_TRUE(reading.repairs.empty());
  ASSERT_EQ(reading.hints.size(), 1u);
  EXPECT_TRUE(contains(reading.hints[0], "4 of 4 faces are triangles")) << reading.hints[0];
  EXPECT_TRUE(contains(reading.hints[0], "remesh")) << reading.hints[0];
}

TEST_F(CageFile, RefusesWithUpToTenPlaces) {
  struct Case {
    std::string obj;
    std::vector<std::string> parts;
  };
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  std::string book = "v 0 0 0\nv 0 0 1\n";  // twelve edges of three pages, in a row
  for (int i = 0; i < 12; ++i) {
    const std::string x = std::to_string(10 * i);
    book += "v " + x + " 0 0\nv " + x + " 0 1\nv " + x + " 1 0\nv " + x + " -1 0\nv " +
            std::to_string(10 * i + 1) + " 0 0\n";
    for (const char* page : {"-3", "-2", "-1"}) book += std::string("f -5 -4 ") + page + "\n";
  }
  const Case cases[] = {
      {square + "v 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n",
       {"cage.obj: 1 edge has more than two faces: (0, 0, 0) to (1, 0, 0) (line 6, line 7, line 8)"}},
      {book, {"12 edges have more than two faces", "(90, 0, 0) to (90, 0, 1)", "; and 2 more"}},
      {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv -1 0 0\nv -1 -1 0\nf 1 2 3\nf 1 4 5\n",
       {"cage.obj: 1 vertex joins faces that share no edge there (a bow tie): (0, 0, 0)"}},
      {square + "f 1 2 3 4\n\nf 3 4 1 2\nf 4 3 2 1\n",
       {"2 faces have the corners of another: line 7 repeats line 5; line 8 repeats line 5"}},
      {square + "v 2 0 0\nv 3 0 0\nf 1 2 3 4\nf 2 5 6\n", {"1 face has no area: line 8 at (1, 0, 0)"}},
      {square + "f 1 2 3 4\nf 1 2 1\n", {"1 face has no area: line 6"}},
      {square + "v 2 0 0\nv 2 2 0\nf 1 2 3 4\nf 2 5 6 2 6 3\n", {"1 face uses a vertex twice: line 8"}},
  };
  for (const Case& bad : cases) {
    const std::string message = refusal(bad.obj);
    for (const std::string& part : bad.parts) EXPECT_TRUE(contains(message, part)) << message;
    EXPECT_FALSE(contains(message, "\n"));
  }
  const std::string message = refusal(book);
  EXPECT_FALSE(contains(message, "(100, 0, 0)")) << message;  // the eleventh
}

TEST_F(CageFile, RefusesAMoebiusStrip) {
  std::string strip;
  for (int i = 0; i < 8; ++i) {
    const double around = 2 * M_PI * i / 8, turn = M_PI * i / 8;
    for (const double side : {-0.3, 0.3}) {
      const double radius = 1 + side * std::cos(turn);
      strip += "v " + std::to_string(radius * std::cos(around)) + " " +
               std::to_string(radius * std::sin(around)) + " " + std::to_string(side * std::sin(turn)) + "\n";
    }
  }
  for (int i = 0; i < 7; ++i)
    strip += "f " + std::to_string(2 * i + 1) + " " + std::to_string(2 * i + 2) + " " +
             std::to_string(2 * i + 4) + " " + std::to_string(2 * i + 3) + "\n";
  EXPECT_EQ(read(strip).repairs.size(), 0u);  // open so far
  const std::string message = refusal(strip + "f 15 16 1 2\n");
  EXPECT_TRUE(contains(message, "one side only")) << message;
}

TEST_F(CageFile, ReportsAllProblemsAndStillNoCrash) {
  const CageReading reading = inspectCage(folder.write(
      "cage.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 4 3 2 1\nf 1 2 5\nf 1 2 1 2\n"));
  EXPECT_EQ(reading.problems.size(), 2u);  // a duplicate, and two faces without area
}

TEST_F(CageFile, UnitsAndUpAxis) {
  std::string large =
      "v 0 0 0\nv 200 0 0\nv 200 100 0\nv 0 100 0\nv 0 0 -50\nv 200 0 -50\nf 1 2 3 4\nf 2 1 5 6\n";
  CageReadOptions options;
  options.units = LengthUnit::kMillimetre;
  EXPECT_TRUE(read(large, options).cage.points[2].isApprox(Vec3(0.2, 0.1, 0)));
  EXPECT_TRUE(read(large, options).notes().empty());
  options.units = LengthUnit::kInch;
  EXPECT_TRUE(read(large, options).cage.points[1].isApprox(Vec3(5.08, 0, 0)));
  options.units = LengthUnit::kCentimetre;
  options.up = UpAxis::kY;
  EXPECT_TRUE(read(large, options).cage.points[2].isApprox(Vec3(2, 0, 1)));
  EXPECT_TRUE(read(large, options).cage.points[4].isApprox(Vec3(0, 0.5, 0)));
}

TEST_F(CageFile, HintsAtImplausibleSizes) {
  struct Case {
    double size;
    std::string expected;  // empty: no hint
  };
  const Case cases[] = {
      {0.6, ""},
      {1.9, ""},
      {0.006, ""},
      {200, "its longest side is 200 m if its numbers are in m; they look like mm (0.2 m): --units mm"},
      {20, "cm (0.2 m): --units cm"},
      {8, "cm (0.08 m): --units cm"},
      {600, "mm (0.6 m): --units mm"},
      {1e5, "--units names another unit"},
      {0.0002, "0.2 mm"}};
  for (const Case& one : cases) {
    const std::string size = std::to_string(one.size);
    const CageReading reading =
        read("v 0 0 0\nv " + size + " 0 0\nv " + size + " " + size + " 0\nv 0 " + size + " 0\nf 1 2 3 4\n");
    EXPECT_EQ(reading.hints.size(), one.expected.empty() ? 0u : 1u) << size;
    if (reading.hints.empty()) continue;
    EXPECT_TRUE(contains(reading.hints[0], one.expected)) << reading.hints[0];
  }
  CageReadOptions options;
  options.units = LengthUnit::kMetre;  // stated: no hint
  EXPECT_TRUE(read("v 0 0 0\nv 200 0 0\nv 200 200 0\nv 0 200 0\nf 1 2 3 4\n", options).hints.empty());
}

TEST_F(CageFile, RefusesCoordinatesWithTheLine) {
  EXPECT_TRUE(
      contains(refusal("v 0 0 0\nv nan 0 0\n"), "cage.obj:2: coordinate 'nan' is not a finite number"));
  EXPECT_TRUE(
      contains(refusal("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n"), "vertex 2 is more than 1,000 km"));
}

TEST_F(CageFile, ExtensionsInAnyCase) {
  EXPECT_EQ(readCage(folder.write("CAGE.OBJ", cube())).cage.points.size(), 8u);
  EXPECT_TRUE(isCageFile("a.Obj"));
  EXPECT_FALSE(isCageFile("obj"));
  try {
    readCage(folder.write("cage.fbx", cube()));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    for (const std::string& extension : cageExtensions()) EXPECT_TRUE(contains(error.what(), extension));
  }
}

TEST_F(CageFile, FilesWithUnusualNames) {
  for (const char* name :
       {"my cage #2.obj", "Töpfchen.obj", "粘土.OBJ", "a\"b'c;.obj", "50%20.obj", "-x.obj"}) {
    EXPECT_EQ(readCage(folder.write(name, cube())).cage.points.size(), 8u) << name;
    EXPECT_TRUE(contains(messageOf([&] { readCage(folder.write(name, "f 1 2 3\n")); }), name));
  }
  EXPECT_TRUE(contains(messageOf([&] { readCage(folder / "none.obj"); }), "none.obj: cannot be read"));
  std::filesystem::create_directory(folder / "folder.obj");
  EXPECT_TRUE(contains(messageOf([&] { readCage(folder / "folder.obj"); }), "folder.obj: cannot be read"));
  std::filesystem::create_symlink("loop.obj", folder / "loop.obj");
  EXPECT_TRUE(contains(messageOf([&] { readCage(folder / "loop.obj"); }), "loop.obj: cannot be read"));
}

TEST_F(CageFile, PresetsHaveNoUnits) {
  CageReadOptions options;
  options.units = LengthUnit::kMillimetre;
  EXPECT_EQ(loadCage("ball").cage.faces, presetCage("ball").faces);
  EXPECT_THROW(loadCage("ball", options), Error);
  EXPECT_TRUE(contains(messageOf([] { loadCage("bell"); }), "no clay preset 'bell'"));
  EXPECT_EQ(loadCage(folder.write("cage.obj", cube())).cage.points.size(), 8u);
}

}  // namespace
}  // namespace airclay
