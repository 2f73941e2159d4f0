// SPDX-License-Identifier: MIT
// Runs every kernel on the demo's images and compares it with its reference for the same input, which is the
// output of the preceding kernels. A wrong kernel therefore shows in one row only.
#include "engine/validation/compare.h"

#include <algorithm>
#include <cmath>

#include "engine/clay/presets.h"
#include "engine/clay/solve.h"
#include "engine/clay/subdivide.h"
#include "engine/hand/fit.h"
#include "engine/hand/hand_model.h"
#include "engine/hand/tracker.h"
#include "engine/sculpt/contact.h"
#include "engine/sculpt/grip.h"
#include "engine/sculpt/relax.h"
#include "engine/sculpt/symmetry.h"
#include "engine/validation/compare_scene.h"
#include "shaders/hand/fit_choose.comp.h"

namespace airclay {
namespace {

constexpr int kBackgroundFrames = 8;
constexpr int kVoxels = kComparedVoxels;
// The kernel subtracts squares of grey levels, up to 3 · 255², in single precision: scores closer to a level
// than this may fall on either side.
constexpr double kLevelTolerance = 1e-4;

// --- silhouettes ---

BackgroundPixel backgroundPixel(std::uint32_t word) {
  return {Vec3(word & 255, word >> 8 & 255, word >> 16 & 255), kSpreadStep * (word >> 24)};
}

void compareBackground(CompareScene& scene, Comparisons& comparisons) {
  std::vector<std::vector<std::vector<std::uint8_t>>> empty(scene.gpu_rig.cameraCount());
  for (int frame = 0; frame < kBackgroundFrames; ++frame) {
    const Buffer<std::uint32_t>& images = scene.cameras.draw(frame);
    scene.recorder.begin();
    scene.silhouettes.recordLearning(scene.recorder, images);
    if (frame + 1 == kBackgroundFrames) scene.silhouettes.finishLearning(scene.recorder);
    scene.recorder.submitAndWait();
    for (std::size_t c = 0; c < empty.size(); ++c) empty[c].push_back(scene.image(images.host(), c));
  }
  const std::vector<std::uint32_t> model = scene.silhouettes.model().download();
  double error = 0;
  for (std::size_t c = 0; c < empty.size(); ++c) {
    const std::vector<BackgroundPixel> expected = learnBackgroundReference(empty[c]);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const BackgroundPixel learned = backgroundPixel(model[scene.gpu_rig.camera(c).pixels_before + i]);
      for (int k = 0; k < 3; ++k)
        error = maxOrNan(error, beyondRounding(learned.mean[k], expected[i].mean[k], 1));
      const double spread = std::min(expected[i].spread, 255.0 * kSpreadStep);  // stored in a byte
      error = maxOrNan(error, beyondRounding(learned.spread, spread, kSpreadStep));
    }
  }
  comparisons.add("background, grey levels", error, 1e-4);
}

/// Marks the pixels around one whose score is so close to a level that single and double precision may
/// disagree.
void exemptAround(std::vector<char>& exempt, const Silhouette& mask, std::size_t pixel) {
  // a different level also affects the neighbours (edges.comp)
  const int x = static_cast<int>(pixel) % mask.width, y = static_cast<int>(pixel) / mask.width;
  for (int v = std::max(y - kSmearReach, 0); v <= std::min(y + kSmearReach, mask.height - 1); ++v)
    for (int u = std::max(x - kSmearReach, 0); u <= std::min(x + kSmearReach, mask.width - 1); ++u)
      exempt[std::size_t(v * mask.width + u)] = 1;
}

/// The number of pixels in a camera's segmentation that differ from the reference away from thresholds.
std::size_t differentlySegmented(const std::vector<std::uint8_t>& bgr, std::span<const std::uint32_t> model,
                                 const Silhouette& segmented) {
  std::vector<double> scores(segmented.pixels.size());
  std::vector<char> exempt(scores.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    scores[i] = scoreReference(Vec3(bgr[3 * i], bgr[3 * i + 1], bgr[3 * i + 2]), backgroundPixel(model[i]));
    for (const double level : {1, 2, 4, 8})
      if (std::abs(scores[i] - level) < kLevelTolerance * level) exemptAround(exempt, segmented, i);
  }
  const Silhouette expected = edgesReference(segmented.width, segmented.height, scores);
  std::size_t different = 0;
  for (std::size_t i = 0; i < scores.size(); ++i)
    different += !exempt[i] && expected.pixels[i] != segmented.pixels[i];
  return different;
}

std::size_t differentPixels(const Silhouette& a, const Silhouette& b) {
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) different += a.pixels[i] != b.pixels[i];
  return different;
}

