// SPDX-License-Identifier: MIT
#include "engine/hand/fit.h"

#include <cstring>
#include <iostream>
#include <random>

#include "tests/support/gpu_fixture.h"
#include "tests/support/hand_scene.h"

namespace airclay {
namespace {

constexpr double kHandLength = 0.19;  // m

/// A hand that is one box about the origin; each face has divisions² squares of two triangles.
HandModel boxHand(const Vec3& half_size_m, int divisions = 1) {
  HandModel hand;
  hand.name = "box";
  std::vector<Vec3>& points = hand.skin.vertices;
  const auto pointAt = [&](const Vec3& place) {
    for (std::size_t i = 0; i < points.size(); ++i)
      if ((points[i] - place).norm() < 1e-9) return int(i);  // faces share vertices along their edges
    points.push_back(place);
    return int(points.size()) - 1;
  };
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, sign = face % 2 ? 1 : -1;
    const auto corner = [&](int i, int j) {
      Vec3 place = Vec3::Constant(sign);
      place[u] = 2.0 * i / divisions - 1;
      place[v] = 2.0 * j / divisions - 1;
      return pointAt(place.cwiseProduct(half_size_m));
    };
    for (int j = 0; j < divisions; ++j)
      for (int i = 0; i < divisions; ++i) {
        const int a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
        hand.skin.triangles.push_back(sign > 0 ? std::array{a, b, c} : std::array{a, c, b});
        hand.skin.triangles.push_back(sign > 0 ? std::array{a, c, d} : std::array{a, d, c});
      }
  }
  return hand;
}

Eigen::Quaterniond rotationOf(const GpuFit& fit) {
  return Eigen::Quaterniond(Eigen::Vector4d(fit.pose.rotation.cast<double>()));
}

Pose rootOf(const GpuFit& fit, const FitModel& model, const Workspace& workspace) {
  return handPose(fit.pose, poseFrame(model, workspace)).world_from_hand;
}

GpuFit startAt(const Vec3& position, const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity()) {
  GpuFit fit{};
  fit.pose = noHandPose();
  fit.pose.position = position.cast<float>();
  fit.pose.rotation = rotation.coeffs().cast<float>();
  return fit;
}

/// A voxel model with its distance field, and fits in it on the device.
struct Scene {
  GpuRig rig;
  Carver carver;
  DistanceField field;
  FieldGrid grid;
  std::vector<double> distances;
  Recorder recorder;

  Scene(const Rig& r, const std::vector<Silhouette>& masks, int voxels, const Vec3& center,
        double half_size_m)
      : rig(testGpu(), r), carver(testGpu(), rig, voxels), field(testGpu()), recorder(testGpu()) {
    Buffer<std::uint32_t> packed(testGpu(), rig.maskWords(), Memory::kHost);
    rig.pack(masks, packed.host());
    grid = placeField(carver, center, Vec3::Constant(half_size_m));
    recorder.begin();
    carver.record(recorder, packed);
    field.record(recorder, carver, grid);
    recorder.submitAndWait();
    for (const float distance : field.download(grid)) distances.push_back(distance);
  }

  std::vector<GpuFit> fit(Fitter& fitter, const std::vector<GpuFit>& starts, const FitLimits& limits = {}) {
    const Buffer<GpuFit> fits(testGpu(), starts);
    recorder.begin();
    fitter.record(recorder, field, grid, fits, std::uint32_t(starts.size()), limits);
    recorder.submitAndWait();
    return fits.download();
  }
};

/// The built-in hand with its forearm in a pose of the script, carved from its silhouettes.
struct HandScene : Scene {
  Pose truth;

