// SPDX-License-Identifier: MIT
#include "engine/hand/robust_tracker.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "shaders/hand/outline_judge.comp.h"

namespace airclay {
namespace {

constexpr double kFrame_s = 1.0 / 30;  // where frames have no times
// A longer gap, or a hand that would have moved farther than this, leaves the motion unknown.
constexpr double kLongestGap_s = 0.2;
constexpr double kFastest_m_s = 3, kFastest_rad_s = 30;

// Following with a known motion, after a search, and refining a candidate of the search. Reach and spread in
// pixels.
constexpr OutlineStage kFollow[] = {{3, false, 24, 10}, {2, false, 10, 4}, {2, true}, {1, true}};
// The same where the motion is as expected: the hand was within kExpected_m of its prediction in the last
// frame.
constexpr OutlineStage kFollowExpected[] = {
    {1, false, 24, 10}, {1, false, 10, 4, false}, {2, true}, {1, true}};
constexpr double kExpected_m = 0.004;
constexpr OutlineStage kCatch[] = {{2, false, 40, 20}, {2, false, 40, 20}, {2, false, 20, 8},
                                   {2, false, 10, 4},  {1, false, 10, 4},  {2, true},
                                   {1, true}};
constexpr OutlineStage kRefine[] = {
    {2, false, 40, 20}, {2, false, 40, 20}, {2, false, 20, 8}, {2, false, 10, 4}, {1, true}};
constexpr std::size_t kCandidatesPerEnd = 4;
// A pose of the search is chosen by its score, less this times its outline's agreement.
constexpr double kAgreementWeight = 0.1;
// Searches in successive frames differ: a hand of another colour than the background; one of its colour, but
// without its texture; and one that only its brightness tells from the background.
constexpr std::array<EvidenceAssumptions, 3> kAttempts = {
    {{kFullShadow, 0}, {kFullShadow, kTextureTrust}, {kDaylight, kTextureTrust}}};

// Evidence around the projected hand, pixels of an image 640 pixels wide.
constexpr double kFollowMargin = 40, kCatchMargin = 90;
// The hand's size: most hands are within 5 % of the model. Each frame adds a fraction of what its lines
// tell, because neighbouring lines err alike; a hand that is found again may be another one.
constexpr double kScaleDeviation = 0.025, kFoundScaleDeviation = 0.02, kBestScaleDeviation = 0.003;
constexpr double kScaleTrust = 0.05;
// After this many frames, a hand whose size is within kOwnSize of the model's counts as the model's: the
// small rest is the bias of shaded edges.
constexpr int kScaleFrames = 15;
constexpr double kOwnSize = 0.02;
constexpr int kUncertainLimit = 3;  // frames, then the hand is searched for
// Weight of new colours while one camera learns per frame.
constexpr double kLearningRate = 0.4;

// A line's weight is cautious: it tells this multiple of it. What all lines share, the bias of shaded edges
// and of the model, does not average out. A hand that moves otherwise than expected is blurred otherwise than
// expected, is elsewhere at each camera's own time, and leaves the fit a longer way to go: errors grow in
// proportion to the surprise. From the errors on rendered rooms.
constexpr double kLineInformation = 1.5;
constexpr double kBiasShift_m = 0.00005, kBiasTurn_rad = 0.0017;
constexpr double kShiftPerSurprise = 0.115, kTurnPerSurprise = 1.15;  // 1 and rad/m

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

/// The information matrix of position, rotation vector and logarithm of the scale.
Matrix7 informationOf(const GpuOutlineFit& fit) {
  Matrix7 all;
  int k = 0;
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column <= row; ++column) all(row, column) = all(column, row) = fit.information[k++];
  return all;
}

/// The covariance of position and rotation. A scale that is estimated adds to it. `surprise_m`: how far the
/// hand was from where it was expected.
Matrix6 covarianceOf(const GpuOutlineFit& fit, const ScalePrior& scale, double surprise_m) {
  Matrix7 information = informationOf(fit);
  information(6, 6) += scale.weight / kLineInformation;
  Matrix6 own = information.topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, 1> both = information.topRightCorner<6, 1>();
  if (scale.weight > 0 && information(6, 6) > 0) own -= both * both.transpose() / information(6, 6);
  own.diagonal().array() += 1e-9 * own.trace() + 1e-9;
  Matrix6 covariance = own.ldlt().solve(Matrix6::Identity()) / kLineInformation;
  const auto square = [](double x) { return x * x; };
  covariance.diagonal().head<3>().array() += square(kBiasShift_m) + square(kShiftPerSurprise * surprise_m);
  covariance.diagonal().tail<3>().array() += square(kBiasTurn_rad) + square(kTurnPerSurprise * surprise_m);
  return covariance;
}

/// The fraction of the outline that the images confirm.
double agreementOf(const GpuOutlineFit& fit, std::uint32_t cameras) {
  double length = 0, good = 0;
  for (std::uint32_t k = 0; k < cameras; ++k) {
    length += fit.camera_length[k];
    good += fit.camera_good[k];
  }
  return length > 0 ? good / length : 0;
}

/// The plan of a fit that follows `frames` tracked ones, the last of which was `surprise_m` from its
/// prediction.
std::span<const OutlineStage> stagesAfter(int frames, double surprise_m) {
  if (frames < 2) return kCatch;
  if (surprise_m > kExpected_m) return kFollow;
  return kFollowExpected;
}

double weightOf(double deviation) {
  return 1 / (deviation * deviation);
}

/// What a fit tells about the logarithm of the scale: 1 / variance, with an unknown pose.
double scaleInformation(const GpuOutlineFit& fit) {
  const Matrix7 all = informationOf(fit);
  const Matrix6 pose = all.topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, 1> both = all.topRightCorner<6, 1>();
  return std::max(0.0, all(6, 6) - both.dot(pose.ldlt().solve(both)));
}

}  // namespace