void compareSilhouettes(CompareScene& scene, Comparisons& comparisons) {
  const Buffer<std::uint32_t>& images = scene.cameras.draw(kPressingFrame);
  scene.recorder.begin();
  scene.silhouettes.record(scene.recorder, images);
  scene.recorder.submitAndWait();
  const std::vector<std::uint32_t> model = scene.silhouettes.model().download();
  const std::vector<Silhouette> segmented = scene.gpu_rig.unpack(scene.silhouettes.segmented().download());
  const std::vector<Silhouette> majority = scene.gpu_rig.unpack(scene.silhouettes.majorityMask().download());
  const std::vector<Silhouette> largest = scene.gpu_rig.unpack(scene.silhouettes.largestMask().download());
  scene.masks = scene.gpu_rig.unpack(scene.silhouettes.masks().host());
  std::size_t segment = 0, speckle = 0, part = 0, holes = 0;
  for (std::size_t c = 0; c < segmented.size(); ++c) {
    const GpuCamera& camera = scene.gpu_rig.camera(c);
    segment += differentlySegmented(scene.image(images.host(), c),
                                    std::span(model).subspan(camera.pixels_before), segmented[c]);
    speckle += differentPixels(majority[c], majorityReference(segmented[c]));
    part += differentPixels(largest[c], largestPartReference(majority[c]));
    holes += differentPixels(scene.masks[c],
                             closeHolesReference(largest[c], largestHole(static_cast<int>(camera.width))));
  }
  comparisons.add("segmentation and edges, pixels", double(segment), 0);
  comparisons.add("majority, pixels", double(speckle), 0);
  comparisons.add("largest part, pixels", double(part), 0);
  comparisons.add("holes, pixels", double(holes), 0);
}

// --- voxel model ---

VoxelGrid compareHull(CompareScene& scene, Comparisons& comparisons) {
  scene.recorder.begin();
  scene.carver.record(scene.recorder, scene.silhouettes.masks());
  scene.recorder.submitAndWait();
  VoxelGrid carved = scene.carver.download();
  const VoxelGrid expected = carveReference(scene.rig, scene.masks, kVoxels);
  const Workspace& workspace = scene.rig.workspace;
  std::size_t different = 0, index = 0;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x, ++index)
        if (carved.occupied[index] != expected.occupied[index])
          different +=
              !isEdgePoint(scene.rig, scene.masks, voxelCenter(workspace, kVoxels, x, y, z), kEdgePixels);
  comparisons.add("carve, voxels", double(different), 0);

  const HullStats counted = scene.carver.stats(), figures = hullStats(carved, workspace);
  comparisons.add("hull volume, voxels", std::abs(double(counted.occupied) - double(figures.occupied)), 0);
  comparisons.add("hull centroid, edges", (counted.centroid - figures.centroid).norm() / workspace.edge_m,
                  1e-12);
  return carved;
}

// --- hand pose ---

/// Poses around the true one, as in the preceding frames. Workspace frame.
std::vector<GpuFit> startsAround(const Pose& truth, const FitModel& model, const Workspace& workspace) {
  std::vector<GpuFit> starts;
  for (int i = 0; i < 6; ++i) {
    const Vec3 axis = Vec3(std::sin(1.0 + i), std::cos(2.0 * i), std::sin(3.0 * i)).normalized();
    const double degrees = i, shift_m = 0.002 * i;
    Pose pose = truth;
    pose.linear() = rotationFromVector(degrees * M_PI / 180 * axis) * truth.linear();
    pose.translation() += shift_m * axis.cross(Vec3(0.36, 0.48, 0.8));
    starts.push_back(fitAt({pose, {}}, model, workspace));
  }
  return starts;
}

/// The largest differences between two lists of fits: position and rotation (radians).
struct FitDifference {
  double position_m = 0, rotation = 0;
};

