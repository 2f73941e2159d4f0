// SPDX-License-Identifier: MIT
// Checks the documentation: links resolve, named files exist, and the command reference equals the
// program's output.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

#include "tests/support/program.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = AIRCLAY_SOURCE;

std::vector<fs::path> documents() {
  std::vector<fs::path> files;
  const auto add = [&](const fs::directory_entry& entry) {
    if (entry.path().extension() == ".md") files.push_back(entry.path());
  };
  for (const fs::directory_entry& entry : fs::directory_iterator(kSource)) add(entry);
  for (const char* top : {"app", "capture", "engine", "shaders", "tests", "third_party"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kSource / top)) add(entry);
  return files;
}

/// All matches of the expression's first group.
std::vector<std::string> findAll(const std::string& text, const std::regex& expression) {
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), expression), end; at != end; ++at)
    found.push_back((*at)[1]);
  return found;
}

/// The anchor that GitHub generates for a heading: lower case, spaces become dashes, punctuation is dropped.
std::string anchorOf(const std::string& heading) {
  std::string anchor;
  for (const unsigned char c : heading) {
    if (std::isalnum(c) || c == '-' || c == '_' || c >= 0x80) anchor += static_cast<char>(std::tolower(c));
    if (c == ' ') anchor += '-';
  }
  return anchor;
}

bool hasAnchor(const std::string& markdown, const std::string& anchor) {
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("#"))
      if (const std::size_t text = line.find_first_not_of("# ");
          text != std::string::npos && anchorOf(line.substr(text)) == anchor)
        return true;
  return false;
}

TEST(Docs, LinksResolve) {
  static const std::regex kLink(R"re(\]\(([^)\s]+)\))re");
  std::size_t checked = 0;
  for (const fs::path& file : documents()) {
    const std::string text = contentOf(file);
    for (const std::string& link : findAll(text, kLink)) {
      if (link.find("://") != std::string::npos) continue;
      const std::size_t hash = link.find('#');
      const fs::path target = hash == 0 ? file : file.parent_path() / link.substr(0, hash);
      EXPECT_TRUE(fs::exists(target)) << file << ": " << link;
      if (hash != std::string::npos && fs::exists(target)) {
        EXPECT_TRUE(hasAnchor(contentOf(target), link.substr(hash + 1))) << file << ": " << link;
      }
      ++checked;
    }
  }
  EXPECT_GE(checked, 60u);
}

/// `engine/hull/carve.cpp`, also with a wildcard such as `carve*.comp`, or a folder.
TEST(Docs, NamedFilesExist) {
  static const std::regex kPath(
      R"re(`((?:app|capture|engine|shaders|tests|third_party|\.ci|\.github)/[A-Za-z0-9_./*-]*)`)re");
  std::size_t checked = 0;
  for (const fs::path& file : documents()) {
    if (file.filename() == "CHANGELOG.md") continue;  // names former files
    for (const std::string& path : findAll(contentOf(file), kPath)) {
      const fs::path name = fs::path(path).filename(), folder = kSource / fs::path(path).parent_path();
      bool found = fs::exists(kSource / path);
      if (const std::size_t star = path.find('*'); star != std::string::npos && fs::exists(folder)) {
        const std::string before = name.string().substr(0, name.string().find('*')),
                          after = name.string().substr(name.string().find('*') + 1);
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
          const std::string candidate = entry.path().filename();
          found |= candidate.starts_with(before) && candidate.ends_with(after);
        }
      }
      EXPECT_TRUE(found) << file << ": " << path;
      ++checked;
    }
  }
  EXPECT_GE(checked, 60u);
}

TEST(Docs, CommandReferenceIsUpToDate) {
  const RunResult result = runAirclay({"reference", "markdown"});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(result.output == contentOf(kSource / "app/docs/commands.md"))
      << "app/docs/commands.md is out of date; run\n"
         "    build/release/airclay reference markdown > app/docs/commands.md";
}

TEST(Docs, ReadmeNamesTheTwoCommands) {
  const std::string readme = contentOf(kSource / "README.md");
  EXPECT_NE(readme.find("./airclay demo"), std::string::npos);
  EXPECT_NE(readme.find("./airclay test"), std::string::npos);
}

}  // namespace
}  // namespace airclay
