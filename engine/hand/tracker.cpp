// SPDX-License-Identifier: MIT
#include "engine/hand/tracker.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "shaders/hand/fit_choose.comp.h"

namespace airclay {
namespace {

// The hand's largest motion between two frames, including the border for interpolation.
constexpr double kMaxMotion_m = 0.03;  // m
// Orientations of the coarse search. Adjacent ones are about 25° apart, and the fit converges from half of
// that.
constexpr int kCoarseRotations = 600;
constexpr int kCoarseIterations = 12;
constexpr int kThinning = 8;  // every eighth patch: about 300 suffice to distinguish 25°
constexpr std::size_t kMiddleCandidates = 40, kFineCandidates = 8;
// Candidates closer than this count as one.
constexpr double kSamePosition_m = 0.005, kSameRotation_rad = 0.05;
constexpr int kMaxFits = 3 * kCoarseRotations;
// A search consists of many short submissions, so that a window can draw in between; each has as many fits as
// take about this long. The results do not depend on it.
constexpr double kSlice_ms = 8;
constexpr std::size_t kFirstSlice = 2;
// The hand counts as lost if its patches are farther outside than this on average; a good fit has a tenth of
// a cell.
constexpr double kLostCells = 0.4, kLostDistance_m = 0.002;
// The weight of a completely uncovered voxel model in the score, in metres of outside distance. A flipped
// hand leaves a third uncovered, but changes the outside distance by only a few tenths of a millimetre.
constexpr double kUncoveredWeight_m = 0.004;

double score(const GpuFit& fit, double uncovered) {
  return fit.outside_m + kUncoveredWeight_m * uncovered;
}

Eigen::Quaterniond rotationOf(const GpuFit& fit) {
  return Eigen::Quaterniond(Eigen::Vector4d(fit.pose.rotation.cast<double>()));
}

GpuFit startAt(const Eigen::Quaterniond& rotation, const Vec3& position) {
  GpuFit fit{};
  fit.pose = noHandPose();
  fit.pose.rotation = rotation.coeffs().cast<float>();
  fit.pose.position = position.cast<float>();
  return fit;
}

}  // namespace

std::vector<Eigen::Quaterniond> uniformRotations(int count) {
  const double phi = std::sqrt(2.0), psi = 1.533751168755204288118041;  // the article's constants
  std::vector<Eigen::Quaterniond> rotations;
  for (int i = 0; i < count; ++i) {
    const double s = i + 0.5, t = s / count, d = 2 * M_PI * s;
    const double r = std::sqrt(t), big_r = std::sqrt(1 - t), alpha = d / phi, beta = d / psi;
    rotations.emplace_back(big_r * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha),
                           big_r * std::sin(beta));
  }
  return rotations;
}

FieldGrid gridAround(const Carver& carver, const FitModel& model, const GpuHandPose& pose) {
  const Mat3 turn = rotationOf(pose).toRotationMatrix();
  Eigen::AlignedBox3d box;
  for (const GpuPatch& patch : model.patches) box.extend(Vec3(turn * patch.center.cast<double>()));
  return placeField(carver, pose.position.cast<double>() + box.center(),
                    0.5 * box.sizes() + Vec3::Constant(kMaxMotion_m));
}

HandTracker::HandTracker(Gpu& gpu, const GpuRig& rig, const HandModel& hand, const Carver& carver)
    : gpu_(gpu),
      rig_(rig),
      carver_(carver),
      fitter_(gpu, fitModel(hand)),
      coarse_fitter_(gpu, thinned(fitter_.model(), kThinning)),
      choose_(gpu, "fit_choose", fit_choose_comp),
      field_(gpu),
      // 5 mm: only distinguishes covered from uncovered cells of a centimetre
      hand_distance_(signedDistanceGrid(hand.skin, 0.005, 0.02)),
      fits_(gpu, kMaxFits, Memory::kHost),
      result_(gpu, 1, Memory::kHost),
      hands_(gpu, kMaxHands, Memory::kHost) {
  std::ranges::fill(hands_.host(), noHandPose());
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : hand.skin.vertices) box.extend(vertex);
  hand_low_ = box.min();
  hand_high_ = box.max();
  // a hull is larger than its hand; half the hand's volume is a hand that is just entering
  const double hand_m3 = massProperties(hand.skin).volume_m3;
  min_occupied_ =
      static_cast<std::uint32_t>(std::max(1.0, 0.5 * hand_m3 / std::pow(carver.voxelMetres(), 3)));
}