  HandScene(HandCameras& cameras, const FitModel& model, const Pose& world_from_hand)
      : Scene(cameras.rig().rig(), cameras.masks(world_from_hand), 128,
              world_from_hand * model.center_of_mass, model.radius_m + 0.015),
        truth(world_from_hand) {}
};

constexpr double kScriptTimes[] = {0.5, 1.5, 2.1, 3.4,
                                   4.7};  // s: beside the tube, pressing, turning, above, pressing

/// The true pose, moved by up to `shift_m` and rotated by up to `turn`.
std::vector<GpuFit> startsAround(const GpuFit& truth, double shift_m, double turn, int count,
                                 std::mt19937& random) {
  std::uniform_real_distribution<double> within(-1, 1);
  const auto vector = [&]() -> Vec3 {
    return Vec3(within(random), within(random), within(random)) / std::sqrt(3.0);
  };
  std::vector<GpuFit> starts;
  for (int i = 0; i < count; ++i) {
    const Vec3 position = truth.pose.position.cast<double>() + shift_m * vector();
    starts.push_back(startAt(
        position, Eigen::Quaterniond(rotationFromVector(turn * vector())) * rotationOf(truth).normalized()));
  }
  return starts;
}

TEST(Fit, EveryStepEqualsTheReference) {
  const FitModel model = fitModel(builtInHand(false));
  Fitter fitter(testGpu(), model);
  HandCameras cameras;
  std::mt19937 random(2);
  double largest_shift = 0, largest_turn = 0;
  for (const double time_s : kScriptTimes) {
    HandScene scene(cameras, model, *demoScript().at(time_s));
    std::vector<GpuFit> states =
        startsAround(fitAt({scene.truth, {}}, model, scene.rig.rig().workspace), 0.012, 0.2, 4, random);
    for (int step = 0; step < 12; ++step) {
      const std::vector<GpuFit> found = scene.fit(fitter, states, {1});
      for (std::size_t i = 0; i < states.size(); ++i) {
        const GpuFit expected = fitReference(model, scene.distances, scene.grid, states[i], {1});
        const double shift = (found[i].pose.position - expected.pose.position).norm() / kHandLength;
        const double turn = (found[i].pose.rotation - expected.pose.rotation).norm();
        EXPECT_LE(shift, 1e-5) << "at " << time_s << " s, step " << step;
        EXPECT_LE(turn, 1e-5) << "at " << time_s << " s, step " << step;
        EXPECT_NEAR(found[i].outside_m, expected.outside_m, 1e-4 * expected.outside_m + 1e-8);
        EXPECT_NEAR(found[i].outside_count, expected.outside_count, 2);  // a patch exactly on the surface
        largest_shift = std::max(largest_shift, shift);
        largest_turn = std::max(largest_turn, turn);
      }
      states = found;
    }
  }
  std::cout << "step error " << largest_shift << " of the hand, " << largest_turn << " of the quaternion\n";
}

TEST(Fit, FinalPoseEqualsTheReference) {
  const FitModel model = fitModel(builtInHand(false));
  Fitter fitter(testGpu(), model);
  HandCameras cameras;
  std::mt19937 random(3);
  for (const double time_s : kScriptTimes) {
    HandScene scene(cameras, model, *demoScript().at(time_s));
    const std::vector<GpuFit> starts =
        startsAround(fitAt({scene.truth, {}}, model, scene.rig.rig().workspace), 0.01, 0.15, 4, random);
    const std::vector<GpuFit> found = scene.fit(fitter, starts);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      SCOPED_TRACE("at " + std::to_string(time_s) + " s, start " + std::to_string(i));
      const GpuFit expected = fitReference(model, scene.distances, scene.grid, starts[i], {});
      const PoseError error =
          poseError(rootOf(found[i], model, scene.rig.rig().workspace),
                    rootOf(expected, model, scene.rig.rig().workspace), model.center_of_mass);
      EXPECT_LE(error.shift_m, 1e-4);
      EXPECT_LE(error.turn_degrees, 0.05);
      EXPECT_EQ(found[i].outcome, expected.outcome);
    }
  }
}

TEST(Fit, TwoRunsGiveTheSameBits) {
  const FitModel model = fitModel(builtInHand(false));
  HandCameras cameras;
  std::vector<GpuFit> first;
  for (int run = 0; run < 2; ++run) {
    std::mt19937 random(4);
    Fitter fitter(testGpu(), model);
    HandScene scene(cameras, model, *demoScript().at(1.5));
    const std::vector<GpuFit> found = scene.fit(
        fitter,
        startsAround(fitAt({scene.truth, {}}, model, scene.rig.rig().workspace), 0.01, 0.15, 8, random));
    if (run == 0)
      first = found;
    else
      EXPECT_EQ(std::memcmp(first.data(), found.data(), found.size() * sizeof(GpuFit)), 0);
  }
}

// --- a rigid body under a known force ---

constexpr double kCube = 0.1;     // m, edge of the cube
constexpr double kDepth = 0.004;  // m, by which its face protrudes

