// SPDX-License-Identifier: MIT
// Recorded sessions replayed: the same clay, bit for bit. The recordings are made by the program
// itself, run as users run it (with a window: tests/studio/studio_test.cpp).
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/takes/take.h"
#include "engine/clay/presets.h"
#include "engine/mesh/mesh_file.h"
#include "engine/synthetic/demo_scene.h"
#include "tests/support/documents.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/program.h"
#include "tests/support/small_take.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

class RecordingApp : public testing::Test {
 protected:
  std::string at(const std::string& name) const { return folder / name; }

  RunResult run(const Strings& arguments) const {
    const RunResult result = runAirclay(arguments, {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
    EXPECT_EQ(result.status, 0) << result.errors;
    return result;
  }
  /// Cage and surface as the run wrote them.
  std::string clayIn(const std::string& out) const {
    const std::string clay =
        contentOf(folder / (out + "/cage.obj")) + contentOf(folder / (out + "/surface.obj"));
    EXPECT_FALSE(clay.empty());
    return clay;
  }
  /// The same run as `airclay sculpt take`, recorded into `name`.
  void record(const std::string& name, const Strings& more = {}) {
    Strings arguments = {"sculpt", at("take"),        "--headless", "--record",        at(name),
                         "--out",  at(name + "-out"), "--save",     at(name + ".clay")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run(arguments).errors, "");
  }
  RunResult replay(const std::string& name) {
    return run(
        {"sculpt", at(name), "--headless", "--out", at(name + "-again"), "--save", at(name + "-again.clay")});
  }
  void expectSame(const std::string& name) const {
    EXPECT_EQ(clayIn(name + "-out"), clayIn(name + "-again"));
    EXPECT_EQ(contentOf(folder / (name + "-out/poses.tum")), contentOf(folder / (name + "-again/poses.tum")));
    const Document once = Document::open(at(name + ".clay")),
                   again = Document::open(at(name + "-again.clay"));
    EXPECT_TRUE(sameClay(once.state(), again.state()));
    EXPECT_EQ(namesOf(once), namesOf(again));
  }

  TemporaryFolder folder;
};

TEST_F(RecordingApp, ReplayReproducesRecordedClay) {
  writeSmallTake(folder / "take");
  // all settings that a replay must restore
  record("push");
  EXPECT_EQ(replay("push").errors, "");
  expectSame("push");
  EXPECT_NE(contentOf(folder / "push-out/cage.obj"), "");
  const PolygonMesh cage = readObj(folder / "push-out/cage.obj"), tube = presetCage("tube");
  double moved_m = 0;
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    moved_m = std::max(moved_m, (cage.points[i] - tube.points[i]).norm());
  EXPECT_GT(moved_m, 0.005);

  record("smooth", {"--tool", "smooth", "--symmetry", "xz", "--no-filter", "--clay", "ball", "--size", "0.2",
                    "--levels", "3", "--rule", "printed", "--voxels", "64"});
  EXPECT_EQ(replay("smooth").errors, "");
  expectSame("smooth");
  EXPECT_NE(clayIn("smooth-out"), clayIn("push-out"));
}

TEST_F(RecordingApp, SameTakeAndSettingsGiveSameClay) {
  writeSmallTake(folder / "take");
  for (const char* out : {"a", "b"})
    run({"sculpt", at("take"), "--headless", "--tool", "pull", "--symmetry", "x", "--out", at(out)});
  EXPECT_EQ(clayIn("a"), clayIn("b"));
}

TEST_F(RecordingApp, RecordingIsAnOrdinaryTake) {
  const int frames = writeSmallTake(folder / "take");
  folder.write("take/timestamps.csv", [&] {
    const Take take(folder / "take");
    std::string rows = "cam_id,frame_time\n";
    for (int i = 0; i < frames; ++i)
      for (const Camera& camera : take.rig().cameras)
        rows += camera.name + "," +
                std::to_string(i / 30.0 + (camera.name == take.rig().cameras[1].name ? 0.004 : 0)) + "\n";
    return rows;
  }());
  record("mine");
  Take source(folder / "take"), taken(folder / "mine");
  ASSERT_EQ(taken.frameCount(), frames);
  std::vector<std::vector<std::uint8_t>> a, b;
  for (const Camera& camera : source.rig().cameras)
    a.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
  b = a;
  const std::vector<std::span<std::uint8_t>> from(a.begin(), a.end()), to(b.begin(), b.end());
  for (int i = 0; i < frames; ++i) {
    ASSERT_TRUE(source.readImages(i, from) && taken.readImages(i, to));
    EXPECT_EQ(a, b) << i;
    EXPECT_EQ(source.cameraTimesOf(i), taken.cameraTimesOf(i));
  }
  const auto tracked = [&](const std::string& name) {
    const RunResult result = run({"track", at(name), "--poses", at(name + ".tum"), "--json"});
    const nlohmann::json figures = nlohmann::json::parse(result.output);
    EXPECT_NEAR(figures["skew_ms"].get<double>(), 4, 0.01);
    EXPECT_NEAR(figures["worst_skew_ms"].get<double>(), 4, 0.01);
  };
  tracked("take");
  tracked("mine");
  EXPECT_EQ(contentOf(folder / "take.tum"), contentOf(folder / "mine.tum"));
  run({"sculpt", at("mine"), "--ignore-actions", "--tool", "smooth", "--headless", "--out",
       at("images-only")});
  EXPECT_NE(clayIn("images-only"), clayIn("mine-out"));
}

TEST_F(RecordingApp, RelearningReplacesTheBackground) {
  const int frames = writeSmallTake(folder / "take", {.empty_frames = 20});
  record("first");  // the first ten frames teach the background
  // as if the user had requested relearning after them
  fs::copy(folder / "first", folder / "again", fs::copy_options::recursive);
  std::istringstream lines(contentOf(folder / "first/actions.txt"));
  std::string edited, line;
  int worked_on = 0;
  while (std::getline(lines, line)) {
    const bool is_frame = line.starts_with("frame ");
    if (is_frame && worked_on++ < 10) {
      edited += worked_on == 1 ? "empty\nlearn\n" : "learn\n";
      continue;
    }
    edited += line + "\n";
  }
  fs::permissions(folder / "again/actions.txt", fs::perms::owner_write, fs::perm_options::add);
  folder.write("again/actions.txt", edited);
  EXPECT_EQ(replay("again").errors, "");
  // a take that starts there
  fs::create_directories(folder / "later");
  fs::copy(folder / "take/rig.toml", folder / "later/rig.toml");
  for (const Camera& camera : readRig(folder / "take/rig.toml").cameras) {
    fs::create_directories(folder / "later" / camera.name);
    for (int i = 10; i < frames; ++i)
      fs::copy(folder / "take" / camera.name / (std::to_string(i) + ".png"),
               folder / "later" / camera.name / (std::to_string(i - 10) + ".png"));
  }
  run({"sculpt", at("later"), "--headless", "--out", at("later-out")});
  const auto apart_m = [&](const std::string& a, const std::string& b) {
    const PolygonMesh one = readObj(folder / a / "cage.obj"), other = readObj(folder / b / "cage.obj");
    double farthest_m = 0;
    for (std::size_t i = 0; i < one.points.size(); ++i)
      farthest_m = std::max(farthest_m, (one.points[i] - other.points[i]).norm());
    return farthest_m;
  };
  EXPECT_LT(apart_m("again-again", "later-out"), 1e-6);
  EXPECT_GT(apart_m("again-again", "first-out"), 1e-5) << "other frames, another background";
}

TEST_F(RecordingApp, RotatedClayStaysSymmetricAboutItsOwnPlanes) {
  const Rig rig = demoRig();
  const Vec3& center = rig.workspace.center;
  const Mat3 turn = Eigen::AngleAxisd(0.75, Vec3::UnitZ()).toRotationMatrix();
  ClayState ball = tubeState();
  ball.cage = presetCage("ball");
  // the hand moves from the side into the clay and back; `about` rotates its path
  const auto stroke = [&](const Mat3& about) {
    std::ostringstream lines;
    lines.precision(17);
    for (int i = 0; i <= 30; ++i) {
      const Vec3 place = center + about * Vec3(0.3 - 0.016 * std::min(i, 30 - i), -0.08, 0.02);
      lines << "frame " << i / 30.0 << " 0.033 push x 1 0";
      for (int row = 0; row < 3; ++row)
        lines << " " << about(row, 0) << " " << about(row, 1) << " " << about(row, 2) << " " << place[row];
      lines << "\n";
    }
    return lines.str() + "stroke\n";
  };
  const auto played = [&](const std::string& name, const std::string& actions) {
    fs::create_directories(folder / name);
    writeRig(folder / (name + "/rig.toml"), rig);
    Document::create(folder / (name + "/start.clay"), ball);
    folder.write(name + "/actions.txt", "airclay-actions 1\nmouse\n" + actions + "end\n");
    EXPECT_EQ(replay(name).errors, "");
    return Document::open(at(name + "-again.clay")).state();
  };
  const std::string turned_at_once = "turn 0 0 1 0.5 more\nturn 0 0 1 0.25 last\n";
  const ClayState lying = played("lying", stroke(Mat3::Identity()));
  const ClayState turned = played("turned", turned_at_once + stroke(turn));
  double moved_m = 0, lopsided_m = 0;
  for (std::size_t i = 0; i < ball.cage.points.size(); ++i) {
    const Vec3 start = ball.cage.points[i], truth = lying.cage.points[i] - center;
    EXPECT_LT((turn.transpose() * (turned.cage.points[i] - center) - truth).norm(), 1e-5);
    moved_m = std::max(moved_m, (lying.cage.points[i] - start).norm());
    double nearest_m = 1;
    for (const Vec3& other : turned.cage.points)
      nearest_m = std::min(
          nearest_m, (Vec3(-truth.x(), truth.y(), truth.z()) - turn.transpose() * (other - center)).norm());
    lopsided_m = std::max(lopsided_m, nearest_m);
  }
  EXPECT_GT(moved_m, 0.01);
  EXPECT_LT(lopsided_m, 1e-5);
  EXPECT_LT(angleBetween(turned.workspace_from_clay.toRotationMatrix(), turn), 1e-12);
  // after undo, the planes are restored, too: the same stroke has the same effect, bit for bit
  EXPECT_TRUE(sameClay(played("undone", turned_at_once + stroke(turn) + "undo\nundo\n"), ball));
  EXPECT_TRUE(sameClay(played("anew", turned_at_once + "undo\n" + stroke(Mat3::Identity())), lying));
}

TEST_F(RecordingApp, KilledRecordingReplaysPartially) {
  const int frames = writeSmallTake(folder / "take");
  record("whole");
  // in the middle: after a number of lines of actions
  Process program(
      {AIRCLAY_PROGRAM, "sculpt", at("take"), "--headless", "--record", at("cut"), "--out", at("cut-out")},
      {{"TMPDIR", folder.path()}}, folder / "output", folder / "errors");
  const auto lines = [&] {
    const std::string text = contentOf(folder / "cut/actions.txt");
    return std::count(text.begin(), text.end(), '\n');
  };
  ASSERT_TRUE(waitUntil([&] { return lines() > 25 || !program.running(); }));
  program.send(SIGKILL);
  EXPECT_EQ(program.waitForExit(), 128 + SIGKILL);

  const RunResult result = replay("cut");
  ASSERT_EQ(result.errorLines().size(), 1u + (result.errorLines().size() > 1))
      << result.errors;  // and a note on unequal lengths
  EXPECT_NE(result.errors.find("is incomplete"), std::string::npos) << result.errors;
  const int played = Take(folder / "cut", {.unfinished = true}).frameCount();
  EXPECT_GT(played, 5);
  EXPECT_LT(played, frames);
  // equals the whole recording, cut there
  const std::string poses = contentOf(folder / "cut-again/poses.tum");
  EXPECT_FALSE(poses.empty());
  EXPECT_EQ(contentOf(folder / "whole-out/poses.tum").substr(0, poses.size()), poses);
}

TEST_F(RecordingApp, InvalidUseIsAOneLineError) {
  writeSmallTake(folder / "take");
  record("mine");
  const auto refused = [&](const Strings& arguments, int status, const std::string& expected) {
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, status) << result.errors;
    ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
    EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
  };
  refused({"sculpt", at("mine"), "--headless", "--tool", "pull", "--out", at("o")}, 2, "--tool");
  refused({"sculpt", at("take"), "--headless", "--record", at("mine"), "--out", at("o")}, 1,
          "the folder is not empty");
  const std::string actions = contentOf(folder / "mine/actions.txt");
  const auto with = [&](const std::string& text, const std::string& expected) {
    folder.write("mine/actions.txt", text);
    refused({"sculpt", at("mine"), "--headless", "--out", at("o")}, 1, expected);
  };
  with("", "actions.txt: it is empty");
  with("something\n", "actions.txt:1:");
  with("airclay-actions 2\n", "newer Airclay");
  with("airclay-actions 1\nframe 1 0.03 knead - 1 1\n", "actions.txt:2: expected push, pull or smooth");
  with("airclay-actions 1\nframe 1 0.03 push q 1 1\n", "actions.txt:2: expected a symmetry");
  with("airclay-actions 1\nframe 1 nan push - 1 1\n", "actions.txt:2:");
  with("airclay-actions 1\nturn 0 0 1 0.5 almost\n", "actions.txt:2: expected more or last");
  with("airclay-actions 1\nhand ../../hand.glb\n",
       "actions.txt:2: expected the name of a file in the same folder");
  with("airclay-actions 1\nsing\n", "actions.txt:2: 'sing' is not an action");
  with("airclay-actions 1\nundo twice\n", "actions.txt:2: expected nothing after");
  with(actions.substr(0, actions.size() - 4) + "undo\nend\nframe 1 1 push - 1 1\n", "nothing after `end`");
}

}  // namespace
}  // namespace airclay