RobustTracker::RobustTracker(Gpu& gpu, const GpuRig& rig, const HandModel& hand)
    : rig_(rig),
      fitter_(gpu, rig, outlineModel(hand)),
      evidence_(gpu, rig),
      search_(gpu, rig, fitter_.model()),
      judge_(gpu, "outline_judge", outline_judge_comp),
      hands_(gpu, kMaxHands, Memory::kHost) {
  std::ranges::fill(hands_.host(), noHandPose());
  scale_.weight = weightOf(kScaleDeviation);
}

void RobustTracker::forget() {
  has_pose_ = false;
  frames_ = 0;
  uncertain_frames_ = 0;
  const double found = weightOf(kFoundScaleDeviation);
  scale_.weight = scale_.weight > 0 ? std::min(scale_.weight, found) : found;
  scale_frames_ = 0;
}

void RobustTracker::reset() {
  beginSearch();
  last_ = noOutlinePose();
  scale_ = {0, weightOf(kScaleDeviation)};
  last_time_s_ = frame_time_s_ = 0;
  next_camera_ = 0;
  was_empty_ = false;
  searches_ = clock_ = 0;
  evidence_.resetAdaptation();
}

HandPoseFrame RobustTracker::poseFrame(double scale) const {
  return {scale * fitter_.model().center_of_mass, rig_.rig().workspace.center};
}

void RobustTracker::recordBackground(Recorder& recorder, const Buffer<std::uint32_t>& model,
                                     const CameraRange& cameras) {
  evidence_.recordBackground(recorder, model, cameras);
}

double RobustTracker::timeOf(const Frame& frame) const {
  if (frame.camera_times_s.empty()) return clock_ * kFrame_s;
  double sum = 0;
  for (const double time : frame.camera_times_s) sum += time;
  return sum / double(frame.camera_times_s.size());
}

GpuOutlineFrame RobustTracker::outlineFrame(const Frame& frame) const {
  GpuOutlineFrame result = fitter_.frame();
  result.cameras &= ~frame.missing_cameras;
  result.velocity = velocity_.cast<float>();
  result.spin = spin_.cast<float>();
  const double time = timeOf(frame);
  for (std::size_t k = 0; k < frame.camera_times_s.size(); ++k)
    result.seconds[k] = static_cast<float>(frame.camera_times_s[k] - time);
  return result;
}

GpuOutlinePose RobustTracker::expected(const Frame& frame) const {
  return movedPose(last_, outlineFrame(frame), timeOf(frame) - last_time_s_);
}

