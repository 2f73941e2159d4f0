// SPDX-License-Identifier: MIT
// The studio with the mouse hand: strokes, history, files and the window.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <cmath>

#include "engine/clay/presets.h"
#include "engine/core/file_io.h"
#include "tests/studio/studio_fixture.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;

std::vector<Vec3> surfaceOf(const ClayState& state) {
  return dataPoints(subdivide(state.cage, state.levels, state.rule).matrix, state.cage.points);
}

/// The largest distance from a point to the nearest of the other points, in both directions.
double farthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  const auto oneWay = [](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    double most = 0;
    for (const Vec3& p : from) {
      double least = INFINITY;
      for (const Vec3& q : to) least = std::min(least, (p - q).norm());
      most = std::max(most, least);
    }
    return most;
  };
  return std::max(oneWay(a, b), oneWay(b, a));
}

double asymmetryInX(const ClayState& state) {
  std::vector<Vec3> mirrored = state.cage.points;
  for (Vec3& point : mirrored) point.x() = -point.x();
  return farthest(state.cage.points, mirrored);
}

TEST_F(Studio, MousePushesUndoesRedoesAndRefines) {
  const fs::path file = folder / "a.clay";
  start({"--save", file});
  const Screenshot hint = restingFrame();
  desktop->key("Escape");
  EXPECT_TRUE(waitUntil([&] { return differingFraction(hint, desktop->screenshot(), 0.4) > 0.5; }));
  const ClayState begun = savedDocument(file).state();
  EXPECT_TRUE(sameClay(begun, tubeState()));

  ASSERT_TRUE(push()) << log();
  EXPECT_EQ(namesOf(savedDocument(file)), (Strings{"New tube", ">Push"}));
  const ClayState pushed = savedDocument(file).state();
  EXPECT_GT(farthestMove(begun, pushed), 0.01);

  desktop->key("ctrl+z");
  ASSERT_TRUE(seesCounts(0, 1)) << log();
  EXPECT_TRUE(sameClay(savedDocument(file).state(), begun));
  desktop->key("ctrl+shift+z");
  ASSERT_TRUE(seesCounts(1, 0)) << log();
  EXPECT_TRUE(sameClay(savedDocument(file).state(), pushed));

  EXPECT_EQ(log()["control_points"], 28);
  desktop->key("r");
  ASSERT_TRUE(seesCounts(2, 0)) << log();
  EXPECT_EQ(log()["control_points"], 98);
  const ClayState refined = savedDocument(file).state();
  EXPECT_EQ(refined.cage.points.size(), 98u);
  EXPECT_LT(farthest(surfaceOf(refined), surfaceOf(pushed)), 1e-9);
  close();
  EXPECT_EQ(namesOf(Document::open(file)), (Strings{"New tube", "Push", ">Refine"}));
}

TEST_F(Studio, PushKeepsSymmetry) {
  const fs::path file = folder / "a.clay";
  startWithoutHint({"--save", file, "--clay", "ball"});
  const ClayState begun = savedDocument(file).state();
  ASSERT_LT(asymmetryInX(begun), 1e-9);
  desktop->key("x");
  ASSERT_TRUE(push()) << log();
  const ClayState pushed = savedDocument(file).state();
  EXPECT_GT(farthestMove(begun, pushed), 0.005);
  EXPECT_LT(asymmetryInX(pushed), 1e-6);
  desktop->key("x");
  ASSERT_TRUE(push(1)) << log();
  EXPECT_GT(asymmetryInX(savedDocument(file).state()), 0.001);  // the hand is on one side
  close();
}

TEST_F(Studio, SigkillKeepsFinishedStrokes) {
  startWithoutHint({});
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "state" / "airclay"))
    if (entry.path().extension() == ".clay") files.push_back(entry.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_TRUE(files[0].filename().string().starts_with("unsaved-")) << files[0];
  ASSERT_TRUE(push()) << log();
  const ClayState pushed = savedDocument(files[0]).state();

  pushIn();
  program->send(SIGKILL);
  EXPECT_EQ(program->waitForExit(), 128 + SIGKILL);
  desktop->release();
  {
    const Document left = Document::open(files[0]);
    EXPECT_EQ(namesOf(left), (Strings{"New tube", ">Push"}));
    EXPECT_TRUE(sameClay(left.state(), pushed));
  }

  start({"--clay", files[0]});
  ASSERT_TRUE(seesCounts(1, 0)) << log();
  desktop->key("ctrl+z");
  ASSERT_TRUE(seesCounts(0, 1)) << log();
  close();
  const Document left = Document::open(files[0]);
  EXPECT_EQ(namesOf(left), (Strings{">New tube", "Push"}));
  EXPECT_TRUE(sameClay(left.state(), tubeState()));
}