bool HandTracker::isEmpty() const {
  return carver_.stats().occupied < min_occupied_;
}

FitChooseArgs HandTracker::chooseArgs(std::uint32_t count, double cell_m) const {
  FitChooseArgs args{};
  args.fits = fits_;
  args.hull = carver_.sums();
  args.result = result_;
  args.hand = hands_;
  args.count = count;
  args.min_occupied = min_occupied_;
  args.lost_outside_m = static_cast<float>(std::max(kLostDistance_m, kLostCells * cell_m));
  return args;
}

void HandTracker::recordTracking(Recorder& recorder) {
  std::uint32_t count = 1;
  fits_.host()[0] = last_;
  if (frames_ >= 2) {
    // the last motion repeated
    const Eigen::Quaterniond turn = rotationOf(last_) * rotationOf(before_last_).conjugate();
    const Vec3 position = last_.pose.position.cast<double>(),
               before = before_last_.pose.position.cast<double>();
    fits_.host()[1] = startAt((turn * rotationOf(last_)).normalized(), 2 * position - before);
    std::ranges::copy(last_.pose.joint_angles, fits_.host()[1].pose.joint_angles);
    count = 2;
  }
  const FieldGrid grid = gridAround(carver_, model(), last_.pose);
  field_.record(recorder, carver_, grid);
  fitter_.record(recorder, field_, grid, fits_, count, {});
  recorder.dispatch(choose_, chooseArgs(count, grid.cell_m), 1);
}

HandFit HandTracker::finish() {
  const GpuFit& found = result_.host()[0];
  HandFit fit;
  fit.pose = handPose(found.pose, poseFrame(model(), rig_.rig().workspace));
  fit.outcome = static_cast<FitOutcome>(found.outcome);
  fit.iterations = static_cast<int>(found.iterations);
  fit.outside_m = found.outside_m;
  fit.outside_fraction = found.outside_fraction;
  fit.tracked = found.pose.tracked != 0;
  if (fit.tracked) {
    before_last_ = last_;
    last_ = found;
    ++frames_;
  } else {
    forget();
  }
  return fit;
}

std::vector<Vec3> HandTracker::occupiedCells(const FieldGrid& grid) const {
  const std::vector<float> distances = field_.download(grid);
  const auto& size = grid.place.size;
  std::vector<Vec3> cells;
  for (std::size_t i = 0; i < distances.size(); ++i)
    if (distances[i] < 0)
      cells.push_back(grid.low + grid.cell_m * Vec3(double(i % size[0]), double(i / size[0] % size[1]),
                                                    double(i / (size[0] * size[1]))));
  return cells;
}

double HandTracker::uncovered(const GpuFit& fit, const std::vector<Vec3>& cells, double cell_m) const {
  const Mat3 hand_from_workspace = rotationOf(fit).normalized().toRotationMatrix().transpose();
  const Vec3 position = fit.pose.position.cast<double>();
  int near = 0, uncovered_cells = 0;
  for (const Vec3& cell : cells) {
    const Vec3 in_hand = hand_from_workspace * (cell - position) + model().center_of_mass;
    if ((in_hand.array() < hand_low_.array() - cell_m).any() ||
        (in_hand.array() > hand_high_.array() + cell_m).any())
      continue;
    ++near;
    uncovered_cells += sample(hand_distance_, in_hand) > cell_m;
  }
  return near > 0 ? double(uncovered_cells) / near : 1;
}

void HandTracker::selectBest(std::vector<Candidate>& candidates, const std::vector<Vec3>& cells,
                             double cell_m, std::size_t count) const {
  for (Candidate& candidate : candidates) candidate.uncovered = uncovered(candidate.fit, cells, cell_m);
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return score(a.fit, a.uncovered) < score(b.fit, b.uncovered);
  });
  // many starts converge to the same pose, of which one is enough
  std::vector<Candidate> selected;
  for (const Candidate& candidate : candidates) {
    const bool new_pose = std::none_of(selected.begin(), selected.end(), [&](const Candidate& other) {
      return (candidate.fit.pose.position - other.fit.pose.position).norm() < kSamePosition_m &&
             rotationOf(candidate.fit).angularDistance(rotationOf(other.fit)) < kSameRotation_rad;
    });
    if (new_pose) selected.push_back(candidate);
    if (selected.size() == count) break;
  }
  candidates = std::move(selected);
}