std::vector<GpuTileRegion> RobustTracker::regionsAround(const GpuOutlinePose& pose,
                                                        const GpuOutlineFrame& frame) const {
  std::vector<GpuTileRegion> regions;
  for (std::size_t k = 0; k < rig_.cameraCount(); ++k) {
    const Camera& camera = rig_.rig().cameras[k];
    GpuTileRegion& region = regions.emplace_back();
    region = {{0, 0}, {0, 0}};
    if ((frame.cameras >> k & 1) == 0) continue;
    const GpuOutlinePose own = movedPose(pose, frame, frame.seconds[k]);
    const Mat3 turn = own.scale * rotationOf(own);
    Eigen::AlignedBox2d box;
    for (const vec3& vertex : fitter_.model().vertices) {
      const Vec3 world =
          rig_.rig().workspace.center + own.position.cast<double>() + turn * vertex.cast<double>();
      if (const auto pixel = projectThroughLens(camera.lens, camera.camera_from_world * world))
        box.extend(*pixel);
    }
    if (box.isEmpty()) continue;
    const double margin = (frames_ >= 2 ? kFollowMargin : kCatchMargin) * camera.width / 640;
    box.min().array() -= margin;
    box.max().array() += margin;
    region = evidence_.regionAround(k, box);
  }
  return regions;
}

void RobustTracker::recordEvidence(Recorder& recorder, const Frame& frame) {
  evidence_.record(recorder, frame.images, frame.background,
                   regionsAround(expected(frame), outlineFrame(frame)));
  if (frame.adapts_background) evidence_.recordAdaptation(recorder, frame.images, frame.background, true);
}

void RobustTracker::recordWholeEvidence(Recorder& recorder, const Frame& frame) {
  std::vector<GpuTileRegion> regions;
  for (std::size_t k = 0; k < rig_.cameraCount(); ++k) {
    regions.push_back(evidence_.wholeImage(k));
    if ((frame.missing_cameras >> k & 1) != 0) regions.back() = {{0, 0}, {0, 0}};
  }
  evidence_.record(recorder, frame.images, frame.background, regions,
                   kAttempts[std::size_t(searches_) % kAttempts.size()]);
  if (frame.adapts_background && was_empty_)
    evidence_.recordAdaptation(recorder, frame.images, frame.background, false);
}

void RobustTracker::recordFit(Recorder& recorder, const Frame& frame, const GpuOutlinePose& start,
                              std::span<const OutlineStage> stages) {
  fitter_.record(recorder, outlineFrame(frame), start, stages, evidence_, frame.images, frame.background,
                 scale_);
}

void RobustTracker::recordTracking(Recorder& recorder, const Frame& frame) {
  frame_time_s_ = timeOf(frame);
  expected_ = expected(frame);
  recordFit(recorder, frame, expected_, stagesAfter(frames_, surprise_m_));
  OutlineJudgeArgs judge{};
  judge.fit = fitter_.resultBuffer();
  judge.hand = hands_;
  judge.cameras = rig_.cameraCount();
  recorder.dispatch(judge_, judge, 1);
  // one camera learns per frame
  for (std::uint32_t i = 0; i < rig_.cameraCount(); ++i) {
    next_camera_ = (next_camera_ + 1) % rig_.cameraCount();
    if ((frame.missing_cameras >> next_camera_ & 1) == 0) break;
  }
  if (uncertain_frames_ == 0)
    evidence_.recordLearning(recorder, next_camera_, fitter_.masks(), fitter_.forearms(), kLearningRate);
}

void RobustTracker::beginSearch() {
  forget();
  velocity_.setZero();
  spin_.setZero();
  evidence_.forgetColours();  // they may be those of something else
}

