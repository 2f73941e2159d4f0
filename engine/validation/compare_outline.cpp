// SPDX-License-Identifier: MIT
// The kernels of the robust fit and its search against their references, on the demo's images.
#include <algorithm>

#include "engine/hand/hand_model.h"
#include "engine/validation/compare_scene.h"
#include "shaders/hand/outline_judge.comp.h"

namespace airclay {

OutlineScene::OutlineScene(CompareScene& s)
    : scene(s),
      images(s.cameras.draw(kPressingFrame)),
      model(s.silhouettes.model()),
      evidence(s.gpu, s.gpu_rig),
      fitter(s.gpu, s.gpu_rig, outlineModel(builtInHand(false))),
      search(s.gpu, s.gpu_rig, fitter.model()),
      frame(fitter.frame()) {
  const Pose pose = *s.cameras.pose(kPressingFrame);
  truth = outlinePose(pose.linear(), pose * fitter.model().center_of_mass - s.rig.workspace.center, 1);
  // each camera sees a place of its own, about a millimetre from the others'
  frame.velocity = vec3(0.3f, -0.2f, 0.1f);
  frame.spin = vec3(-1, 2, 0.5f);
  for (std::size_t c = 0; c < s.gpu_rig.cameraCount(); ++c) frame.seconds[c] = 0.003f * (float(c) - 1.5f);
}

std::span<const std::uint8_t> OutlineScene::evidenceBytes(const std::vector<std::uint32_t>& words,
                                                          std::size_t camera) const {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
  return std::span(bytes, 4 * words.size()).subspan(firstCell(scene.gpu_rig.camera(camera)));
}

void OutlineScene::fit(const GpuOutlinePose& start, const OutlineStage& stage, const ScalePrior& scale) {
  scene.recorder.begin();
  fitter.record(scene.recorder, frame, start, std::span(&stage, 1), evidence, images, model, scale);
  scene.recorder.submitAndWait();
}

namespace {

constexpr OutlineStage kCoarse = {1, false, 24, 10}, kFine = {1, true, 0, 0};
constexpr ScalePrior kPrior = {0.01, 400};
// Pixels carry rounding errors of up to 6e-5; a line whose reference changes when its edge moves by this much
// depends on a sample at the border of a pixel, and is exempt.
constexpr double kNudge_px = 2e-4;

/// A pose near the truth, and a size that differs from the model's.
GpuOutlinePose near(const GpuOutlinePose& truth, double shift_m, double turn, double scale) {
  return outlinePose(rotationFromVector(turn * Vec3(0.48, -0.6, 0.64)) * rotationOf(truth),
                     truth.position.cast<double>() + shift_m * Vec3(0.6, 0.64, -0.48), scale);
}

/// The buffers of a step in a camera.
struct OutlineStep {
  OutlineStep(const OutlineScene& scene, const GpuOutlinePose& pose)
      : s(scene),
        start(pose),
        pixels(s.fitter.pixels().download()),
        lists(s.fitter.lists().download()),
        evidence(s.evidence.evidence().download()),
        model(s.model.download()),
        lines(s.fitter.lines().download()),
        masks(s.scene.gpu_rig.unpack(s.fitter.masks().download())) {
    for (std::size_t c = 0; c < masks.size(); ++c) images.push_back(s.scene.image(s.images.host(), c));
  }
  std::span<const std::uint32_t> list(std::size_t c) const {
    return std::span(lists).subspan(c * kOutlineList + 1, lists[c * kOutlineList]);
  }
  std::span<const GpuOutlineLine> linesOf(std::size_t c) const {
    return std::span(lines).subspan(c * kOutlineLines, lists[c * kOutlineList]);
  }
  std::vector<std::optional<Vec2>> pixelsOf(std::size_t c) const {
    std::vector<std::optional<Vec2>> own;
    const std::size_t count = s.fitter.model().vertices.size();
    for (std::size_t i = c * count; i < (c + 1) * count; ++i)
      own.push_back(pixels[i].x() > kNotProjected ? std::optional<Vec2>(pixels[i].cast<double>())
                                                  : std::nullopt);
    return own;
  }
  OutlineView view(std::size_t c) const {
    OutlineView view;
    view.camera = &s.scene.rig.cameras[c];
    view.workspace = &s.scene.rig.workspace;
    view.model = &s.fitter.model();
    view.pose = movedPose(start, s.frame, s.frame.seconds[c]);
    view.pixels = pixelsOf(c);
    view.mask = masks[c];
    view.arm_from = s.fitter.forearms().host()[2 * c];
    view.arm_to = s.fitter.forearms().host()[2 * c + 1];
    view.velocity = s.frame.velocity.cast<double>();
    view.spin = s.frame.spin.cast<double>();
    view.evidence = s.evidenceBytes(evidence, c);
    view.region = s.evidence.regions().host()[c];
    view.image = images[c];
    view.background = std::span(model).subspan(s.scene.gpu_rig.camera(c).pixels_before);
    view.gain = Eigen::Map<const vec3>(&s.evidence.gains().host()[4 * c]).cast<double>();
    return view;
  }