FitDifference compareFits(CompareScene& scene, const DistanceField& field, const FieldGrid& grid,
                          Fitter& fitter, const FitLimits& limits) {
  const std::vector<float> metres = field.download(grid);
  const std::vector<double> distances(metres.begin(), metres.end());
  const std::vector<GpuFit> starts =
      startsAround(*scene.cameras.pose(kPressingFrame), fitter.model(), scene.rig.workspace);
  const Buffer<GpuFit> fits(scene.gpu, starts);
  scene.recorder.begin();
  fitter.record(scene.recorder, field, grid, fits, static_cast<std::uint32_t>(starts.size()), limits);
  scene.recorder.submitAndWait();
  const std::vector<GpuFit> found = fits.download();
  FitDifference difference;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const GpuFit expected = fitReference(fitter.model(), distances, grid, starts[i], limits);
    const Vec3 apart_m = found[i].pose.position.cast<double>() - expected.pose.position.cast<double>();
    difference.position_m = maxOrNan(apart_m.norm(), difference.position_m);
    difference.rotation =
        maxOrNan(rotationOf(found[i].pose).angularDistance(rotationOf(expected.pose)), difference.rotation);
  }
  return difference;
}

/// Compares the choice among hypotheses, exactly: the first minimum, and whether it counts as tracked.
void compareChoice(CompareScene& scene, Comparisons& comparisons) {
  std::size_t different = 0;
  const Kernel<FitChooseArgs> choose(scene.gpu, "fit_choose", fit_choose_comp);
  const Buffer<GpuFit> result(scene.gpu, 1);
  const Buffer<GpuHandPose> hand(scene.gpu, 1);
  for (const std::vector<float>& outside_m :
       {std::vector<float>{0.003f, 0.001f, 0.001f}, std::vector<float>{0.009f, 0.008f}}) {
    std::vector<GpuFit> hypotheses(outside_m.size());
    for (std::size_t i = 0; i < hypotheses.size(); ++i) {
      hypotheses[i].outside_m = outside_m[i];
      hypotheses[i].iterations = static_cast<std::uint32_t>(i);
    }
    const Buffer<GpuFit> fits(scene.gpu, hypotheses);
    FitChooseArgs args{};
    args.fits = fits;
    args.hull = scene.carver.sums();
    args.result = result;
    args.hand = hand;
    args.count = static_cast<std::uint32_t>(hypotheses.size());
    args.min_occupied = 1;
    args.lost_outside_m = 0.002f;
    scene.recorder.begin();
    scene.recorder.dispatch(choose, args, 1);
    scene.recorder.submitAndWait();
    const GpuFit chosen = result.download().front();
    const auto least = std::min_element(outside_m.begin(), outside_m.end());
    different += chosen.iterations != std::size_t(least - outside_m.begin());
    different += (hand.download().front().tracked != 0) != (*least <= args.lost_outside_m);
  }
  comparisons.add("fit choice, wrong ones", double(different), 0);
}

void compareHand(CompareScene& scene, const VoxelGrid& hull, Comparisons& comparisons) {
  Fitter fitter(scene.gpu, fitModel(builtInHand(false)));
  const FitModel& model = fitter.model();
  const Pose truth = *scene.cameras.pose(kPressingFrame);
  const FieldGrid grid = gridAround(scene.carver, model, fitAt({truth, {}}, model, scene.rig.workspace).pose);
  DistanceField field(scene.gpu);
  scene.recorder.begin();
  field.record(scene.recorder, scene.carver, grid);
  scene.recorder.submitAndWait();
  const std::vector<float> distances = field.download(grid);
  const std::vector<double> expected = distanceReference(hull, grid);
  double error = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    error = maxOrNan(std::abs(distances[i] - expected[i]), error);
  comparisons.add("distance, cells", error / grid.cell_m, 1e-5);

  const FitDifference step = compareFits(scene, field, grid, fitter, {1});
  comparisons.add("fit step, hand's radii and radians",
                  maxOrNan(step.position_m / model.radius_m, step.rotation), 1e-5);
  const FitDifference pose = compareFits(scene, field, grid, fitter, {});
  comparisons.add("fit pose, mm", 1000 * pose.position_m, 0.1);
  comparisons.add("fit pose, degrees", 180 / M_PI * pose.rotation, 0.05);
  compareChoice(scene, comparisons);
}

