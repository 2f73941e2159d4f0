// SPDX-License-Identifier: MIT
// `airclay new`, `history`, `undo`, `redo` and `refine`, as a user runs them.
#include <gtest/gtest.h>

#include <ctime>
#include <nlohmann/json.hpp>

#include "engine/clay/document.h"
#include "engine/clay/presets.h"
#include "engine/clay/refine.h"
#include "tests/support/documents.h"
#include "tests/support/program.h"

namespace airclay {
namespace {

using nlohmann::json;
using Strings = std::vector<std::string>;

/// The run fails with one line that contains `expected`, and prints nothing else.
void expectRefused(const Strings& arguments, int status, const std::string& expected) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, status);
  EXPECT_EQ(result.output, "");
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
}

/// The output of a run that must succeed.
std::string outputOf(const Strings& arguments) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors, "");
  return result.output;
}

json historyOf(const std::string& file) {
  return json::parse(outputOf({"history", file, "--json"}));
}

TEST(DocumentApp, EveryCommandHasHelp) {
  const std::string list = outputOf({"--help"});
  for (const char* command : {"new", "history", "undo", "redo", "refine", "set", "turn"}) {
    EXPECT_NE(outputOf({command, "--help"}).find(std::string("airclay ") + command), std::string::npos);
    EXPECT_NE(list.find(std::string("\n  ") + command), std::string::npos) << command;
  }
}

TEST(DocumentApp, NewStoresItsOptions) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.clay";
  const std::string report = outputOf({"new", file});
  EXPECT_NE(report.find("28 control points, 364 data points"), std::string::npos) << report;
  EXPECT_TRUE(sameClay(Document::open(file).state(), tubeState()));

  const std::string other = folder / "b.clay";
  EXPECT_EQ(outputOf({"new", other, "--clay", "vase", "--levels", "1", "--rule", "printed", "--solve",
                      "touched", "--quiet"}),
            "");
  const ClayState vase{presetCage("vase"), SubdivisionRule::kPrinted, 1, &kSolveTouched};
  EXPECT_TRUE(sameClay(Document::open(other).state(), vase));

  const std::string cage = folder.write("cage.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf 1 2 3 4\n");
  outputOf({"new", folder / "c.clay", "--clay", cage});
  EXPECT_EQ(Document::open(folder / "c.clay").state().cage.points[3], Vec3(0, 1, 0.5));
}

TEST(DocumentApp, FailedNewLeavesNoFile) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.clay";
  expectRefused({"new"}, 2, "FILE");
  expectRefused({"new", folder / "a.obj"}, 2, "a document's name ends in .clay");
  expectRefused({"new", file, "--clay", "teapot"}, 1, "there is no clay preset 'teapot'");
  expectRefused({"new", file, "--levels", "0"}, 1, "level 0 must be 1 to 15");
  expectRefused({"new", file, "--levels", "14"}, 1, "use a lower level");
  expectRefused({"new", file, "--rule", "loop"}, 2, "--rule");
  expectRefused({"new", folder / "none" / "a.clay"}, 1, "cannot be written");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  outputOf({"new", file});
  expectRefused({"new", file}, 1, file + ": already exists");
}

TEST(DocumentApp, HistoryListsTheEdits) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.clay", someDocument(folder));
  const json history = historyOf(file);
  ASSERT_EQ(history["entries"].size(), 8u);
  EXPECT_EQ(history["entries"][0]["name"], "New");
  EXPECT_EQ(history["entries"][7]["name"], "Refine");
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(history["entries"][i]["current"], i == 5);
  EXPECT_NEAR(history["entries"][7]["unix_time_s"].get<double>(), double(std::time(nullptr)), 60);
  EXPECT_EQ(history["undo"], 5);
  EXPECT_EQ(history["redo"], 2);
  EXPECT_EQ(history["control_points"], 28);
  EXPECT_EQ(history["levels"], 2);
  EXPECT_EQ(history["rule"], "catmull-clark");
  EXPECT_EQ(history["solve"], "all");

  const std::string table = outputOf({"history", file});
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 9) << table;
  const std::size_t now = table.find("<- now");
  ASSERT_NE(now, std::string::npos) << table;
  EXPECT_EQ(table[table.rfind('\n', now) + 4], '5') << table;
}

// A foreign document: no byte of a name may reach the terminal as a control character.
TEST(DocumentApp, HistoryShowsUnusualNamesInOneLine) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.clay", someDocument(folder));
  alter(file, "UPDATE entry SET name = 'a' || char(10) || char(27) || '[2J' WHERE id = 2");
  const std::string table = outputOf({"history", file});
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 9) << table;
  EXPECT_EQ(table.find('\x1b'), std::string::npos) << table;
  alter(file,
        "UPDATE entry SET name = CAST(x'80ff' AS TEXT), unix_time_s = 9223372036854775807 WHERE id = 2");
  EXPECT_EQ(historyOf(file)["entries"].size(), 8u);
  EXPECT_NE(outputOf({"history", file}).find("unknown"), std::string::npos);
}

