// SPDX-License-Identifier: MIT
// The main job as a whole program: from pixels in files to poses, surface, images and video, compared with
// the known truth.
#include <gtest/gtest.h>

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numbers>

#include "capture/images/video_reader.h"
#include "capture/takes/synthetic.h"
#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/cage_files.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;

constexpr int kFrames = 15;  // with the hand: enough to find and follow it

/// Median and maximum error of poses against the truth at the same times.
struct PoseErrors {
  double median_mm = 0, worst_mm = 0, median_deg = 0;
};

PoseErrors errorsOf(const std::vector<TimedPose>& poses, const std::vector<TimedPose>& truth) {
  std::vector<double> mm, deg;
  for (const TimedPose& pose : poses)
    for (const TimedPose& true_pose : truth) {
      if (std::abs(pose.time_s - true_pose.time_s) > 1e-4) continue;
      mm.push_back(1000 *
                   (pose.world_from_hand.translation() - true_pose.world_from_hand.translation()).norm());
      deg.push_back(angleBetween(pose.world_from_hand.linear(), true_pose.world_from_hand.linear()) * 180 /
                    std::numbers::pi);
    }
  EXPECT_EQ(mm.size(), poses.size());
  if (mm.empty()) return {};
  std::sort(mm.begin(), mm.end());
  std::sort(deg.begin(), deg.end());
  return {mm[mm.size() / 2], mm.back(), deg[deg.size() / 2]};
}

/// The demo's first frames as a recording on disk: lossless images, rig and truth.
struct RecordedDemo {
  TemporaryFolder folder;
  int background_frames = 0, frames = 0;

  explicit RecordedDemo(int frames_with_hand) {
    Synthetic synthetic(testGpu());
    background_frames = synthetic.backgroundFrames();
    frames = background_frames + frames_with_hand;
    writeRig(folder / "rig.toml", synthetic.rig());
    writePoses(folder / "truth.tum", *synthetic.truth());
    std::vector<std::vector<std::uint8_t>> images;
    for (const Camera& camera : synthetic.rig().cameras) {
      std::filesystem::create_directory(folder / camera.name);
      images.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
    }
    const std::vector<std::span<std::uint8_t>> buffers(images.begin(), images.end());
    for (int frame = 0; frame < frames; ++frame) {
      synthetic.readImages(frame, buffers);
      for (std::size_t i = 0; i < images.size(); ++i) writeBgr(synthetic.rig().cameras[i], frame, images[i]);
    }
  }
  void writeBgr(const Camera& camera, int frame, const std::vector<std::uint8_t>& bgr) const {
    std::vector<std::uint8_t> rgba;
    for (std::size_t i = 0; i < bgr.size(); i += 3)
      rgba.insert(rgba.end(), {bgr[i + 2], bgr[i + 1], bgr[i], 255});
    writePng(folder.path() / camera.name / (std::to_string(frame) + ".png"), {camera.width, camera.height},
             rgba);
  }
  std::string path() const { return folder.path().string(); }
  std::string background() const { return std::to_string(background_frames); }
};

TEST(SculptApp, TrackFollowsTheHandOfARecording) {
  const RecordedDemo take(kFrames);
  const std::string poses = take.folder / "poses.tum";
  const RunResult result =
      runAirclay({"track", take.path(), "--background", take.background(), "--poses", poses, "--json"});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const json figures = json::parse(result.output);
  EXPECT_EQ(figures["frames"], take.frames);
  EXPECT_EQ(figures["empty"], take.background_frames);
  EXPECT_EQ(figures["tracked"], kFrames);
  EXPECT_EQ(figures["lost"], 0);
  for (const char* stage : {"silhouette", "carve", "fit"}) EXPECT_GT(figures["stage_ms"][stage], 0) << stage;
  EXPECT_GT(figures["decode_ms"], 0);
  EXPECT_NEAR(figures["hz"].get<double>() * figures["frame_ms"].get<double>(), 1000, 1e-6);

  const PoseErrors errors = errorsOf(readPoses(poses), readPoses(take.folder / "truth.tum"));
  EXPECT_LT(errors.median_mm, 2);
  EXPECT_LT(errors.median_deg, 1);
  EXPECT_NEAR(figures["worst_error_mm"], errors.worst_mm, 1e-3);  // the file has six decimals
}