// --- surface ---

std::vector<Vec3> doubles(const std::vector<vec3>& floats) {
  std::vector<Vec3> result;
  for (const vec3& v : floats) result.push_back(v.cast<double>());
  return result;
}

std::vector<vec3> floats(const std::vector<Vec3>& doubles) {
  std::vector<vec3> result;
  for (const Vec3& v : doubles) result.push_back(v.cast<float>());
  return result;
}

/// The largest difference, relative to the largest expected value.
double relativeError(const std::vector<Vec3>& found, const std::vector<Vec3>& expected) {
  double largest = 0, error = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    largest = std::max(expected[i].norm(), largest);
    error = maxOrNan((found[i] - expected[i]).norm(), error);
  }
  return error / largest;
}

void compareSurface(Gpu& gpu, SubdivisionRule rule, const std::string& rule_name, Comparisons& comparisons) {
  const PolygonMesh cage = presetCage("tube");
  const Subdivision subdivision = subdivide(cage, 2, rule);
  SurfaceEvaluator evaluator(gpu, subdivision);
  const Buffer<vec3> control_points(gpu, floats(cage.points));
  Recorder recorder(gpu);
  recorder.begin();
  evaluator.record(recorder, control_points);
  recorder.submitAndWait();
  const std::vector<Vec3> points = doubles(evaluator.dataPoints().download());
  comparisons.add("subdivide, " + rule_name,
                  relativeError(points, dataPoints(subdivision.matrix, cage.points)), 1e-5);
  // from the kernel's points: rounding of positions matters for small quads
  comparisons.add(
      "normals, " + rule_name,
      relativeError(doubles(evaluator.normals().download()), dataNormals(subdivision.quads, points)), 1e-5);
}

void compareSolve(Gpu& gpu, Comparisons& comparisons) {
  const PolygonMesh cage = presetCage("tube");
  const StencilMatrix matrix = subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix;
  // a palm's width pressed in by a centimetre
  std::vector<vec3> displacements(std::size_t(matrix.rows()), vec3::Zero());
  for (std::size_t i = 0; i < displacements.size() / 3; ++i)
    displacements[i] = vec3(-0.01f, 0.001f * std::sin(float(i)), 0.002f * std::cos(float(3 * i)));
  std::vector<double> exact;
  for (const Vec3& point : cage.points) exact.insert(exact.end(), point.data(), point.data() + 3);
  const Buffer<double> exact_points(gpu, exact);
  const Buffer<vec3> control_points(gpu, floats(cage.points)), targets(gpu, displacements);
  ControlPointSolver solver(gpu, matrix);
  Recorder recorder(gpu);
  recorder.begin();
  solver.record(recorder, targets, exact_points, control_points);
  recorder.submitAndWait();
  const std::vector<double> moved = exact_points.download();
  std::vector<Vec3> found;
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    found.push_back(Vec3(moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]) - cage.points[i]);
  const std::vector<Vec3> expected =
      AllRowsSolver(matrix).controlDisplacements(matrix, doubles(displacements));
  comparisons.add("solve", relativeError(found, expected), 1e-5);
}

// --- contact ---

ContactPoint doubleOf(const GpuContactPoint& point) {
  return {point.position.cast<double>(),
          point.state,
          point.direction.cast<double>(),
          point.depth,
          point.depth_before,
          point.pushed};
}