TEST(DocumentApp, UndoAndRedoMoveThroughTheHistory) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.clay", someDocument(folder));
  const std::string report = outputOf({"undo", file});
  EXPECT_NE(report.find("Push undone; 4 to undo, 3 to redo"), std::string::npos) << report;
  EXPECT_TRUE(sameClay(Document::open(file).state(), afterStroke(tubeState(), 3)));
  outputOf({"undo", file, "--count", "4"});
  EXPECT_TRUE(sameClay(Document::open(file).state(), tubeState()));
  expectRefused({"undo", file}, 1, "there is nothing to undo");
  expectRefused({"redo", file, "--count", "8"}, 1, "8 edits cannot be redone; there are 7 to redo");
  expectRefused({"redo", file, "--count", "0"}, 2, "--count");
  EXPECT_TRUE(sameClay(Document::open(file).state(), tubeState()));
  const std::string redone = outputOf({"redo", file, "--count", "7"});
  EXPECT_NE(redone.find("7 edits redone; 7 to undo, 0 to redo"), std::string::npos) << redone;
  EXPECT_TRUE(sameClay(Document::open(file).state(), refine(afterStroke(tubeState(), 5))));
}

TEST(DocumentApp, RefineIsAnEdit) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.clay";
  outputOf({"new", file});
  const std::string report = outputOf({"refine", file});
  EXPECT_NE(report.find("98 control points at level 1, from 28 at level 2; the surface is the same"),
            std::string::npos)
      << report;
  EXPECT_TRUE(sameClay(Document::open(file).state(), refine(tubeState())));
  EXPECT_EQ(historyOf(file)["entries"][1]["name"], "Refine");
  const std::string finer = outputOf({"refine", file});
  EXPECT_NE(finer.find("364 control points at level 1, from 98 at level 1; the surface is one level finer"),
            std::string::npos)
      << finer;
  outputOf({"refine", file});
  expectRefused({"refine", file}, 1, file + ": refining turns");
  EXPECT_EQ(historyOf(file)["undo"], 3);
  outputOf({"undo", file, "--count", "3"});
  EXPECT_TRUE(sameClay(Document::open(file).state(), tubeState()));
}

TEST(DocumentApp, SetChangesOnlyTheGivenOptions) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.clay";
  outputOf({"new", file});
  ClayState expected = tubeState();
  expected.levels = 3;
  expected.solve = &kSolveTouched;
  outputOf({"set", file, "--levels", "3", "--solve", "touched"});
  EXPECT_TRUE(sameClay(Document::open(file).state(), expected));
  expected.cage = presetCage("ball");
  outputOf({"set", file, "--clay", "ball"});
  EXPECT_TRUE(sameClay(Document::open(file).state(), expected));
  const json history = historyOf(file);
  EXPECT_EQ(history["entries"][1]["name"], "Level 3");
  EXPECT_EQ(history["entries"][2]["name"], "Import ball");
  expectRefused({"set", file}, 2, "nothing to change");
  expectRefused({"set", file, "--levels", "15"}, 1, "");
  EXPECT_TRUE(sameClay(Document::open(file).state(), expected));
}

TEST(DocumentApp, TurnIsARotation) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.clay";
  outputOf({"new", file});
  outputOf({"turn", file, "--axis", "z", "--degrees", "90"});
  const ClayState turned = Document::open(file).state();
  const PolygonMesh tube = tubeState().cage;
  for (std::size_t i = 0; i < tube.points.size(); ++i) {
    const Vec3& p = tube.points[i];
    EXPECT_LT((turned.cage.points[i] - Vec3(-p.y(), p.x(), p.z())).norm(), 1e-12);
  }
  EXPECT_LT((turned.workspace_from_clay * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12)
      << "the planes rotate, too";
  for (const int degrees : {-40, -50})
    outputOf({"turn", file, "--axis", "z", "--degrees", std::to_string(degrees)});
  const ClayState back = Document::open(file).state();
  for (std::size_t i = 0; i < tube.points.size(); ++i)
    EXPECT_LT((back.cage.points[i] - tube.points[i]).norm(), 1e-12);
  outputOf({"turn", file, "--axis", "x", "--degrees", "180", "--about", "0.1,0.2,0.3"});
  const ClayState upside_down = Document::open(file).state();
  for (std::size_t i = 0; i < tube.points.size(); ++i) {
    const Vec3& p = tube.points[i];
    EXPECT_LT((upside_down.cage.points[i] - Vec3(p.x(), 0.4 - p.y(), 0.6 - p.z())).norm(), 1e-12);
  }
  expectRefused({"turn", file, "--axis", "w", "--degrees", "90"}, 2, "--axis");
  expectRefused({"turn", file, "--axis", "x"}, 2, "--degrees");
}

TEST(DocumentApp, RejectsOtherFiles) {
  const TemporaryFolder folder;
  const std::string letter = folder.write("letter.clay", std::string(2000, 'x'));
  for (const char* command : {"history", "undo", "redo", "refine", "set"}) {
    expectRefused({command, letter}, 1, letter + ": is not an Airclay document");
    expectRefused({command, folder / "none.clay"}, 1, "there is no such file");
  }
  const std::string file = folder / "a.clay";
  const Document document = Document::create(file, tubeState());
  expectRefused({"undo", file}, 1, "is open in another window or program");
}

}  // namespace
}  // namespace airclay