  const OutlineScene& s;
  GpuOutlinePose start;
  std::vector<vec2> pixels;
  std::vector<std::uint32_t> lists, evidence, model;
  std::vector<GpuOutlineLine> lines;
  std::vector<Silhouette> masks;
  std::vector<std::vector<std::uint8_t>> images;
};

/// Whether a pixel's centre is within rounding of a triangle's side.
bool isAtSide(const OutlineModel& model, const std::vector<std::optional<Vec2>>& pixels, const Vec2& point) {
  for (const GpuTriangle& triangle : model.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<Vec2>&from = pixels[triangle.corners[k]],
            &to = pixels[triangle.corners[(k + 1) % 3]];
      if (!from || !to || (*to - *from).norm() == 0) continue;
      const Vec2 along = *to - *from;
      const double place = std::clamp((point - *from).dot(along) / along.squaredNorm(), 0.0, 1.0);
      if ((point - *from - place * along).norm() < 1e-3) return true;
    }
  return false;
}

void compareProjection(const OutlineStep& step, Comparisons& comparisons) {
  const OutlineScene& s = step.s;
  double error = 0;
  std::size_t mask_different = 0, edges_different = 0, edges = 0;
  for (std::size_t c = 0; c < step.masks.size(); ++c) {
    const Camera& camera = s.scene.rig.cameras[c];
    const OutlineView view = step.view(c);
    const auto expected = projectReference(camera, s.scene.rig.workspace, s.fitter.model(), view.pose);
    for (std::size_t i = 0; i < expected.size(); ++i)
      error = maxOrNan(error, expected[i] && view.pixels[i] ? (*view.pixels[i] - *expected[i]).norm() : NAN);
    const auto arm = forearmReference(camera, s.scene.rig.workspace, s.frame, view.pose);
    error = maxOrNan(error, double((arm[0] - view.arm_from).norm()));
    error = maxOrNan(error, double((arm[1] - view.arm_to).norm()));

    const Silhouette mask = maskReference(camera, s.fitter.model(), view.pixels);
    for (std::size_t i = 0; i < mask.pixels.size(); ++i)
      if (mask.pixels[i] != view.mask.pixels[i])
        mask_different +=
            !isAtSide(s.fitter.model(), view.pixels,
                      Vec2(double(i % std::size_t(mask.width)), double(i / std::size_t(mask.width))));
    const std::vector<std::uint32_t> list = listReference(s.fitter.model(), view.pixels);
    edges += list.size();
    edges_different += !std::ranges::equal(list, step.list(c));
  }
  comparisons.add("outline vertices and forearm, px", error, 1e-3);
  comparisons.add("outline mask, pixels", double(mask_different), 0);
  comparisons.add("silhouette edges, cameras", edges > 0 ? double(edges_different) : NAN, 0);
}

/// The differences between a camera's lines and their references.
struct LineErrors {
  double offset_px = 0, weight = 0, row = 0, blur_px = 0;
  std::size_t compared = 0, exempt = 0;
};

template <class Reference>
void compareLines(OutlineView& view, std::span<const std::uint32_t> list,
                  std::span<const GpuOutlineLine> lines, const LineErrors& tolerance, LineErrors& errors,
                  Reference reference) {
  const double radius_m = view.model->radius_m;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const GpuOutlineEdge& edge = view.model->edges[list[i]];
    const OutlineLine expected = reference(view, list[i]);
    bool is_clear = true;
    for (int k = 0; k < 4 && is_clear; ++k) {
      const Vec2 nudge = kNudge_px * Vec2(k % 2 * 2 - 1, k / 2 * 2 - 1);
      *view.pixels[edge.from] += nudge;
      *view.pixels[edge.to] += nudge;
      const OutlineLine other = reference(view, list[i]);
      *view.pixels[edge.from] -= nudge;
      *view.pixels[edge.to] -= nudge;
      is_clear = std::abs(other.offset - expected.offset) < tolerance.offset_px &&
                 std::abs(other.weight - expected.weight) < tolerance.weight &&
                 (other.length > 0) == (expected.length > 0);
    }
    errors.exempt += !is_clear;
    if (!is_clear) continue;
    const GpuOutlineLine& found = lines[i];
    if (std::abs(found.length_ - expected.length) > 1e-3) errors.offset_px = NAN;
    errors.weight = maxOrNan(errors.weight, std::abs(found.weight - expected.weight));
    errors.blur_px = maxOrNan(errors.blur_px, std::abs(found.blur - expected.blur));
    if (!(expected.weight > 0)) continue;
    ++errors.compared;
    errors.offset_px = maxOrNan(errors.offset_px, std::abs(found.offset - expected.offset));
    // relative to the largest possible motion of a point of the hand
    Eigen::Matrix<double, 7, 1> row =
        Eigen::Map<const Eigen::Matrix<float, 7, 1>>(found.row).cast<double>() - expected.row;
    row.tail<4>() /= radius_m;
    errors.row = maxOrNan(errors.row, row.cwiseAbs().maxCoeff() / expected.row.head<3>().norm());
  }
}

template <class Reference>
LineErrors compareLines(const OutlineStep& step, const LineErrors& tolerance, Reference reference) {
  LineErrors errors;
  for (std::size_t c = 0; c < step.masks.size(); ++c) {
    OutlineView view = step.view(c);
    compareLines(view, step.list(c), step.linesOf(c), tolerance, errors, reference);
  }
  if (errors.compared < 100 || errors.exempt > errors.compared / 2) errors.offset_px = NAN;
  return errors;
}

void compareSolve(const OutlineStep& step, const ScalePrior& scale, double& step_error, double& sum_error) {
  const OutlineScene& s = step.s;
  std::vector<std::vector<GpuOutlineLine>> lines;
  for (std::size_t c = 0; c < step.masks.size(); ++c)
    lines.emplace_back(step.linesOf(c).begin(), step.linesOf(c).end());
  const GpuOutlineFit expected = solveReference(step.start, lines, scale), &found = s.fitter.result();
  step_error = maxOrNan(step_error, (found.pose.position - expected.pose.position).cast<double>().norm() /
                                        s.fitter.model().radius_m);
  step_error = maxOrNan(step_error, angleBetween(rotationOf(found.pose), rotationOf(expected.pose)));
  step_error = maxOrNan(step_error, std::abs(double(found.pose.scale) - expected.pose.scale));
  const auto relative = [&](double a, double b, double size) {
    sum_error = maxOrNan(sum_error, std::abs(a - b) / size);
  };
  int k = 0;
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column <= row; ++column, ++k) {
      const auto diagonal = [&](int i) { return double(expected.information[i * (i + 3) / 2]); };
      relative(found.information[k], expected.information[k], std::sqrt(diagonal(row) * diagonal(column)));
    }
  relative(found.residual, expected.residual, expected.residual);
  relative(found.weight, expected.weight, expected.weight);
  relative(found.lines, expected.lines, 1);
  for (std::size_t c = 0; c < lines.size(); ++c) {
    relative(found.camera_length[c], expected.camera_length[c], expected.camera_length[c]);
    relative(found.camera_good[c], expected.camera_good[c], expected.camera_length[c]);
  }
}