/// Moves the hand through fixed clay, frame by frame; each frame's check starts from the kernel's previous
/// result.
void compareContact(CompareScene& scene, Comparisons& comparisons) {
  const HandModel hand = builtInHand(false);
  const FitModel model = fitModel(hand);
  const DistanceGrid grid = contactGrid(hand.skin);
  const PolygonMesh cage = presetCage("tube");
  const std::vector<Vec3> surface =
      dataPoints(subdivide(cage, 2, SubdivisionRule::kCatmullClark).matrix, cage.points);
  const Buffer<vec3> data_points(scene.gpu, floats(surface));
  const std::vector<Vec3> rounded = doubles(data_points.download());
  Buffer<GpuHandPose> hands(scene.gpu, 1, Memory::kHost);
  ContactFrame contact_frame(scene.gpu, grid, static_cast<std::uint32_t>(surface.size()));
  ContactFinder finder(scene.gpu, contact_frame);
  std::vector<ContactPoint> points(surface.size());
  ContactPose before;
  double error_m = 0;
  std::size_t reached = 0;
  for (int frame = scene.cameras.backgroundFrames(); frame <= kPressingFrame; frame += 2) {
    hands.host()[0] = gpuHandPose({*scene.cameras.pose(frame), {}}, poseFrame(model, scene.rig.workspace));
    scene.recorder.begin();
    contact_frame.recordBegin(scene.recorder, hands, true);
    finder.recordCheck(scene.recorder, data_points, true);
    scene.recorder.submitAndWait();
    const ContactPose now{rotationOf(hands.host()[0]), hands.host()[0].position.cast<double>()};
    const bool start = frame == scene.cameras.backgroundFrames();
    const std::vector<GpuContactPoint> found = finder.points();
    for (std::size_t i = 0; i < points.size(); ++i) {
      contactReference(grid, {start ? now : before, now, start, true}, rounded[i], points[i]);
      const double found_m = found[i].depth, expected_m = points[i].depth_m;
      // a point that only grazes the hand may be touched by one and not by the other: then its depth is the
      // error
      const double apart_m = found[i].state == points[i].state
                                 ? std::abs(found_m - expected_m)
                                 : std::max(std::abs(found_m), std::abs(expected_m));
      error_m = maxOrNan(apart_m, error_m);
      reached += points[i].state == kPointReached;
      points[i] = doubleOf(found[i]);
    }
    before = now;
  }
  // without contact, nothing was compared
  comparisons.add("contact, mm", reached > 0 ? 1000 * error_m : NAN, 0.01);
}

// --- pull, smooth, symmetry ---

/// The tube with the pressing hand, and the inputs of the tools.
struct ToolScene {
  explicit ToolScene(CompareScene& scene)
      : grid(contactGrid(builtInHand(false).skin)),
        subdivision(subdivide(cage, 2, SubdivisionRule::kCatmullClark)),
        data_points(scene.gpu, floats(dataPoints(subdivision.matrix, cage.points))),
        points(doubles(data_points.download())),
        frame(scene.gpu, grid, static_cast<std::uint32_t>(points.size())),
        hands(scene.gpu, 1, Memory::kHost) {
    moveHand(scene, kPressingFrame);
  }
  void moveHand(const CompareScene& scene, int at_frame) {
    hands.host()[0] = gpuHandPose({*scene.cameras.pose(at_frame), {}},
                                  poseFrame(fitModel(builtInHand(false)), scene.rig.workspace));
  }
  ContactPose pose() const { return {rotationOf(hands.host()[0]), hands.host()[0].position.cast<double>()}; }

  PolygonMesh cage = presetCage("tube");
  DistanceGrid grid;
  Subdivision subdivision;
  Buffer<vec3> data_points;
  std::vector<Vec3> points;
  ContactFrame frame;
  Buffer<GpuHandPose> hands;
};

/// Grips the clay at one pose and moves the hand to another.
void compareGrip(CompareScene& scene, Comparisons& comparisons) {
  ToolScene tools(scene);
  const std::uint32_t mirrors = mirrorsOf({true, false, false});
  tools.frame.setMirrors(mirrors);
  Grip grip(scene.gpu, tools.frame);
  const auto check = [&] {
    scene.recorder.begin();
    tools.frame.recordBegin(scene.recorder, tools.hands, true);
    grip.recordCheck(scene.recorder, tools.data_points, true);
    scene.recorder.submitAndWait();
    return grip.points();
  };
  const std::vector<GpuGripPoint> held = check();
  const ContactPose gripped = tools.pose();
  tools.moveHand(scene, kPressingFrame - 4);
  const std::vector<GpuGripPoint> lagging = check();
  int caught = 0, differ = 0;
  double error_m = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const Vec3& point = tools.points[i];
    const std::uint32_t images = gripReference(tools.grid, gripped, mirrors, point);
    const Vec3 nudge = Vec3::Constant(1e-5);  // points within rounding of the reach may be held or not
    const bool clear = images == gripReference(tools.grid, gripped, mirrors, point + nudge) &&
                       images == gripReference(tools.grid, gripped, mirrors, point - nudge);
    differ += clear && held[i].images != images;
    if (held[i].images == 0) continue;
    ++caught;
    const Vec3 target = gripTarget(gripped, tools.pose(), mirrors, held[i].images, point);
    error_m = maxOrNan((lagging[i].lag.cast<double>() - (target - point)).norm(), error_m);
  }
  comparisons.add("pull, points held", differ, 0);
  comparisons.add("pull, mm", caught > 0 ? 1000 * error_m : NAN, 0.01);
}