/// The distance to a half space: s(p) = p.x - offset + tilt p.y.
std::vector<double> planeField(const FieldGrid& grid, double offset, double tilt) {
  std::vector<double> field(grid.cells());
  for (int z = 0; z < int(grid.place.size[2]); ++z)
    for (int y = 0; y < int(grid.place.size[1]); ++y)
      for (int x = 0; x < int(grid.place.size[0]); ++x) {
        const Vec3 p = grid.low + grid.cell_m * Vec3(x, y, z);
        field[grid.index(x, y, z)] = p.x() - offset + tilt * p.y();
      }
  return field;
}

FieldGrid planeGrid() {
  FieldGrid grid;
  for (std::uint32_t& size : grid.place.size) size = 64;
  grid.cell_m = 0.004;
  grid.low = Vec3::Constant(-0.126);
  return grid;
}

TEST(Fit, ProtrudingFaceMovesByTheClosedForm) {
  const FitModel model = fitModel(boxHand(Vec3::Constant(kCube / 2)));
  ASSERT_EQ(model.patches.size(), 12u);
  EXPECT_NEAR(model.patch_area_m2, 6 * kCube * kCube, 1e-8);
  EXPECT_LT((model.inertia_m2 - kCube * kCube / 6 * Mat3::Identity()).norm(), 1e-9);
  const FieldGrid grid = planeGrid();
  const std::vector<double> field = planeField(grid, kCube / 2 - kDepth, 0);
  const GpuFit fit = fitReference(model, field, grid, startAt(Vec3::Zero()), {1});
  // F = -A (s + margin), K = A, M / h² = 0.01 · 6 A; the two triangles' moments cancel
  const double margin_m = kFitMargin * grid.cell_m;
  EXPECT_NEAR(fit.pose.position.x(), -(kDepth + margin_m) / 1.06, 1e-8);
  EXPECT_NEAR(fit.pose.position.y(), 0, 1e-8);
  EXPECT_NEAR(fit.pose.position.z(), 0, 1e-8);
  EXPECT_NEAR(rotationOf(fit).angularDistance(Eigen::Quaterniond::Identity()), 0, 1e-6);
  EXPECT_EQ(fit.iterations, 1u);
}

TEST(Fit, UnevenlyPushedFaceRotatesByTheClosedForm) {
  const FitModel model = fitModel(boxHand(Vec3::Constant(kCube / 2)));
  const double tilt = 0.1;
  const FieldGrid grid = planeGrid();
  const std::vector<double> field = planeField(grid, kCube / 2 - kDepth, tilt);
  const GpuFit fit = fitReference(model, field, grid, startAt(Vec3::Zero()), {1});
  // The face's two triangles have their centroids at ±(y, z) and s = depth ± tilt y. With v = r x n =
  // (0, z, -y) of the first: N = -a (s1 - s2) v = -2 a tilt y v; the rotational part of K is 2 a v vᵀ; that
  // of M is 0.01 · 12 a · L² / 6.
  Vec3 r = Vec3::Zero();
  for (const GpuPatch& patch : model.patches)
    if (patch.normal.x() > 0.9) r = patch.center.cast<double>();
  EXPECT_NEAR(std::abs(r.y()), kCube / 6, 1e-8);
  const Vec3 v(0, r.z(), -r.y());
  const Vec3 turn = -2 * tilt * r.y() * v / (2 * v.squaredNorm() + 0.02 * kCube * kCube);
  const Eigen::Quaterniond expected(rotationFromVector(turn));
  EXPECT_GT(turn.norm(), 0.02);
  EXPECT_LT(rotationOf(fit).angularDistance(expected), 2e-6);
  EXPECT_NEAR(fit.pose.position.x(), -(kDepth + kFitMargin * grid.cell_m) / 1.06, 1e-8);
}

TEST(Fit, StepsStayWithinTheLinearRange) {
  const FitModel model = fitModel(boxHand(Vec3::Constant(kCube / 2)));
  const FieldGrid grid = planeGrid();
  const GpuFit fit = fitReference(model, planeField(grid, -0.05, 0), grid, startAt(Vec3::Zero()), {1});
  EXPECT_NEAR(fit.pose.position.norm(), 0.03, 1e-7);
}

// --- a box in a box-shaped hull: the whole workspace, which every camera sees ---

constexpr double kBoxEdge = 0.2;  // m
constexpr int kBoxVoxels = 48;    // 4.2 mm

Scene boxScene() {
  Rig rig = demoRig();
  rig.workspace.edge_m = kBoxEdge;
  std::vector<Silhouette> masks;
  for (const Camera& camera : rig.cameras)
    masks.push_back({camera.width, camera.height,
                     std::vector<std::uint8_t>(std::size_t(camera.width) * camera.height, 255)});
  return Scene(rig, masks, kBoxVoxels, Vec3::Zero(), 0.11);
}

