// SPDX-License-Identifier: MIT
#include "tests/support/documents.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <random>

#include "engine/clay/presets.h"
#include "engine/clay/refine.h"
#include "engine/core/file_io.h"

namespace airclay {

ClayState tubeState() {
  return {presetCage("tube"), SubdivisionRule::kCatmullClark, 2, &kSolveAll};
}

ClayState afterStroke(ClayState state, int number) {
  std::mt19937_64 random(static_cast<std::uint64_t>(number));
  std::uniform_real_distribution<double> metres(-0.3, 0.3);
  for (Vec3& point : state.cage.points) point = {metres(random), metres(random), metres(random)};
  return state;
}

ClayState largeState() {
  ClayState state;
  constexpr int n = 64;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) state.cage.points.emplace_back(0.01 * x, 0.01 * y, 0);
  for (int y = 0; y + 1 < n; ++y)
    for (int x = 0; x + 1 < n; ++x)
      state.cage.faces.push_back({y * n + x, y * n + x + 1, (y + 1) * n + x + 1, (y + 1) * n + x});
  return state;
}

std::string someDocument(const TemporaryFolder& folder) {
  {
    Document document = Document::create(folder / "whole.clay", tubeState());
    for (int i = 0; i < 6; ++i) document.commit("Push", afterStroke(tubeState(), i));
    document.commit("Refine", refine(document.state()));
    document.undo(2);
  }
  return readWhole(folder / "whole.clay", kMaxDocumentBytes);
}

void alter(const std::filesystem::path& file, const std::string& sql) {
  sqlite3* connection = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &connection), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(connection, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK)
      << sql << ": " << (message ? message : "");
  sqlite3_free(message);
  sqlite3_close(connection);
}

std::vector<std::vector<std::string>> rowsOf(const std::filesystem::path& file, const std::string& sql) {
  sqlite3* connection = nullptr;
  sqlite3_stmt* statement = nullptr;
  EXPECT_EQ(sqlite3_open_v2(file.c_str(), &connection, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_prepare_v2(connection, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sql;
  std::vector<std::vector<std::string>> rows;
  while (sqlite3_step(statement) == SQLITE_ROW) {
    rows.emplace_back();
    for (int column = 0; column < sqlite3_column_count(statement); ++column) {
      const char* bytes = static_cast<const char*>(sqlite3_column_blob(statement, column));
      rows.back().emplace_back(bytes ? bytes : "",
                               static_cast<std::size_t>(bytes ? sqlite3_column_bytes(statement, column) : 0));
    }
  }
  sqlite3_finalize(statement);
  sqlite3_close(connection);
  return rows;
}

std::vector<std::string> namesOf(const Document& document) {
  std::vector<std::string> names;
  for (const HistoryEntry& entry : document.history())
    names.push_back((entry.is_current ? ">" : "") + entry.name);
  return names;
}

void expectOneLine(const std::string& message, const std::filesystem::path& file,
                   const std::string& expected) {
  EXPECT_TRUE(message.starts_with(file.string() + ": ")) << message;
  EXPECT_NE(message.find(expected), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

}  // namespace airclay