bool RobustTracker::search(Recorder& recorder, const Frame& frame, StageTimes& stage_ms) {
  const GpuOutlineFrame outline_frame = outlineFrame(frame);
  const double scale = std::exp(scale_.log_scale);
  std::vector<ScoredPose> candidates =
      search_.candidates(recorder, evidence_, outline_frame, scale, kCandidatesPerEnd, stage_ms);
  was_empty_ = candidates.empty();
  if (was_empty_) return false;
  std::vector<GpuOutlinePose> poses;
  std::vector<double> agreements;
  for (const ScoredPose& candidate : candidates) {
    recorder.begin();
    recorder.stage("fit");
    recordFit(recorder, frame, candidate.pose, kRefine);
    recorder.submitAndWait();
    addStages(recorder.stageMs(), stage_ms);
    poses.push_back(fitter_.result().pose);
    agreements.push_back(agreementOf(fitter_.result(), rig_.cameraCount()));
  }
  std::vector<double> scores = search_.scores(recorder, outline_frame, poses, stage_ms);
  for (std::size_t i = 0; i < scores.size(); ++i) scores[i] -= kAgreementWeight * agreements[i];
  const auto best = std::ranges::min_element(scores) - scores.begin();

  // learn the colours from the best pose
  recorder.begin();
  recorder.stage("fit");
  constexpr OutlineStage kOutlineOnly[] = {{1, true}};
  recordFit(recorder, frame, poses[std::size_t(best)], kOutlineOnly);
  for (std::uint32_t camera = 0; camera < rig_.cameraCount(); ++camera)
    if ((frame.missing_cameras >> camera & 1) == 0)
      evidence_.recordLearning(recorder, camera, fitter_.masks(), fitter_.forearms(), 1);
  recorder.submitAndWait();
  addStages(recorder.stageMs(), stage_ms);
  last_ = poses[std::size_t(best)];
  last_time_s_ = timeOf(frame);
  has_pose_ = true;
  return true;
}

HandFit RobustTracker::finish() {
  const GpuOutlineFit& found = fitter_.result();
  HandFit fit;
  GpuHandPose device = hands_.host()[0];
  const bool trusted = device.tracked != 0;
  fit.agreement = agreementOf(found, rig_.cameraCount());
  fit.scale = found.pose.scale;
  fit.iterations = 0;
  for (const OutlineStage& stage : stagesAfter(frames_, surprise_m_)) fit.iterations += stage.steps;
  surprise_m_ = (found.pose.position - expected_.position).norm() +
                fitter_.model().radius_m * angleBetween(rotationOf(found.pose), rotationOf(expected_));
  fit.covariance = covarianceOf(found, scale_, surprise_m_);
  fit.outcome = FitOutcome::kStalled;
  fit.outside_m = 0;
  fit.outside_fraction = 1 - fit.agreement;
  device.tracked = 1;
  fit.pose = handPose(device, poseFrame(fit.scale));
  fit.tracked = trusted || (fit.agreement >= kUncertainAgreement && uncertain_frames_ < kUncertainLimit);
  fit.uncertain = fit.tracked && !trusted;
  if (!std::isfinite(found.pose.position.norm())) fit.tracked = false;
  ++clock_;
  if (!fit.tracked) {
    if (!has_pose_ || frames_ == 0) ++searches_;
    forget();
    return fit;
  }
  searches_ = 0;
  uncertain_frames_ = fit.uncertain ? uncertain_frames_ + 1 : 0;
  const double seconds = frame_time_s_ - last_time_s_;
  velocity_.setZero();
  spin_.setZero();
  if (frames_ >= 1 && seconds > 0 && seconds < kLongestGap_s) {
    velocity_ = (found.pose.position - last_.position).cast<double>() / seconds;
    const Eigen::AngleAxisd turn(rotationOf(found.pose) * rotationOf(last_).transpose());
    spin_ = turn.angle() / seconds * turn.axis();
    if (velocity_.norm() > kFastest_m_s) velocity_.setZero();
    if (spin_.norm() > kFastest_rad_s) spin_.setZero();
  }
  last_ = found.pose;
  last_time_s_ = frame_time_s_;
  ++frames_;
  if (trusted && scale_.weight > 0) {
    scale_.log_scale = std::log(fit.scale);
    scale_.weight =
        std::min(scale_.weight + kScaleTrust * scaleInformation(found), weightOf(kBestScaleDeviation));
    if (++scale_frames_ == kScaleFrames && std::abs(scale_.log_scale) < kOwnSize) {
      scale_ = {0, 0};
      last_.scale = 1;
    }
  }
  return fit;
}

}  // namespace airclay