TEST(Fit, DisplacedBoxReturns) {
  Scene scene = boxScene();
  ASSERT_EQ(scene.grid.place.stride, 1u);
  Fitter fitter(testGpu(), fitModel(boxHand(Vec3::Constant(kBoxEdge / 2), 10)));
  std::vector<GpuFit> starts;
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(-1, 1, 1)})
    starts.push_back(startAt(0.008 * way.normalized()));
  for (const GpuFit& fit : scene.fit(fitter, starts)) {
    EXPECT_LT(fit.pose.position.norm(), 0.5 * kBoxEdge / kBoxVoxels);
    EXPECT_LT(rotationOf(fit).angularDistance(Eigen::Quaterniond::Identity()), 0.01);
  }
  for (const GpuFit& start : starts) {
    const GpuFit fit = fitReference(fitter.model(), scene.distances, scene.grid, start, {});
    EXPECT_LT(fit.pose.position.norm(), 0.5 * kBoxEdge / kBoxVoxels);
  }
}

TEST(Fit, DistinguishesThreeOutcomes) {
  Scene scene = boxScene();
  Fitter smaller(testGpu(), fitModel(boxHand(Vec3::Constant(0.47 * kBoxEdge), 6)));
  Fitter larger(testGpu(), fitModel(boxHand(Vec3::Constant(0.51 * kBoxEdge), 6)));
  const GpuFit displaced = startAt(Vec3(0.01, 0, 0));

  const GpuFit included = scene.fit(smaller, {displaced})[0];
  EXPECT_EQ(included.outcome, kFitIncluded);
  EXPECT_EQ(included.outside_count, 0u);
  EXPECT_EQ(included.outside_fraction, 0);
  EXPECT_EQ(included.outside_m, 0);
  EXPECT_GT(included.iterations, 0u);

  // contained from the start: nothing moves
  const GpuFit at_rest = scene.fit(smaller, {startAt(Vec3::Zero())})[0];
  EXPECT_EQ(at_rest.outcome, kFitIncluded);
  EXPECT_EQ(at_rest.iterations, 0u);
  EXPECT_EQ(at_rest.pose.position.norm(), 0);

  // all faces protrude by 2 mm and push against each other
  const GpuFit stalled = scene.fit(larger, {displaced})[0];
  EXPECT_EQ(stalled.outcome, kFitStalled);
  EXPECT_GT(stalled.outside_fraction, 0.9);
  EXPECT_NEAR(stalled.outside_m, 0.002, 0.0005);
  EXPECT_LT(stalled.iterations, 40u);

  const GpuFit unfinished = scene.fit(larger, {displaced}, {1})[0];
  EXPECT_EQ(unfinished.outcome, kFitOutOfIterations);
  EXPECT_EQ(unfinished.iterations, 1u);

  for (const auto& [fitter, limit] :
       {std::pair(&smaller, 40), std::pair(&larger, 40), std::pair(&larger, 1)}) {
    const GpuFit found = scene.fit(*fitter, {displaced}, {limit})[0];
    EXPECT_EQ(found.outcome,
              fitReference(fitter->model(), scene.distances, scene.grid, displaced, {limit}).outcome);
  }
}

// --- the hand ---

TEST(Fit, ForearmDoesNotPullTheHand) {
  const FitModel model = fitModel(builtInHand(false));
  Fitter fitter(testGpu(), model);
  HandCameras cameras;
  for (const double time_s : kScriptTimes) {
    HandScene scene(cameras, model, *demoScript().at(time_s));
    const Workspace& workspace = scene.rig.rig().workspace;
    const Vec3 along_arm = scene.truth.linear().col(0);  // from the wrist to the fingertips
    for (const double shift_m : {-0.008, 0.0, 0.008}) {
      Pose start = scene.truth;
      start.translation() += shift_m * along_arm;
      const Pose found =
          rootOf(scene.fit(fitter, {fitAt({start, {}}, model, workspace)})[0], model, workspace);
      const Vec3 shift = found * model.center_of_mass - scene.truth * model.center_of_mass;
      EXPECT_LT(std::abs(shift.dot(along_arm)), 0.0025)
          << "at " << time_s << " s, started " << shift_m << " off";
    }
  }
}

