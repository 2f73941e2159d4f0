// SPDX-License-Identifier: MIT
// The folders' dependency order (AIRCLAY_LAYERS in CMakeLists.txt), checked against every #include.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

namespace airclay {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = AIRCLAY_SOURCE;

/// Each layer's position in the dependency order.
std::map<std::string, int> layers() {
  std::map<std::string, int> positions;
  std::istringstream list(AIRCLAY_LAYERS);
  for (std::string layer; list >> layer;) positions.emplace(layer, static_cast<int>(positions.size()));
  return positions;
}

bool isSource(const fs::path& file) {
  static const std::vector<std::string> endings = {".h", ".cpp", ".comp", ".vert", ".frag", ".glsl"};
  return std::find(endings.begin(), endings.end(), file.extension()) != endings.end();
}

/// `file` relative to the source folder, '/' between folders.
std::string sourcePath(const fs::path& file) {
  return file.lexically_relative(kSource).generic_string();
}

std::vector<fs::path> sources() {
  std::vector<fs::path> files;
  for (const char* top : {"shaders", "engine", "capture", "app"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kSource / top))
      if (isSource(entry.path()) && !sourcePath(entry.path()).starts_with("app/examples"))
        files.push_back(entry.path());
  return files;
}

/// The project headers that `file` includes, as paths from the source folder.
std::vector<std::string> includesOf(const fs::path& file) {
  static const std::regex kInclude(
      R"re(^\s*#\s*include\s+["<]((?:shaders|engine|capture|app)/[^">]+)[">])re");
  std::vector<std::string> includes;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (std::smatch match; std::regex_search(line, match, kInclude)) includes.push_back(match[1]);
  return includes;
}

std::string folderOf(const std::string& file) {
  return fs::path(file).parent_path().generic_string();
}

TEST(Layers, EveryFolderIsInTheOrder) {
  const std::map<std::string, int> order = layers();
  ASSERT_GE(sources().size(), 300u);
  for (const fs::path& file : sources())
    EXPECT_TRUE(order.contains(folderOf(sourcePath(file))))
        << sourcePath(file) << ": its folder is not in AIRCLAY_LAYERS";
}

TEST(Layers, FoldersIncludeOnlyEarlierFolders) {
  const std::map<std::string, int> order = layers();
  std::size_t checked = 0;
  for (const fs::path& file : sources()) {
    for (const std::string& include : includesOf(file)) {
      const auto from = order.find(folderOf(sourcePath(file)));
      const auto to = order.find(folderOf(include));
      ASSERT_TRUE(from != order.end() && to != order.end()) << sourcePath(file) << " includes " << include;
      EXPECT_LE(to->second, from->second) << sourcePath(file) << " includes " << include << ", a later layer";
      ++checked;
    }
  }
  EXPECT_GE(checked, 800u);
}

TEST(Layers, TestsHaveTheSameSubjects) {
  const std::map<std::string, int> order = layers();
  for (const fs::directory_entry& entry : fs::directory_iterator(kSource / "tests")) {
    if (!entry.is_directory()) continue;
    const std::string subject = entry.path().filename();
    const bool known = subject == "support" || order.contains("engine/" + subject) ||
                       order.contains("capture/" + subject) || order.contains("app/" + subject);
    EXPECT_TRUE(known) << "tests/" << subject << " is no subject of engine/, capture/ or app/";
  }
}

}  // namespace
}  // namespace airclay