void compareRelax(CompareScene& scene, Comparisons& comparisons) {
  ToolScene tools(scene);
  const std::uint32_t mirrors = mirrorsOf({true, false, false});
  const std::vector<Vec3> normals = dataNormals(tools.subdivision.quads, tools.points);
  const Buffer<vec3> device_normals(scene.gpu, floats(normals));
  tools.frame.setMirrors(mirrors);
  Relaxer relaxer(scene.gpu, tools.frame, tools.subdivision);
  constexpr float kStrength = 1;
  for (int i = 0; i < 2; ++i) {  // the first only sets the hand's pose
    scene.recorder.begin();
    tools.frame.recordBegin(scene.recorder, tools.hands, true);
    relaxer.record(scene.recorder, tools.data_points, device_normals, kStrength);
    scene.recorder.submitAndWait();
  }
  std::vector<double> nearness;
  for (const Vec3& point : tools.points)
    nearness.push_back(relaxNearness(tools.grid, tools.pose(), mirrors, point));
  const std::vector<Vec3> expected =
      relaxReference(surfaceNeighbours(tools.subdivision.quads, tools.points.size()), tools.points, normals,
                     nearness, kStrength);
  comparisons.add("smooth", relativeError(doubles(tools.frame.displacements().download()), expected), 1e-4);
}

/// Restores the symmetry of a ball whose points were perturbed.
void compareSymmetry(CompareScene& scene, Comparisons& comparisons) {
  PolygonMesh cage = presetCage("ball");
  const SymmetryOrbits orbits = symmetryOrbits(cage, {true, true, true});
  std::vector<double> exact;
  for (std::size_t i = 0; i < cage.points.size(); ++i) {
    cage.points[i] +=
        1e-3 * Vec3(std::sin(1.0 + double(i)), std::sin(2.0 * double(i)), std::cos(3.0 * double(i)));
    exact.insert(exact.end(), cage.points[i].data(), cage.points[i].data() + 3);
  }
  const Buffer<double> exact_points(scene.gpu, exact);
  const Buffer<vec3> control_points(scene.gpu, cage.points.size());
  const Buffer<std::uint32_t> groups(scene.gpu, std::vector<std::uint32_t>{1, 1, 1});
  SymmetryKeeper keeper(scene.gpu);
  keeper.setOrbits(orbits);
  scene.recorder.begin();
  keeper.recordIndirect(scene.recorder, exact_points, control_points, groups.raw(), 0);
  scene.recorder.submitAndWait();
  averageOrbits(orbits, cage.points);
  exact = exact_points.download();
  double error_m = orbits.points.empty() ? NAN : 0;
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    error_m =
        maxOrNan(error_m, (Vec3(exact[3 * i], exact[3 * i + 1], exact[3 * i + 2]) - cage.points[i]).norm());
  comparisons.add("symmetry, mm", 1000 * error_m, 1e-9);
}

}  // namespace

std::vector<KernelComparison> compareKernels(Gpu& gpu) {
  Comparisons comparisons(gpu.info().name);
  CompareScene scene(gpu);
  compareBackground(scene, comparisons);
  compareSilhouettes(scene, comparisons);
  const VoxelGrid hull = compareHull(scene, comparisons);
  compareHand(scene, hull, comparisons);
  compareOutline(scene, comparisons);
  compareSurface(gpu, SubdivisionRule::kCatmullClark, "catmull-clark", comparisons);
  compareSurface(gpu, SubdivisionRule::kPrinted, "printed", comparisons);
  compareSolve(gpu, comparisons);
  compareContact(scene, comparisons);
  compareGrip(scene, comparisons);
  compareRelax(scene, comparisons);
  compareSymmetry(scene, comparisons);
  return comparisons.take();
}

}  // namespace airclay