TEST(SculptApp, EarlyTerminationLeavesNoFiles) {
  const RecordedDemo take(kFrames);
  const std::filesystem::path out = take.folder / "out";
  std::filesystem::create_directory(out);
  const RunResult result = runAirclay(
      {"track", take.path(), "--background", take.background(), "--poses", (out / "poses.tum").string()},
      {.environment = {}, .terminate_after_ms = 500});
  EXPECT_EQ(result.status, 128 + 15);
  EXPECT_TRUE(std::filesystem::is_empty(out));
}

/// Ctrl-C once a file with this name exists in the folder: one line, status 130, and no partial files.
void expectInterrupted(const std::vector<std::string>& arguments, const std::filesystem::path& out,
                       const std::string& name) {
  SCOPED_TRACE(arguments.at(0));
  const auto begun = [&] {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(out, ignored))
      if (entry.path().filename().string().starts_with(name)) return true;
    return false;
  };
  RunOptions options;
  options.interrupt_when = begun;
  const RunResult result = runAirclay(arguments, options);
  EXPECT_EQ(result.status, 128 + SIGINT);
  EXPECT_EQ(result.errors, "airclay: interrupted\n");
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    const std::string left = entry.path().filename();
    EXPECT_EQ(left.find(".part-"), std::string::npos) << left;
    EXPECT_EQ(left.find("unfinished"), std::string::npos) << left;
    EXPECT_FALSE(left.ends_with(".mp4")) << left;
    if (left.ends_with(".png")) {
      EXPECT_GT(imageSize(entry.path()).width, 0) << left;  // also checks that the file is complete
    }
  }
}

TEST(SculptApp, CtrlCEndsSculptCleanly) {
  const RecordedDemo take(kFrames);
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  std::filesystem::create_directory(out);
  expectInterrupted({"sculpt", take.path(), "--background", take.background(), "--headless", "--out", out,
                     "--video", folder / "out/film.mp4"},
                    out, "before.png");
  expectInterrupted({"demo", "--headless", "--out", folder / "demo"}, folder / "demo", "before.png");
  expectInterrupted({"figures", "--out", folder / "figures"}, folder / "figures", "figure1.png");
}

TEST(SculptApp, CtrlCEndsAnExportCleanly) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "out");
  const std::string large = folder / "out/large.obj";
  RunOptions options;
  const auto since = std::chrono::steady_clock::now();
  options.interrupt_when = [&] { return std::chrono::steady_clock::now() - since > std::chrono::seconds(1); };
  const RunResult result =
      runAirclay({"export", "ball", "--levels", "7", "--out", large}, options);  // 400,000 points
  EXPECT_EQ(result.status, 128 + SIGINT);
  EXPECT_EQ(result.errors, "airclay: interrupted\n");
  EXPECT_TRUE(std::filesystem::is_empty(folder / "out"));
}

TEST(SculptApp, DemoSculptsFromPixels) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "demo";
  const RunResult result = runAirclay({"demo", "--out", out.string()});
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_NE(result.output.find(" Hz"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find(" 0 lost"), std::string::npos) << result.output;

  const std::vector<TimedPose> truth = *Synthetic(testGpu()).truth();
  const std::vector<TimedPose> poses = readPoses(out / "poses.tum");
  EXPECT_EQ(poses.size(), truth.size());
  const PoseErrors errors = errorsOf(poses, truth);
  EXPECT_LT(errors.median_mm, 2);
  EXPECT_LT(errors.median_deg, 1);

  // the clay moved, and surface and cage satisfy d = A p
  const PolygonMesh start = presetCage("tube"), cage = readObj(out / "cage.obj");
  const PolygonMesh surface = readObj(out / "surface.obj");
  const StencilMatrix matrix = subdivide(start, 2, SubdivisionRule::kCatmullClark).matrix;
  const std::vector<Vec3> expected = dataPoints(matrix, cage.points);
  const std::vector<Vec3> before = dataPoints(matrix, start.points);
  ASSERT_EQ(surface.points.size(), expected.size());
  double farthest_m = 0, moved_m = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    farthest_m = std::max(farthest_m, (surface.points[i] - expected[i]).norm());
    moved_m = std::max(moved_m, (surface.points[i] - before[i]).norm());
  }
  EXPECT_LT(farthest_m, 1e-6);  // the surface is evaluated in single precision
  EXPECT_GT(moved_m, 0.01);

  for (const char* image : {"before.png", "touch.png", "workings.png", "after.png"})
    EXPECT_GT(imageSize(out / image).width, 100) << image;
  const std::unique_ptr<FrameSource> video = openFrames(out, "demo");
  ASSERT_TRUE(video);
  EXPECT_GE(video->frameCount(), static_cast<int>(poses.size()));
}

