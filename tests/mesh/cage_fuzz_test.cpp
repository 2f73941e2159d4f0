// SPDX-License-Identifier: MIT
// Damaged mesh files of every format: each is read or refused by an Error.
#include <gtest/gtest.h>

#include <random>

#include "engine/core/error.h"
#include "engine/mesh/cage_file.h"
#include "engine/mesh/mesh_source.h"
#include "tests/support/cage_files.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// Parses without a file on disk.
MeshSource parse(const std::string& name, const std::string& bytes) {
  const MeshFileContent content{name, bytes};
  if (name.ends_with(".ply")) return parsePly(content);
  if (name.ends_with(".stl")) return parseStl(content);
  if (name.ends_with(".obj")) return parseObj(content, RepeatedCorners::kKeep);
  return parseGltf(content, {});
}

/// Whether it was parsed; whatever its shape, it is then inspected as well.
bool tryToRead(const TemporaryFolder& folder, const std::string& name, const std::string& bytes) {
  try {
    const MeshSource source = parse(name, bytes);
    EXPECT_FALSE(source.faces.empty());
    // No memory without a byte that justifies it.
    EXPECT_LE(source.points.size(), bytes.size());
    EXPECT_LE(source.faces.size(), bytes.size());
    for (const Vec3& point : source.points) EXPECT_TRUE(point.allFinite());
    for (const std::vector<int>& face : source.faces)
      for (const int corner : face) {
        EXPECT_GE(corner, 0);
        EXPECT_LT(std::size_t(corner), source.points.size());
      }
    try {
      inspectCage(folder.write(name, bytes));
    } catch (const Error& error) {  // too far from the origin
      EXPECT_NE(std::string(error.what()).find("1,000 km"), std::string::npos) << error.what();
    }
    return true;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.find(name), 0u) << message;
    return false;
  }
}

TEST(CageFuzz, TruncatedFiles) {
  const TemporaryFolder folder;
  for (const auto& [name, whole] : cageFiles(cubeCage(0.2))) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(tryToRead(folder, name, whole));
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 400);
    for (std::size_t size = 0; size < whole.size(); size += step)
      tryToRead(folder, name, whole.substr(0, size));
  }
}

TEST(CageFuzz, FlippedBytes) {
  const TemporaryFolder folder;
  for (const auto& [name, whole] : cageFiles(cubeCage(0.2))) {
    SCOPED_TRACE(name);
    std::mt19937 random(12);
    int read = 0;
    for (int variant = 0; variant < 300; ++variant) {
      std::string bytes = whole;
      const int flips = 1 + int(random() % 4);
      for (int f = 0; f < flips; ++f) bytes[random() % bytes.size()] = char(random());
      read += tryToRead(folder, name, bytes);
    }
    EXPECT_GT(read, 0);
    EXPECT_LT(read, 300);
  }
}

TEST(CageFuzz, RemovedAndRepeatedBlocks) {
  const TemporaryFolder folder;
  for (const auto& [name, whole] : cageFiles(cubeCage(0.2))) {
    SCOPED_TRACE(name);
    std::mt19937 random(7);
    for (int variant = 0; variant < 300; ++variant) {
      const std::size_t at = random() % whole.size(), count = 1 + random() % 40;
      std::string bytes = whole;
      if (variant % 2 == 0)
        bytes.erase(at, count);
      else
        bytes.insert(at, whole.substr(random() % whole.size(), count));
      tryToRead(folder, name, bytes);
    }
  }
}

}  // namespace
}  // namespace airclay