void compareFit(OutlineScene& s, Comparisons& comparisons) {
  double step_error = 0, sum_error = 0;
  const GpuOutlinePose far = near(s.truth, 0.004, 0.05, 1.02);
  s.fit(far, kCoarse, kPrior);
  const OutlineStep coarse(s, far);
  compareProjection(coarse, comparisons);
  // A line with little evidence divides by a small difference of two informations.
  const LineErrors coarse_tolerance{0.002, 2e-4, 1e-3, 1e-3};
  const LineErrors coarse_errors =
      compareLines(coarse, coarse_tolerance, [](const OutlineView& view, std::uint32_t edge) {
        return coarseReference(view, edge, kCoarse.reach, kCoarse.spread);
      });
  compareSolve(coarse, kPrior, step_error, sum_error);

  const GpuOutlinePose close = near(s.truth, 0.0005, 0.005, 1);
  s.fit(close, kFine, {});
  const OutlineStep fine(s, close);
  // Costs are differences of sums of squares up to 11 · 3 · 255², in single precision.
  const LineErrors fine_tolerance{0.005, 0.02, 1e-3, 1e-3};
  const LineErrors fine_errors = compareLines(fine, fine_tolerance, fineReference);
  compareSolve(fine, {}, step_error, sum_error);

  comparisons.add("coarse lines, px", coarse_errors.offset_px, coarse_tolerance.offset_px);
  comparisons.add("coarse lines, weight", coarse_errors.weight, coarse_tolerance.weight);
  comparisons.add("fine lines, px", fine_errors.offset_px, fine_tolerance.offset_px);
  comparisons.add("fine lines, weight", fine_errors.weight, fine_tolerance.weight);
  // differences of pixels 4 mm apart
  comparisons.add("line derivatives, relative", maxOrNan(coarse_errors.row, fine_errors.row), 1e-3);
  comparisons.add("line blur, px", maxOrNan(coarse_errors.blur_px, fine_errors.blur_px), 1e-3);
  comparisons.add("outline sums, relative", sum_error, 1e-5);
  comparisons.add("outline step, hand's radii and radians", step_error, 1e-4);
}