TEST(SculptApp, SculptFollowsItsOptions) {
  const RecordedDemo take(10);
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out", video = folder / "film.mp4";
  const RunResult result =
      runAirclay({"sculpt",      take.path(),  "--background",   take.background(), "--clay",
                  "ball",        "--place",    "0.05,-0.1,0.02", "--size",          "0.08",
                  "--levels",    "1",          "--rule",         "printed",         "--solve",
                  "touched",     "--headless", "--out",          out.string(),      "--video",
                  video.string()});
  ASSERT_EQ(result.status, 0) << result.errors;
  const PolygonMesh ball = presetCage("ball");
  const Subdivision subdivision = subdivide(ball, 1, SubdivisionRule::kPrinted);
  const PolygonMesh surface = readObj(out / "surface.obj"), cage = readObj(out / "cage.obj");
  EXPECT_EQ(surface.points.size(), static_cast<std::size_t>(subdivision.matrix.rows()));
  Eigen::AlignedBox3d bounds;
  for (const Vec3& point : cage.points) bounds.extend(point);
  EXPECT_LT((bounds.center() - Vec3(0.05, -0.1, 0.02)).norm(), 1e-6);
  EXPECT_NEAR(bounds.sizes().maxCoeff(), 0.08, 1e-6);
  const std::vector<Vec3> expected = dataPoints(subdivision.matrix, cage.points);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_LT((surface.points[i] - expected[i]).norm(), 1e-6);
  EXPECT_EQ(openFrames(folder.path(), "film")->frameCount(), take.frames);
}

TEST(SculptApp, WarnsOfClayOutsideTheWorkspace) {
  const RecordedDemo take(1);
  const RunResult result = runAirclay({"sculpt", take.path(), "--background", take.background(), "--place",
                                       "0.3,0,0", "--out", take.folder / "out"});
  EXPECT_EQ(result.status, 0);
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find("outside the workspace"), std::string::npos);
}

TEST(SculptApp, CagesHaveAUnitAndAnUpAxisOfTheirOwn) {
  const RecordedDemo take(1);
  PolygonMesh slab = cubeCage(100);
  for (Vec3& point : slab.points) point.y() /= 4;
  const std::string file = take.folder.write("slab.obj", objOf(slab)).string();
  const RunResult result =
      runAirclay({"sculpt", take.path(), "--background", take.background(), "--clay", file, "--clay-units",
                  "mm", "--clay-up", "y", "--out", take.folder / "out"});
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors, "");
  Eigen::AlignedBox3d box;
  for (const Vec3& point : readObj(take.folder / "out/cage.obj").points) box.extend(point);
  EXPECT_LT((box.sizes() - Vec3(0.1, 0.1, 0.025)).norm(), 1e-6);
}

TEST(SculptApp, CompareAndBenchPrintTheirKeys) {
  const RunResult compared = runAirclay({"compare", "--json"});
  EXPECT_EQ(compared.status, 0) << compared.errors;
  const json kernels = json::parse(compared.output)["kernels"];
  EXPECT_GT(kernels.size(), 4u);
  for (const json& kernel : kernels) {
    EXPECT_EQ(kernel["pass"], true) << kernel;
    EXPECT_LE(kernel["error"], kernel["tolerance"]) << kernel;
  }
  const RunResult timed = runAirclay({"bench", "--seconds", "0.05", "--json"});
  EXPECT_EQ(timed.status, 0) << timed.errors;
  const json stages = json::parse(timed.output)["stages"];
  EXPECT_TRUE(std::any_of(stages.begin(), stages.end(), [](const json& s) { return s["name"] == "frame"; }));
  for (const json& stage : stages)
    for (const char* key :
         {"name", "device", "gpu_ms", "wall_ms", "work", "reference_ratio", "peer", "peer_ratio"})
      EXPECT_TRUE(stage.contains(key)) << key;
}

}  // namespace
}  // namespace airclay
