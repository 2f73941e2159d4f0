// SPDX-License-Identifier: MIT
// Mesh files: valid and invalid ones, the place that errors name, and atomic writing.
#include "engine/mesh/mesh_file.h"
#include "engine/core/file_io.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "engine/core/error.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

class MeshFile : public ::testing::Test {
 protected:
  std::filesystem::path put(const std::string& content) const {
    const std::filesystem::path file = folder_ / "cage.obj";
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  PolygonMesh read(const std::string& content) const { return readObj(put(content)); }
  std::string errorOf(const std::string& content) const {
    try {
      read(content);
    } catch (const Error& error) {
      return error.what();
    }
    return "(none)";
  }
  static std::string contentOf(const std::filesystem::path& file) {
    std::ostringstream content;
    content << std::ifstream(file, std::ios::binary).rdbuf();
    return content.str();
  }

  TemporaryFolder folder_;
};

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST_F(MeshFile, ReadsPolygonsInFileOrder) {
  const PolygonMesh mesh = read(kSquare + "v 2 0 0\nv 2 1 0\nf 2 5 6 3\nf 1 2 3 4\n");
  ASSERT_EQ(mesh.points.size(), 6u);
  EXPECT_EQ(mesh.points[4], Vec3(2, 0, 0));
  EXPECT_EQ(mesh.faces, (std::vector<std::vector<int>>{{1, 4, 5, 2}, {0, 1, 2, 3}}));
}

TEST_F(MeshFile, ReadsEveryCornerAndLineSyntax) {
  const std::vector<std::vector<int>> square = {{0, 1, 2, 3}};
  EXPECT_EQ(read(kSquare + "f 1/1 2/2 3/3 4/4\n").faces, square);
  EXPECT_EQ(read(kSquare + "f 1//1 2//1 3//1 4//1\n").faces, square);
  EXPECT_EQ(read(kSquare + "f 1/5/1 2/6/1 3/7/1 4/8/-1\n").faces, square);
  EXPECT_EQ(read(kSquare + "f -4 -3 -2 -1\n").faces, square);
  EXPECT_EQ(read("f 1 2 3 4\n" + kSquare).faces, square);
  EXPECT_EQ(read(kSquare + "f 1 2 \\\n 3 4").faces, square);
  EXPECT_EQ(read(kSquare + "f 1 2 \\\r\n 3 4\r\n").faces, square);
  EXPECT_EQ(read(kSquare + "# C:\\models\\\nf 1 2 3 4 # all of it\n").faces, square);
  EXPECT_EQ(
      read("\xEF\xBB\xBFo x\nmtllib a.mtl\ng y\ns off\nvt 0 0\nvn 0 0 1\n" + kSquare + "\tf  1 2\t3 4 \n")
          .faces,
      square);
}

TEST_F(MeshFile, KeepsDoublePrecision) {
  const PolygonMesh mesh = read("v 0.1234567890123 +1e-3 -2.5E2 1.0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(mesh.points[0], Vec3(0.1234567890123, 1e-3, -250));
}

TEST_F(MeshFile, ErrorsNameFileAndLine) {
  struct Case {
    std::string content, place, what;
  };
  const Case cases[] = {
      {"", "cage.obj:", "no vertices"},
      {kSquare, "cage.obj:", "no faces"},
      {kSquare + "f 1 2 3 9\n", "cage.obj:5:", "out of range"},
      {kSquare + "f 1 2 3 -5\n", "cage.obj:5:", "out of range"},
      {kSquare + "f 0 1 2\n", "cage.obj:5:", "out of range"},
      {kSquare + "f 1 2 99999999999999999999\n", "cage.obj:5:", "out of range"},
      {kSquare + "f 1 2\n", "cage.obj:5:", "three or more"},
      {kSquare + "\n#\nf 1 2 3 2\n", "cage.obj:7:", "vertex 2 twice"},
      {kSquare + "f 1 2 x\n", "cage.obj:5:", "'x'"},
      {kSquare + "f 1 2 3.5\n", "cage.obj:5:", "'3.5'"},
      {"v 0 0 nan\n", "cage.obj:1:", "'nan'"},
      {"v 0 0 0\nv 0 inf 0\n", "cage.obj:2:", "'inf'"},
      {"v 0 0 1e999\n", "cage.obj:1:", "'1e999'"},
      {"v 0 0,5 0\n", "cage.obj:1:", "'0,5'"},
      {"v 0 0\n", "cage.obj:1:", "2 coordinates"},
      {"v 0 \\\n 0 \\\n q\n", "cage.obj:1:", "'q'"},
  };
  for (const Case& bad : cases) {
    const std::string message = errorOf(bad.content);
    EXPECT_NE(message.find(bad.place), std::string::npos) << message;
    EXPECT_NE(message.find(bad.what), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST_F(MeshFile, RejectsNonManifoldMeshes) {
  const std::string points = kSquare + "v 0 0 1\nv 1 0 1\nv 0 0 -1\n";
  const std::string fin = errorOf(kSquare + "v 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  EXPECT_NE(fin.find("points 1 and 2"), std::string::npos) << fin;
  EXPECT_NE(fin.find("more than two faces"), std::string::npos) << fin;
  const std::string turned = errorOf(kSquare + "v 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 3 6 5\n");
  EXPECT_NE(turned.find("points 2 and 3"), std::string::npos) << turned;
  EXPECT_NE(turned.find("opposite orientation"), std::string::npos) << turned;
  const std::string fans = errorOf("v 0 0 0\nv 1 0 0\nv 1 1 0\nv -1 0 0\nv -1 -1 0\nf 1 2 3\nf 1 4 5\n");
  EXPECT_NE(fans.find("point 1 "), std::string::npos) << fans;
  EXPECT_NE(fans.find("fans"), std::string::npos) << fans;
  const std::string lonely = errorOf(kSquare + "v 5 5 5\nf 1 2 3 4\n");
  EXPECT_NE(lonely.find("point 5 has no face"), std::string::npos) << lonely;
}

TEST_F(MeshFile, AcceptsOpenAndClosedManifolds) {
  EXPECT_EQ(read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n").faces.size(),
            4u);
  // An open fan whose faces come in another order.
  EXPECT_EQ(read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 1 0\nf 1 2 3\nf 1 4 5\nf 1 3 4\n").faces.size(),
            3u);
}

TEST_F(MeshFile, LimitsFileSize) {
  const std::filesystem::path file = put("0123456789");
  EXPECT_EQ(readWhole(file, 10), "0123456789");
  EXPECT_THROW(readWhole(file, 9), Error);
  EXPECT_THROW(readWhole("/dev/zero", 1 << 20), Error);
  EXPECT_THROW(readObj(folder_.path()), Error);
  EXPECT_THROW(readObj(folder_ / "none.obj"), Error);
}

TEST_F(MeshFile, WritesNineSignificantDigits) {
  PolygonMesh mesh;
  mesh.points = {{1.0 / 3, -2.0 / 3e7, 12345678.987}, {1, 0, 0}, {0, 1, 0}, {0.1, 1, 1}};
  mesh.faces = {{0, 1, 2}, {2, 1, 3}};
  const std::filesystem::path file = folder_ / "out.obj";
  writeObj(file, mesh);
  EXPECT_EQ(contentOf(file).substr(0, contentOf(file).find('\n')), "v 0.333333333 -6.66666667e-08 12345679");
  const PolygonMesh read_back = readObj(file);
  EXPECT_EQ(read_back.faces, mesh.faces);
  for (size_t i = 0; i < mesh.points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(read_back.points[i][axis], mesh.points[i][axis], 5e-9 * std::abs(mesh.points[i][axis]));
}

TEST_F(MeshFile, WritesPly) {
  const std::filesystem::path file = folder_ / "out.ply";
  writePly(file, {{1, 2, 3}, {-0.5f, 0, 1e-9f}});
  const std::string content = contentOf(file);
  const std::string end = "end_header\n";
  const size_t data = content.find(end) + end.size();
  EXPECT_EQ(content.rfind("ply\nformat binary_little_endian 1.0\nelement vertex 2\n", 0), 0u);
  ASSERT_EQ(content.size(), data + 24);
  float values[6];
  std::memcpy(values, content.data() + data, sizeof values);
  const float expected[6] = {1, 2, 3, -0.5f, 0, 1e-9f};
  for (int i = 0; i < 6; ++i) EXPECT_EQ(values[i], expected[i]);
}

TEST_F(MeshFile, WritesWholeFilesOrNone) {
  const std::filesystem::path file = put("old");
  writeWhole(file, "new");
  EXPECT_EQ(contentOf(file), "new");
  std::filesystem::create_symlink(file, folder_ / "link");
  writeWhole(folder_ / "link", "newer");
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link"));
  EXPECT_EQ(contentOf(file), "newer");

  EXPECT_THROW(writeWhole(folder_.path(), "x"), Error);
  EXPECT_THROW(writeWhole(folder_ / "missing" / "out.obj", "x"), Error);
  EXPECT_THROW(writeWhole(file / "out.obj", "x"), Error);
  EXPECT_THROW(writeWhole("/dev/full", "x"), Error);  // a full disk
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  int entries = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) entries += entry.exists();
  EXPECT_EQ(entries, 2);  // no temporary file remains
}

}  // namespace
}  // namespace airclay