TEST_F(Studio, WindowResizesMinimizesAndRemembersItsSize) {
  const auto hasSize = [&](int width, int height) {
    return sees([=](const json& line) { return line["width"] == width && line["height"] == height; });
  };
  start({});
  desktop->key("Escape");
  desktop->key("3");
  desktop->resize(1000, 700);
  EXPECT_TRUE(hasSize(1000, 700)) << log();
  desktop->minimise();
  EXPECT_TRUE(hasSize(0, 0)) << log();
  desktop->restore();
  EXPECT_TRUE(hasSize(1000, 700)) << log();
  for (int i = 0; i < 12; ++i)
    desktop->resize(700 + 40 * i, 500 + 20 * (i % 5));  // faster than images arrive
  desktop->resize(1040, 720);
  EXPECT_TRUE(hasSize(1040, 720)) << log();
  const auto since = std::chrono::steady_clock::now();
  close();
  EXPECT_LT(std::chrono::steady_clock::now() - since, std::chrono::seconds(10));
  EXPECT_TRUE(fs::is_empty(folder / "state" / "airclay"));  // no stroke touched the clay

  const fs::path file = folder / "a.clay";
  start({"--save", file});
  EXPECT_TRUE(hasSize(1040, 720)) << log();
  ASSERT_TRUE(push()) << log();  // and no hint covers the window
  close();
  EXPECT_EQ(namesOf(Document::open(file)), (Strings{"New tube", ">Smooth"}));
}

TEST_F(Studio, SharedMemoryAndSwapchainShowTheSame) {
  const auto shownBy = [&](const std::string& screen) {
    startWithoutHint({"--device", "llvmpipe", "--clay", "vase"});
    EXPECT_EQ(log()["screen"], screen);
    const Screenshot first = restingFrame();
    desktop->key("Tab");  // the panels' figures always change
    desktop->key("7");    // from the top: another image
    EXPECT_TRUE(waitUntil([&] { return differingFraction(first, desktop->screenshot(), kMiddle) > 0; }));
    const Screenshot shot = restingFrame();
    close();
    return shot;
  };
  const Screenshot shared = shownBy("shared memory");
  desktop.reset();
  desktop.emplace(Desktop::Options{.shared_memory = false});
  const Screenshot swapped = shownBy("swapchain");
  EXPECT_EQ(differingFraction(shared, swapped, kMiddle), 0);
  // and it is an image of clay in front of a backdrop
  Screenshot even = shared;
  std::fill(even.rgb.begin(), even.rgb.end(),
            shared.rgb[even.rgb.size() / 2 + 3 * std::size_t(even.width) / 2]);
  EXPECT_GT(differingFraction(shared, even, 0.5), 0.5);
}

TEST_F(Studio, InvalidFilesLoseNoClay) {
  const fs::path file = folder / "a.clay", other = folder / "b.clay";
  startWithoutHint({"--save", file});
  ASSERT_TRUE(push()) << log();
  const ClayState pushed = savedDocument(file).state();

  choose("ctrl+e", at("tube"));
  ASSERT_TRUE(seesNote("tube.stl: 672 faces")) << log();
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(at("tube.stl"), 0);
  ASSERT_TRUE(scene) << importer.GetErrorString();
  EXPECT_EQ(scene->mMeshes[0]->mNumFaces, 672u);
  std::vector<Vec3> exported;
  for (unsigned i = 0; i < scene->mMeshes[0]->mNumVertices; ++i) {
    const aiVector3D& v = scene->mMeshes[0]->mVertices[i];
    exported.push_back(Vec3(v.x, v.y, v.z) / 1000);  // STL is in millimetres
  }
  EXPECT_LT(farthest(exported, surfaceOf(pushed)), 1e-6);

  fs::create_directory(folder / "closed");
  ASSERT_EQ(chmod(at("closed").c_str(), 0555), 0);
  // Permissions do not bind root, but no one can create files in this system folder.
  const fs::path read_only = geteuid() == 0 ? fs::path("/proc") : folder / "closed";
  choose("ctrl+e", at("none/x"));
  EXPECT_TRUE(seesNote(at("none/x.stl"))) << log();
  choose("ctrl+e", read_only / "y.ply");
  EXPECT_TRUE(seesNote("y.ply")) << log();
  choose("ctrl+s", read_only / "z");
  EXPECT_TRUE(seesNote("z.clay")) << log();

  folder.write("text.clay", std::string(5000, 'x'));
  choose("ctrl+o", at("text.clay"));
  EXPECT_TRUE(seesNote("is not an Airclay document")) << log();
  const std::string whole = readWhole(file, kMaxDocumentBytes);
  folder.write("cut.clay", whole.substr(0, whole.size() / 2));
  choose("ctrl+o", at("cut.clay"));
  EXPECT_TRUE(seesNote("truncated")) << log();
  EXPECT_TRUE(seesCounts(1, 0));
  EXPECT_TRUE(sameClay(savedDocument(file).state(), pushed));

  choose("ctrl+s", other);
  ASSERT_TRUE(seesNote("saved as")) << log();
  EXPECT_EQ(namesOf(Document::open(file)), (Strings{"New tube", ">Push"}));  // which is unlocked now
  ASSERT_TRUE(push(1)) << log();
  choose("ctrl+o", file);
  ASSERT_TRUE(seesNote("opened")) << log();
  EXPECT_TRUE(seesCounts(1, 0));
  close();
  EXPECT_TRUE(sameClay(Document::open(file).state(), pushed));
  EXPECT_EQ(namesOf(Document::open(other)), (Strings{"New tube", "Push", ">Push"}));
}