TEST(Fit, IgnoresPatchesWithoutArea) {
  const HandModel box = boxHand(Vec3::Constant(0.05), 2);
  HandModel slivers = box;
  // an edge of two triangles gets a point at its middle: one triangle is split in two, and a triangle without
  // area fills the gap
  const auto [a, b, c] = slivers.skin.triangles[0];
  const int middle = int(slivers.skin.vertices.size());
  slivers.skin.vertices.push_back(
      (slivers.skin.vertices[std::size_t(a)] + slivers.skin.vertices[std::size_t(b)]) / 2);
  slivers.skin.triangles[0] = {a, middle, c};
  slivers.skin.triangles.push_back({middle, b, c});
  slivers.skin.triangles.push_back({a, b, middle});
  const FitModel expected = fitModel(box), model = fitModel(slivers);
  EXPECT_EQ(model.patches.size(), expected.patches.size() + 1);
  EXPECT_NEAR(model.patch_area_m2, expected.patch_area_m2, 1e-8);
  for (const GpuPatch& patch : model.patches) {
    EXPECT_GT(patch.area, 0);
    EXPECT_NEAR(patch.normal.norm(), 1, 1e-6);
    EXPECT_EQ(patch.cut, 0u);
  }
  EXPECT_LT((model.center_of_mass - expected.center_of_mass).norm(), 1e-12);
}

TEST(Fit, HandModelIsClosedAndStartsAtTheWrist) {
  const HandModel hand = builtInHand(false);
  const FitModel model = fitModel(hand);
  // on a closed surface, the area-weighted normals add up to zero
  Vec3 sum = Vec3::Zero();
  double area = 0, cut = 0;
  for (const GpuPatch& patch : model.patches) {
    sum += double(patch.area) * patch.normal.cast<double>();
    area += patch.area;
    if (!patch.cut) continue;
    cut += patch.area;
    EXPECT_LT(patch.normal.x(), -0.6) << "the cut faces the forearm";
  }
  EXPECT_LT(sum.norm(), 1e-5 * area);
  EXPECT_NEAR(area, model.patch_area_m2, 1e-6 * area);
  EXPECT_GT(cut, 0.0005);  // a wrist of 6 x 4 cm has 19 cm²
  EXPECT_LT(cut, 0.003);
  EXPECT_GT(model.radius_m, 0.08);
  EXPECT_LT(model.radius_m, 0.14);

  const FitModel thin = thinned(model, 8);
  double thin_area = 0;
  for (const GpuPatch& patch : thin.patches) thin_area += patch.area;
  EXPECT_EQ(thin.patches.size(), (model.patches.size() + 7) / 8);
  EXPECT_NEAR(thin_area, model.patch_area_m2, 1e-5 * area);
}

TEST(Fit, PoseRoundTripIsExact) {
  const FitModel model = fitModel(builtInHand(true));
  Workspace workspace;
  workspace.center = Vec3(1, -2, 0.5);
  Pose pose = Pose::Identity();
  pose.linear() = rotationFromVector(Vec3(0.4, -2, 1));
  pose.translation() = Vec3(0.9, -2.1, 0.55);
  const GpuFit fit = fitAt({pose, {}}, model, workspace);
  EXPECT_LT((fit.pose.position.cast<double>() - (pose * model.center_of_mass - workspace.center)).norm(),
            1e-7);
  EXPECT_LT((rootOf(fit, model, workspace).matrix() - pose.matrix()).norm(), 1e-6);
}

TEST(Fit, JointAnglesRoundTripThroughTheDevice) {
  const FitModel model = fitModel(builtInHand(false));
  Fitter fitter(testGpu(), model);
  HandCameras cameras;
  HandScene scene(cameras, model, *demoScript().at(1.5));
  const Workspace& workspace = scene.rig.rig().workspace;
  HandPose bent{scene.truth, std::vector<Vec3>(25, Vec3::Zero())};
  bent.joint_angles[7] = Vec3(0.5, -0.25, 1.5);
  const GpuFit found = scene.fit(fitter, {fitAt(bent, model, workspace)}).front();
  const HandPose after = handPose(found.pose, poseFrame(model, workspace));
  ASSERT_EQ(after.joint_angles.size(), 25u);
  for (std::size_t j = 0; j < 25; ++j) EXPECT_EQ(after.joint_angles[j], bent.joint_angles[j]) << j;
  const GpuFit straight = scene.fit(fitter, {fitAt({scene.truth, {}}, model, workspace)}).front();
  EXPECT_TRUE(handPose(straight.pose, poseFrame(model, workspace)).joint_angles.empty());
}

}  // namespace
}  // namespace airclay