/// Whether a fit counts as tracked, exactly.
void compareJudge(CompareScene& scene, Comparisons& comparisons) {
  const Kernel<OutlineJudgeArgs> judge(scene.gpu, "outline_judge", outline_judge_comp);
  const Buffer<GpuHandPose> hand(scene.gpu, kMaxHands);
  std::size_t different = 0, tracked = 0;
  // the outline that agrees, of 100 pixels per camera; one sees too little
  const std::vector<std::array<float, 3>> agreements = {{90, 80, 10}, {90, 49, 41}, {55, 55, 55},
                                                        {90, 90, 0},  {90, 90, 20}, {61, 61, 61}};
  for (const auto& good : agreements) {
    GpuOutlineFit fit{};
    fit.pose = outlinePose(Mat3::Identity(), Vec3(1, 2, 3), 1);
    for (std::size_t c = 0; c < good.size(); ++c) {
      fit.camera_length[c] = 100;
      fit.camera_good[c] = good[c];
    }
    fit.camera_length[3] = fit.camera_good[3] = 20;
    const Buffer<GpuOutlineFit> fits(scene.gpu, std::vector<GpuOutlineFit>{fit});
    OutlineJudgeArgs args{};
    args.fit = fits;
    args.hand = hand;
    args.cameras = 4;
    scene.recorder.begin();
    scene.recorder.dispatch(judge, args, 1);
    scene.recorder.submitAndWait();
    const GpuHandPose found = hand.download().front();
    const bool expected = judgeReference(fit, args.cameras);
    tracked += expected;
    different += (found.tracked != 0) != expected || found.position != fit.pose.position ||
                 found.rotation != fit.pose.rotation;
  }
  const bool is_both = tracked > 0 && tracked < agreements.size();
  comparisons.add("outline judgement, wrong ones", is_both ? double(different) : NAN, 0);
}

// --- search ---

double blockError(const OutlineScene& s, const std::vector<std::uint32_t>& blocks) {
  const std::vector<std::uint32_t> evidence = s.evidence.evidence().download();
  double error = 0;
  for (std::size_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) {
    const GpuCamera& camera = s.scene.gpu_rig.camera(c);
    const auto [columns, rows] = tilesOf(camera);
    for (std::uint32_t y = 0; y < 2 * rows; ++y)
      for (std::uint32_t x = 0; x < 2 * columns; ++x) {
        const std::uint32_t word = blocks[firstTile(camera) + y / 2 * columns + x / 2];
        const double found = double(word >> (16 * (y % 2) + 8 * (x % 2)) & 255) / 255;
        const double exact = blockReference(s.evidenceBytes(evidence, c), columns, int(x), int(y));
        error = maxOrNan(error, beyondRounding(found, exact, 1.0 / 255));
      }
  }
  return error;
}