TEST_F(Studio, ReplayReproducesMouseSession) {
  folder.write("config/airclay/studio.toml",
               "first_run = false\nfolder = '" + folder.path().string() + "'\n");
  start({"--save", at("a.clay")});
  ASSERT_TRUE(push()) << log();  // before recording, so that the recording starts with pushed clay
  desktop->key("ctrl+r");
  ASSERT_TRUE(sees([](const json& line) { return line["recording"] == true; })) << log();
  desktop->key("x");
  ASSERT_TRUE(push(1)) << log();
  desktop->keyDown("Right");
  ASSERT_TRUE(waitUntil([&] { return log()["recorded_frames"] > 40; }));
  desktop->keyUp("Right");
  ASSERT_TRUE(seesCounts(3, 0)) << log();
  desktop->key("r");
  ASSERT_TRUE(seesCounts(4, 0)) << log();
  for (int i = 0; i < 4; ++i) desktop->key("ctrl+z");  // one more than was recorded
  ASSERT_TRUE(seesCounts(0, 4)) << log();
  desktop->key("ctrl+shift+z");
  desktop->key("ctrl+shift+z");
  ASSERT_TRUE(seesCounts(2, 2)) << log();
  desktop->key("3");
  ASSERT_TRUE(push(2)) << log();
  desktop->key("ctrl+r");
  ASSERT_TRUE(seesNote("recorded ")) << log();
  EXPECT_TRUE(sees([](const json& line) { return line["recording"] == false; }));
  close();
  const Document once = Document::open(at("a.clay"));
  EXPECT_EQ(namesOf(once), (Strings{"New tube", "Push", "Push", ">Smooth"}));

  const fs::path recording = recorded();
  ASSERT_FALSE(recording.empty());
  const RunResult result =
      runAirclay({"sculpt", recording, "--headless", "--save", at("b.clay"), "--out", at("out")},
                 {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_TRUE(sameClay(Document::open(at("b.clay")).state(), once.state()));
  EXPECT_EQ(namesOf(Document::open(at("b.clay"))), namesOf(once));

  start({recording, "--save", at("c.clay")});  // and with a window
  ASSERT_TRUE(sees([](const json& line) { return line["ended"] == true; })) << log();
  close();
  EXPECT_TRUE(sameClay(Document::open(at("c.clay")).state(), once.state()));
}

TEST_F(Studio, RemeshIsOneEditThatReplays) {
  folder.write("config/airclay/studio.toml",
               "first_run = false\nfolder = '" + folder.path().string() + "'\n");
  start({"--clay", "ball", "--save", at("a.clay")});
  const int before = log()["control_points"];
  desktop->key("ctrl+r");
  ASSERT_TRUE(sees([](const json& line) { return line["recording"] == true; })) << log();
  desktop->key("m");
  ASSERT_TRUE(seesCounts(1, 0)) << log();
  const int remeshed = log()["control_points"];
  EXPECT_NEAR(remeshed, 1600, 50);
  desktop->key("ctrl+z");
  ASSERT_TRUE(seesCounts(0, 1)) << log();
  EXPECT_EQ(log()["control_points"], before);
  desktop->key("ctrl+shift+z");
  ASSERT_TRUE(seesCounts(1, 0)) << log();
  EXPECT_EQ(log()["control_points"], remeshed);
  desktop->key("ctrl+r");
  ASSERT_TRUE(seesNote("recorded ")) << log();
  close();
  const Document once = Document::open(at("a.clay"));
  EXPECT_EQ(namesOf(once), (Strings{"New ball", ">Remesh"}));
  const RunResult result =
      runAirclay({"sculpt", recorded(), "--headless", "--save", at("b.clay"), "--out", at("out")},
                 {.environment = {{"AIRCLAY_VALIDATION", "1"}}});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(sameClay(Document::open(at("b.clay")).state(), once.state()));

  startWithoutHint({"--save", at("tube.clay")});
  desktop->key("m");
  EXPECT_TRUE(seesNote("the surface is open")) << log();
  EXPECT_TRUE(seesCounts(0, 0)) << log();
  close();
}

/// A slightly wavy grid with this number of points per side: large, and fast to write.
std::string gridObj(int side) {
  std::string text;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      text += "v " + std::to_string(0.3 * x / side - 0.15) + " " + std::to_string(0.3 * y / side - 0.15) +
              " " + std::to_string(0.01 * std::sin(0.1 * x)) + "\n";
  for (int y = 0; y + 1 < side; ++y)
    for (int x = 0; x + 1 < side; ++x) {
      const int a = y * side + x + 1;
      text += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + side + 1) +
              " " + std::to_string(a + side) + "\n";
    }
  return text;
}

TEST_F(Studio, CancelledTaskChangesNothing) {
  folder.write("grid.obj", gridObj(400));  // 160,000 control points
  const fs::path file = folder / "a.clay";
  ASSERT_EQ(runAirclay({"new", file, "--clay", at("grid.obj"), "--levels", "1", "--solve", "touched"}).status,
            0);
  startWithoutHint({"--clay", file});
  const auto works = [&](const std::string& what) {
    return [what](const json& line) { return line["working"] == what; };
  };
  const ClayState begun = savedDocument(file).state();
  desktop->key("r");
  ASSERT_TRUE(sees(works("refining"))) << log();
  desktop->key("Escape");
  EXPECT_TRUE(seesNote("cancelled")) << log();
  EXPECT_TRUE(seesCounts(0, 0));
  EXPECT_EQ(log()["control_points"], 160'000);
  close();
  EXPECT_TRUE(sameClay(Document::open(file).state(), begun));
}

TEST_F(Studio, TheClutchsKeyIsChosenInTheWindow) {
  const fs::path file = folder / "a.clay";
  folder.write("config/airclay/studio.toml", "first_run = false\nclutch = 1\n");
  start({"--save", file});
  const auto clickKey = [&] {
    desktop->moveTo(130, 271);  // "Key: Space", in the tools
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    desktop->press();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    desktop->release();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  };
  EXPECT_EQ(log()["clutch_key"], "Space");
  clickKey();
  desktop->key("g");
  EXPECT_TRUE(seesNote("G is already used: Control cage")) << log();
  EXPECT_EQ(log()["clutch_key"], "Space");
  clickKey();
  desktop->key("w");  // held keys, too
  EXPECT_TRUE(seesNote("W is already used: Farther, nearer")) << log();
  clickKey();
  desktop->key("F8");
  EXPECT_TRUE(sees([](const json& line) { return line["clutch_key"] == "F8"; })) << log();
  // it is the clutch: without it, the hand passes through
  desktop->key("6");
  desktop->moveTo(500, 560);
  desktop->press();
  for (int x = 500; x <= 760; x += 10) desktop->moveTo(x, 560);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_TRUE(seesCounts(0, 0));
  for (int x = 760; x >= 500; x -= 10) desktop->moveTo(x, 560);
  desktop->release();
  desktop->keyDown("F8");
  ASSERT_TRUE(push()) << log();
  desktop->keyUp("F8");
  close();
  EXPECT_NE(contentOf(folder / "config/airclay/studio.toml").find("clutch_key = 297"), std::string::npos);
}

TEST_F(Studio, LostHandDoesNotGripByItself) {
  const fs::path file = folder / "a.clay";
  folder.write("config/airclay/studio.toml", "first_run = false\nclutch = 1\ntool = 1\n");
  start({"--save", file});
  const auto isBarred = [](bool barred) {
    return [barred](const json& line) { return line["grip_barred"] == barred; };
  };
  desktop->keyDown("space");
  pushIn();  // which grips here
  desktop->release();
  desktop->key("h");  // the hand disappears
  EXPECT_TRUE(sees(isBarred(true))) << log();
  ASSERT_TRUE(seesCounts(1, 0)) << log();
  const ClayState pulled = savedDocument(file).state();
  desktop->key("h");  // and returns, inside the clay, with the key still down
  EXPECT_TRUE(sees([](const json& line) { return line["hand"] == "tracking"; })) << log();
  desktop->press();
  pullOut();
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_TRUE(seesCounts(1, 0)) << log();
  EXPECT_EQ(log()["grip_barred"], true);
  desktop->keyUp("space");
  EXPECT_TRUE(sees(isBarred(false))) << log();
  EXPECT_TRUE(sameClay(savedDocument(file).state(), pulled));
  desktop->keyDown("space");
  pushIn();  // pressed again, it grips
  desktop->keyUp("space");
  EXPECT_TRUE(seesCounts(2, 0)) << log();
  desktop->release();
  close();
}

}  // namespace
}  // namespace airclay
