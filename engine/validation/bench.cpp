// SPDX-License-Identifier: MIT
// Times each stage separately on the demo's images, then the whole frame. Runs of ours and of the peer
// alternate, so that other load on the machine affects both.
#include "engine/validation/bench.h"

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <functional>
#include <set>

#include "engine/clay/presets.h"
#include "engine/clay/remesh.h"
#include "engine/core/error.h"
#include "engine/core/median.h"
#include "engine/hand/tracker.h"
#include "engine/pipeline.h"
#include "engine/sculpt/sculptor.h"
#include "engine/synthetic/demo_scene.h"
#include "engine/validation/bench_peers.h"

namespace airclay {
namespace {

constexpr int kBackgroundFrames = 10;
constexpr int kPressingFrame = 54;  // the hand is against the clay's side
// Chosen so that the whole benchmark takes about a minute on two idle cores.
constexpr int kMinRepeats = 3, kMaxRepeats = 60;
constexpr double kWarmUpMs = 100;
constexpr std::size_t kMaxFrames = 15;  // during the hand's first press
// Above this, the reference takes longer than a second or two and is not timed.
constexpr int kMaxReferenceVoxels = 128;

template <class Work>
double wallMs(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double sumMs(const StageTimes& stage_ms) {
  double sum = 0;
  for (const auto& [name, ms] : stage_ms) sum += ms;
  return sum;
}

/// A stage to time. Only `name`, `work` and `record` are required.
struct Stage {
  std::string name;
  double work = 0;
  std::string work_unit;
  std::function<void()> prepare;          ///< before each run, not timed
  std::function<void()> host;             ///< timed, before the submission
  std::function<void(Recorder&)> record;  ///< one submission
  std::function<void()> reference = {};   ///< timed once
  std::string peer_name = {};
  std::function<void()> peer = {};
};

/// The demo's scene with a learned background and one frame's images and masks.
struct Scene {
  Scene(Gpu& device, double ms_per_stage)
      : gpu(device),
        stage_ms(ms_per_stage),
        gpu_rig(gpu, rig),
        cameras(gpu, gpu_rig),
        silhouettes(gpu, gpu_rig) {
    Recorder recorder(gpu);
    for (int frame = 0; frame < kBackgroundFrames; ++frame) {
      const Buffer<std::uint32_t>& empty = cameras.draw(frame);
      recorder.begin();
      silhouettes.recordLearning(recorder, empty);
      if (frame + 1 == kBackgroundFrames) silhouettes.finishLearning(recorder);
      recorder.submitAndWait();
    }
    cameras.draw(kPressingFrame);
    recorder.begin();
    silhouettes.record(recorder, images());
    recorder.submitAndWait();
    masks = gpu_rig.unpack(silhouettes.masks().host());
  }
  const Buffer<std::uint32_t>& images() const { return cameras.images(); }

  Gpu& gpu;
  double stage_ms;  ///< for repeated runs of a stage
  Rig rig = demoRig();
  GpuRig gpu_rig;
  DemoCameras cameras;
  Silhouettes silhouettes;
  HandModel hand = builtInHand(false);
  std::vector<Silhouette> masks;
};

StageTiming timeStage(const Scene& scene, const Stage& stage) {
  Recorder recorder(scene.gpu);
  std::vector<double> gpu_ms, wall_ms, peer_ms;
  const auto run = [&](Timing timing) {
    if (stage.prepare) stage.prepare();
    return wallMs([&] {
      if (stage.host) stage.host();
      recorder.begin(timing);
      recorder.stage(stage.name);
      stage.record(recorder);
      recorder.submitAndWait();
    });
  };
  const auto repeat = [&] {
    wall_ms.push_back(run(Timing::kNone));
    if (stage.peer) peer_ms.push_back(wallMs(stage.peer));
    run(Timing::kStages);
    gpu_ms.push_back(sumMs(recorder.stageMs()));
  };
  const auto repeatFor = [&](double budget_ms, int at_least) {
    double spent_ms = 0;
    for (int i = 0; i < at_least || (i < kMaxRepeats && spent_ms < budget_ms); ++i)
      spent_ms += wallMs(repeat);
  };
  repeatFor(std::min(kWarmUpMs, scene.stage_ms), 1);
  gpu_ms.clear(), wall_ms.clear(), peer_ms.clear();
  repeatFor(scene.stage_ms, kMinRepeats);

  StageTiming timing{stage.name, scene.gpu.info().name, median(gpu_ms), median(wall_ms),
                     stage.work, stage.work_unit};
  if (stage.reference) timing.reference_ratio = wallMs(stage.reference) / timing.wall_ms;
  if (stage.peer) {
    timing.peer = stage.peer_name;
    timing.peer_ratio = median(peer_ms) / timing.wall_ms;
  }
  return timing;
}

// --- silhouette ---

std::vector<std::vector<BackgroundPixel>> backgroundsOf(const Scene& scene) {
  const std::vector<std::uint32_t> words = scene.silhouettes.model().download();
  std::vector<std::vector<BackgroundPixel>> backgrounds;
  for (std::size_t c = 0; c < scene.rig.cameras.size(); ++c) {
    const GpuCamera& camera = scene.gpu_rig.camera(c);
    std::vector<BackgroundPixel>& background = backgrounds.emplace_back();
    for (std::size_t i = 0; i < std::size_t(camera.width) * camera.height; ++i) {
      const std::uint32_t word = words[camera.pixels_before + i];
      background.push_back({Vec3(word & 255, word >> 8 & 255, word >> 16 & 255), kSpreadStep * (word >> 24)});
    }
  }
  return backgrounds;
}

void segmentReference(const Silhouette& size, std::span<const std::uint8_t> bgr,
                      const std::vector<BackgroundPixel>& background) {
  std::vector<double> scores;
  for (std::size_t i = 0; i < background.size(); ++i)
    scores.push_back(scoreReference(Vec3(bgr[3 * i], bgr[3 * i + 1], bgr[3 * i + 2]), background[i]));
  closeHolesReference(
      largestPartReference(majorityReference(edgesReference(size.width, size.height, scores))),
      largestHole(size.width));
}

StageTiming timeSilhouette(Scene& scene) {
  const std::vector<std::vector<BackgroundPixel>> backgrounds = backgroundsOf(scene);
  std::vector<std::span<const std::uint8_t>> images;
  for (std::size_t c = 0; c < backgrounds.size(); ++c) {
    const GpuCamera& camera = scene.gpu_rig.camera(c);
    const auto* bytes =
        reinterpret_cast<const std::uint8_t*>(scene.images().host().data() + camera.image_words);
    images.emplace_back(bytes, 3 * backgrounds[c].size());
  }
  SilhouetteLoop loop(scene.rig, backgrounds);
  loop.run(images);
  std::size_t different = 0;
  for (std::size_t c = 0; c < images.size(); ++c)
    for (std::size_t i = 0; i < scene.masks[c].pixels.size(); ++i)
      different += loop.masks()[c].pixels[i] != scene.masks[c].pixels[i];
  // a score on a threshold may round differently, which affects pixels up to two away
  if (different > 100)
    throw Error("bench: the plain silhouettes differ from the kernels' in " + std::to_string(different) +
                " pixels; expected at most 100, on thresholds (see airclay compare)");

  Stage stage;
  stage.name = "silhouette";
  stage.work = scene.gpu_rig.pixels();
  stage.work_unit = "pixels";
  stage.record = [&](Recorder& recorder) { scene.silhouettes.record(recorder, scene.images()); };
  stage.reference = [&] {
    for (std::size_t c = 0; c < images.size(); ++c)
      segmentReference(scene.masks[c], images[c], backgrounds[c]);
  };
  stage.peer_name = "plain loop, 2 threads";
  stage.peer = [&] { loop.run(images); };
  return timeStage(scene, stage);
}

// --- carve ---

/// \throw Error if the two differ except at edge voxels.
void checkSameVoxels(const Scene& scene, const VoxelGrid& carved, const CarveLoop& loop) {
  std::size_t different = 0, occupied = 0, index = 0;
  for (int z = 0; z < carved.voxels; ++z)
    for (int y = 0; y < carved.voxels; ++y)
      for (int x = 0; x < carved.voxels; ++x) {
        const bool ours = carved.occupied[index++] != 0;
        occupied += ours;
        if (ours != loop.at(x, y, z))
          different += !isEdgePoint(scene.rig, scene.masks,
                                    voxelCenter(scene.rig.workspace, carved.voxels, x, y, z), kEdgePixels);
      }
  if (different > 0 || occupied == 0)
    throw Error("bench: " + std::to_string(different) +
                " voxels of the plain loop differ from the kernels' away from the silhouettes' edges; "
                "expected none (see "
                "airclay compare)");
}

/// Carves from the packed masks that the silhouette stage writes; if `from_bytes`, also from masks of one
/// byte per pixel, as the loop does.
void timeCarve(Scene& scene, int voxels, bool from_bytes, std::vector<StageTiming>& timings) {
  Carver carver(scene.gpu, scene.gpu_rig, voxels);
  CarveLoop loop(scene.rig, voxels);
  Buffer<std::uint32_t>& packed = scene.silhouettes.masks();
  Stage stage;
  stage.name = "carve " + std::to_string(voxels);
  stage.work = std::pow(double(voxels), 3);
  stage.work_unit = "voxels";
  stage.record = [&](Recorder& recorder) { carver.record(recorder, packed); };
  if (voxels <= kMaxReferenceVoxels)
    stage.reference = [&] { carveReference(scene.rig, scene.masks, voxels); };
  stage.peer_name = "plain loop, 2 threads";
  stage.peer = [&] { loop.run(scene.masks); };
  timings.push_back(timeStage(scene, stage));
  checkSameVoxels(scene, carver.download(), loop);
  if (!from_bytes) return;
  stage.name += " from bytes";
  stage.reference = {};
  stage.host = [&] { scene.gpu_rig.pack(scene.masks, packed.host()); };
  timings.push_back(timeStage(scene, stage));
}

// --- hand pose ---

void timeHand(Scene& scene, int voxels, std::vector<StageTiming>& timings) {
  Carver carver(scene.gpu, scene.gpu_rig, voxels);
  Recorder recorder(scene.gpu);
  recorder.begin();
  carver.record(recorder, scene.silhouettes.masks());
  recorder.submitAndWait();
  const VoxelGrid hull = carver.download();

  Fitter fitter(scene.gpu, fitModel(scene.hand));
  const FitModel& model = fitter.model();
  const Workspace& workspace = scene.rig.workspace;
  // as in tracking: the last pose, and the last motion repeated
  const Pose last = *scene.cameras.pose(kPressingFrame - 1), before = *scene.cameras.pose(kPressingFrame - 2);
  const std::vector<GpuFit> starts = {fitAt({last, {}}, model, workspace),
                                      fitAt({last * before.inverse() * last, {}}, model, workspace)};
  const FieldGrid grid = gridAround(carver, model, starts[0].pose);
  DistanceField field(scene.gpu);
  std::vector<double> distances;

  Stage distance;
  distance.name = "distance";
  distance.work = double(grid.cells());
  distance.work_unit = "cells";
  distance.record = [&](Recorder& r) { field.record(r, carver, grid); };
  distance.reference = [&] { distances = distanceReference(hull, grid); };
  timings.push_back(timeStage(scene, distance));

  Buffer<GpuFit> fits(scene.gpu, starts.size(), Memory::kHost);
  Stage fit;
  fit.name = "fit";
  fit.work = double(starts.size() * model.patches.size());
  fit.work_unit = "patches (2 hypotheses)";
  fit.prepare = [&] { std::copy(starts.begin(), starts.end(), fits.host().begin()); };
  fit.record = [&](Recorder& r) {
    fitter.record(r, field, grid, fits, static_cast<std::uint32_t>(starts.size()), {});
  };
  fit.reference = [&] {
    for (const GpuFit& start : starts) fitReference(model, distances, grid, start, {});
  };
  timings.push_back(timeStage(scene, fit));
}

/// The first frame's search over all orientations, which takes several submissions with host work in between.
StageTiming timeSearch(Scene& scene, int voxels) {
  Carver carver(scene.gpu, scene.gpu_rig, voxels);
  HandTracker tracker(scene.gpu, scene.gpu_rig, scene.hand, carver);
  Recorder recorder(scene.gpu);
  recorder.begin();
  carver.record(recorder, scene.silhouettes.masks());
  recorder.submitAndWait();
  std::vector<double> gpu_ms, wall_ms;
  for (double spent_ms = 0; wall_ms.empty() || (wall_ms.size() < 3 && spent_ms < scene.stage_ms);
       spent_ms += wall_ms.back()) {
    StageTimes stage_ms;
    wall_ms.push_back(wallMs([&] { tracker.search(recorder, stage_ms); }));
    gpu_ms.push_back(sumMs(stage_ms));
  }
  return {"search", scene.gpu.info().name, median(gpu_ms), median(wall_ms), 1, "first frame"};
}

// --- clay ---

std::vector<vec3> floats(const std::vector<Vec3>& doubles) {
  std::vector<vec3> result;
  for (const Vec3& v : doubles) result.push_back(v.cast<float>());
  return result;
}

using Points = Eigen::Matrix<float, Eigen::Dynamic, 3>;

/// Eq. (5) and the normals for the tube subdivided `levels` times.
void timeSurface(const Scene& scene, int levels, const std::string& suffix,
                 std::vector<StageTiming>& timings) {
  const PolygonMesh cage = presetCage("tube");
  const Subdivision subdivision = subdivide(cage, levels, SubdivisionRule::kCatmullClark);
  SurfaceEvaluator evaluator(scene.gpu, subdivision);
  const Buffer<vec3> control_points(scene.gpu, floats(cage.points));
  const Eigen::SparseMatrix<float, Eigen::RowMajor> matrix = subdivision.matrix.cast<float>();
  Points control(Eigen::Index(cage.points.size()), 3), data(matrix.rows(), 3);
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    control.row(Eigen::Index(i)) = cage.points[i].cast<float>().transpose();
  std::vector<Vec3> points;

  Stage stage;
  stage.name = "subdivide" + suffix;
  stage.work = double(matrix.rows());
  stage.work_unit = "data points";
  stage.record = [&](Recorder& recorder) { evaluator.recordPoints(recorder, control_points); };
  stage.reference = [&] { points = dataPoints(subdivision.matrix, cage.points); };
  stage.peer_name = "Eigen, sparse";
  stage.peer = [&] { data.noalias() = matrix * control; };
  timings.push_back(timeStage(scene, stage));

  Stage normals;
  normals.name = "normals" + suffix;
  normals.work = stage.work;
  normals.work_unit = stage.work_unit;
  normals.record = [&](Recorder& recorder) { evaluator.recordNormals(recorder); };
  normals.reference = [&] { dataNormals(subdivision.quads, points); };
  timings.push_back(timeStage(scene, normals));
}

StageTiming timeSolve(const Scene& scene) {
  const PolygonMesh cage = presetCage("tube");
  const StencilMatrix matrix = subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix;
  ControlPointSolver solver(scene.gpu, matrix);
  const AllRowsSolver reference(matrix);
  // a quarter of the points pressed in by a centimetre
  std::vector<Vec3> targets(std::size_t(matrix.rows()), Vec3::Zero());
  for (std::size_t i = 0; i < targets.size() / 4; ++i) targets[i] = Vec3(-0.01, 0, 0);
  const Buffer<vec3> displacements(scene.gpu, floats(targets)),
      control_points(scene.gpu, floats(cage.points));
  Buffer<double> exact_points(scene.gpu, 3 * cage.points.size());
  std::vector<double> exact;
  for (const Vec3& point : cage.points) exact.insert(exact.end(), point.data(), point.data() + 3);
  exact_points.upload(exact);

  const Eigen::MatrixXd inverse = Eigen::MatrixXd(matrix).completeOrthogonalDecomposition().pseudoInverse();
  Eigen::MatrixXd right_side(matrix.rows(), 3), moved(matrix.cols(), 3);
  for (std::size_t i = 0; i < targets.size(); ++i) right_side.row(Eigen::Index(i)) = targets[i].transpose();

  Stage stage;
  stage.name = "solve";
  stage.work = double(matrix.cols());
  stage.work_unit = "control points";
  stage.record = [&](Recorder& r) { solver.record(r, displacements, exact_points, control_points); };
  stage.reference = [&] { reference.controlDisplacements(matrix, targets); };
  stage.peer_name = "Eigen, dense inverse";
  stage.peer = [&] { moved.noalias() = inverse * right_side; };
  return timeStage(scene, stage);
}

ClayState tubeClay() {
  ClayState options;
  options.cage = presetCage("tube");
  return options;
}

/// The largest depth of any of the points in the hand, metres.
double maxDepth(const DistanceGrid& hand, const Pose& world_from_hand, const FitModel& model,
                const std::vector<Vec3>& points) {
  double depth = -1;
  for (const Vec3& point : points)
    depth = std::max(depth, -sample(hand, world_from_hand.inverse() * point - model.center_of_mass));
  return depth;
}

/// Moves the hand in one step from outside the clay to 3 mm deep: contact, solve and surface, repeated until
/// the clay is outside the hand.
StageTiming timeClay(Scene& scene) {
  const FitModel model = fitModel(scene.hand);
  const DistanceGrid grid = contactGrid(scene.hand.skin);
  Clay clay(scene.gpu, tubeClay(), scene.rig.workspace.center);
  Sculptor sculptor(scene.gpu, clay, scene.hand);
  const PolygonMesh cage = clay.cage(), surface = clay.surface();
  int away = scene.cameras.backgroundFrames(), deep = away;
  while (deep < scene.cameras.frameCount() &&
         maxDepth(grid, *scene.cameras.pose(deep), model, surface.points) < 0.003) {
    if (maxDepth(grid, *scene.cameras.pose(deep), model, surface.points) < 0) away = deep;
    ++deep;
  }
  Buffer<GpuHandPose> hand_at(scene.gpu, 1, Memory::kHost);
  const auto put = [&](int frame) {
    hand_at.host()[0] = gpuHandPose({*scene.cameras.pose(frame), {}}, poseFrame(model, scene.rig.workspace));
  };
  Recorder recorder(scene.gpu);
  Stage stage;
  stage.name = "clay";
  stage.work = clay.dataPointCount();
  stage.prepare = [&] {
    clay.setControlPoints(cage.points);
    put(away);
    recorder.begin();
    sculptor.record(recorder, hand_at);
    recorder.submitAndWait();
    put(deep);
  };
  stage.record = [&](Recorder& r) { sculptor.record(r, hand_at); };
  StageTiming timing = timeStage(scene, stage);
  if (sculptor.step().touched == 0)
    throw Error("bench: the hand did not touch the clay in frame " + std::to_string(deep) +
                "; expected contact");
  timing.work_unit = "data points, " + std::to_string(sculptor.step().repeats) + " repeats";
  return timing;
}

// --- the whole frame ---

/// From pixels in memory to the new surface: the median over the frames in which the hand touches the clay.
StageTiming timeFrame(Scene& scene, int voxels) {
  Pipeline pipeline(scene.gpu, scene.rig, scene.hand, {.voxels = voxels, .time_every = 3}, tubeClay());
  const auto show = [&](int frame) {
    const Buffer<std::uint32_t>& images = scene.cameras.draw(frame);
    for (std::size_t c = 0; c < scene.rig.cameras.size(); ++c) {
      const std::span<std::uint8_t> image = pipeline.image(c);
      std::memcpy(image.data(), images.host().data() + scene.gpu_rig.camera(c).image_words, image.size());
    }
  };
  std::vector<double> gpu_ms, wall_ms;
  for (int frame = 0; frame < scene.cameras.frameCount() && wall_ms.size() < kMaxFrames; ++frame) {
    show(frame);
    if (frame < scene.cameras.backgroundFrames()) {
      pipeline.learnBackground();
      continue;
    }
    const FrameResult result = pipeline.processImages();
    if (result.searched || result.clay.touched == 0) continue;
    if (!result.stage_ms.empty()) gpu_ms.push_back(sumMs(result.stage_ms));
    wall_ms.push_back(result.frame_ms);
  }
  if (gpu_ms.empty()) throw Error("bench: the demo's hand never touched the clay; tracking was lost");
  return {"frame",         scene.gpu.info().name,          median(gpu_ms),
          median(wall_ms), double(scene.gpu_rig.pixels()), "pixels to surface"};
}

/// On the CPU, on demand: from a preset's cage to a new one.
StageTiming timeRemesh(const Scene& scene) {
  const PolygonMesh cage = presetCage("vase");
  const RemeshOptions options;
  std::vector<double> wall_ms;
  for (double spent_ms = 0; wall_ms.size() < 3 || (wall_ms.size() < 10 && spent_ms < scene.stage_ms);
       spent_ms += wall_ms.back())
    wall_ms.push_back(wallMs([&] { remesh(fineSurface(cage, options.rule, options), options); }));
  return {"remesh", "CPU", 0, median(wall_ms), double(options.faces), "faces"};
}

}  // namespace

std::vector<StageTiming> benchStages(Gpu& gpu, const BenchOptions& options) {
  checkVoxels(options.voxels);
  std::vector<StageTiming> timings;
  Scene scene(gpu, 1000 * options.stage_s);
  timings.push_back(timeSilhouette(scene));
  for (const int voxels : std::set<int>{128, 256, 512, options.voxels})
    timeCarve(scene, voxels, voxels == 128, timings);
  timeHand(scene, options.voxels, timings);
  timings.push_back(timeSearch(scene, options.voxels));
  timeSurface(scene, 2, "", timings);
  timeSurface(scene, 6, " fine", timings);
  timings.push_back(timeSolve(scene));
  timings.push_back(timeClay(scene));
  timings.push_back(timeRemesh(scene));
  timings.push_back(timeFrame(scene, options.voxels));
  return timings;
}

}  // namespace airclay