std::vector<GpuFit> HandTracker::starts(const std::vector<Candidate>& candidates) {
  std::vector<GpuFit> fits;
  for (const Candidate& candidate : candidates) fits.push_back(candidate.fit);
  return fits;
}

std::vector<GpuFit> HandTracker::searchStarts(const std::vector<Vec3>& cells) const {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& cell : cells) mean += cell / double(cells.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& cell : cells) spread += (cell - mean) * (cell - mean).transpose() / double(cells.size());
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);
  // a hand at the end of an arm is about 1.4 standard deviations from the centroid
  const Vec3 along = 1.4 * std::sqrt(axes.eigenvalues()[2]) * axes.eigenvectors().col(2);
  std::vector<GpuFit> fits;
  for (const Vec3& position : {mean, Vec3(mean + along), Vec3(mean - along)})
    for (const Eigen::Quaterniond& rotation : uniformRotations(kCoarseRotations))
      fits.push_back(startAt(rotation, position));
  return fits;
}

void HandTracker::recordField(Recorder& recorder, const FieldGrid& grid, StageTimes& stage_ms) {
  recorder.begin();
  recorder.stage("fit");
  field_.record(recorder, carver_, grid);
  recorder.submitAndWait();
  addStages(recorder.stageMs(), stage_ms);
}

std::vector<HandTracker::Candidate> HandTracker::fitAll(Recorder& recorder, Fitter& fitter,
                                                        const FieldGrid& grid,
                                                        const std::vector<GpuFit>& starts, int iterations,
                                                        StageTimes& stage_ms) {
  std::vector<Candidate> candidates;
  std::size_t slice = kFirstSlice;
  while (candidates.size() < starts.size()) {
    const std::size_t first = candidates.size(), count = std::min(slice, starts.size() - first);
    std::copy_n(starts.begin() + std::ptrdiff_t(first), count, fits_.host().begin());
    recorder.begin();
    recorder.stage("fit");
    fitter.record(recorder, field_, grid, fits_, static_cast<std::uint32_t>(count), {iterations});
    recorder.submitAndWait();
    addStages(recorder.stageMs(), stage_ms);
    for (std::size_t i = 0; i < count; ++i) candidates.push_back({fits_.host()[i], 0});
    const double slice_ms = std::max(recorder.stageMs().front().second, 0.1);
    slice = std::clamp<std::size_t>(std::size_t(double(count) * kSlice_ms / slice_ms), 1, kMaxFits);
  }
  return candidates;
}

bool HandTracker::search(Recorder& recorder, StageTimes& stage_ms) {
  forget();
  if (isEmpty()) return false;
  // the whole workspace, in coarse cells
  const double edge_m = rig_.rig().workspace.edge_m;
  const FieldGrid grid = placeField(carver_, Vec3::Zero(), Vec3::Constant(0.5 * edge_m));
  recordField(recorder, grid, stage_ms);
  const std::vector<Vec3> cells = occupiedCells(grid);
  if (cells.empty()) return false;

  std::vector<Candidate> candidates =
      fitAll(recorder, coarse_fitter_, grid, searchStarts(cells), kCoarseIterations, stage_ms);
  selectBest(candidates, cells, grid.cell_m, kMiddleCandidates);
  candidates = fitAll(recorder, fitter_, grid, starts(candidates), FitLimits{}.iterations, stage_ms);
  selectBest(candidates, cells, grid.cell_m, kFineCandidates);

  // around the best, in the smallest cells that cover the hand in any orientation; the other candidates are
  // mostly at the same position
  const FieldGrid fine = placeField(carver_, candidates.front().fit.pose.position.cast<double>(),
                                    Vec3::Constant(model().radius_m + kMaxMotion_m));
  recordField(recorder, fine, stage_ms);
  candidates = fitAll(recorder, fitter_, fine, starts(candidates), FitLimits{}.iterations, stage_ms);
  selectBest(candidates, cells, grid.cell_m, 1);
  last_ = candidates.front().fit;
  has_pose_ = true;
  frames_ = 0;
  return true;
}

}  // namespace airclay