/// The number of voxels that differ away from the threshold and the borders of blocks.
double differentVoxels(const OutlineScene& s, const std::vector<std::uint32_t>& blocks) {
  const double voxel_m = s.scene.rig.workspace.edge_m / kHullVoxels, level = std::log(kHullProbability);
  const auto isHand = [&](const Vec3& point, double tolerance) {
    const std::optional<double> mean = hullReference(s.scene.gpu_rig, blocks, s.frame.cameras, point);
    return mean && *mean > level + tolerance;
  };
  std::size_t different = 0, set = 0;
  for (std::uint32_t i = 0; i < kHullVoxels * kHullVoxels * kHullVoxels; ++i) {
    const Vec3 index(i % kHullVoxels, i / kHullVoxels % kHullVoxels, i / (kHullVoxels * kHullVoxels));
    const Vec3 center = voxel_m * (index + Vec3::Constant(0.5 - 0.5 * kHullVoxels));
    const bool found = (s.search.hull().host()[i / kHullRun] >> (i % kHullRun) & 1) != 0;
    set += found;
    if (found == isHand(center, 0)) continue;
    bool is_clear = isHand(center, 1e-5) == isHand(center, -1e-5);
    for (int k = 0; k < 8 && is_clear; ++k) {
      const Vec3 nudge = 1e-6 * Vec3(k % 2 * 2 - 1, k / 2 % 2 * 2 - 1, k / 4 * 2 - 1);
      is_clear = found != isHand(center + nudge, 0);
    }
    different += is_clear;
  }
  return set > 0 ? double(different) : NAN;
}

double scoreError(OutlineScene& s, const std::vector<std::uint32_t>& blocks) {
  std::vector<GpuOutlinePose> poses;
  for (int i = 0; i < 12; ++i) poses.push_back(near(s.truth, 0.005 * i, 0.2 * i, 1));
  StageTimes stage_ms;
  s.search.scores(s.scene.recorder, s.frame, poses, stage_ms);
  const std::size_t cameras = s.scene.gpu_rig.cameraCount();
  double error = 0;
  std::size_t compared = 0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (std::size_t c = 0; c < cameras; ++c) {
      const auto score = [&](const Vec3& nudge) {
        GpuOutlinePose pose = poses[i];
        pose.position += nudge.cast<float>();
        return scoreReference(s.scene.gpu_rig, c, s.fitter.model(), s.frame, pose, blocks);
      };
      const double expected = score(Vec3::Zero());
      bool is_clear = true;  // no point of the skin at the border of a cell
      for (int k = 0; k < 8 && is_clear; ++k)
        is_clear =
            std::abs(score(5e-7 * Vec3(k % 2 * 2 - 1, k / 2 % 2 * 2 - 1, k / 4 * 2 - 1)) - expected) < 1e-9;
      if (!is_clear) continue;
      ++compared;
      error = maxOrNan(error, std::abs(s.search.cameraScores().host()[i * cameras + c] - expected));
    }
  return compared >= 10 ? error : NAN;
}

void compareSearch(OutlineScene& s, Comparisons& comparisons) {
  StageTimes stage_ms;
  s.search.candidates(s.scene.recorder, s.evidence, s.frame, 1, 1, stage_ms);
  const std::vector<std::uint32_t> blocks = s.search.blocks().download();
  comparisons.add("search blocks", blockError(s, blocks), 1e-4);
  comparisons.add("search hull, voxels", differentVoxels(s, blocks), 0);
  comparisons.add("search scores", scoreError(s, blocks), 1e-4);
}

}  // namespace

void compareOutline(CompareScene& scene, Comparisons& comparisons) {
  OutlineScene outline(scene);
  compareEvidence(outline, comparisons);
  compareFit(outline, comparisons);
  compareJudge(scene, comparisons);
  compareSearch(outline, comparisons);
}

}  // namespace airclay
