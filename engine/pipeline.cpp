// SPDX-License-Identifier: MIT
#include "engine/pipeline.h"

#include <algorithm>

#include "engine/core/clock.h"
#include "engine/core/error.h"
#include "engine/hand/robust_tracker.h"
#include "engine/hand/tracker.h"

namespace airclay {

HandState FrameResult::state() const {
  if (hands.empty()) return HandState::kEmpty;
  const HandFit* hand = trackedHand();
  if (!hand) return HandState::kLost;
  return hand->uncertain ? HandState::kUncertain : HandState::kTracked;
}

const HandFit* FrameResult::trackedHand() const {
  const auto found = std::ranges::find(hands, true, &HandFit::tracked);
  return found == hands.end() ? nullptr : &*found;
}

Pipeline::PreparedClay::PreparedClay(Gpu& gpu, const ClayState& state, const Vec3& workspace_center,
                                     const DistanceGrid& hand)
    : clay_(std::make_unique<Clay>(gpu, state, workspace_center)),
      sculptor_(std::make_unique<Sculptor>(gpu, *clay_, hand)) {}
Pipeline::PreparedClay::~PreparedClay() = default;

struct Pipeline::Parts {
  Parts(Gpu& gpu_, const Rig& rig, const HandModel& hand_model, const PipelineOptions& options,
        const std::optional<ClayState>& clay_state)
      : gpu(gpu_),
        method(options.silhouettes),
        camera_timing(gpu, options.time_every),
        replay_timing(gpu, options.time_every),
        hand(hand_model),
        gpu_rig(gpu, rig),
        images(gpu, gpu_rig.imageWords(), Memory::kHost),
        silhouettes(gpu, gpu_rig),
        carver(gpu, gpu_rig, options.voxels),
        tracker(gpu, gpu_rig, hand, carver),
        is_robust(options.fit == FitMethod::kRobust),
        replay_hands(gpu, kMaxHands, Memory::kHost),
        recorder(gpu) {
    if (is_robust || method == SilhouetteMethod::kRoom)
      robust = std::make_unique<RobustTracker>(gpu, gpu_rig, hand);
    if (is_robust) mask_images = std::make_unique<MaskImages>(gpu, gpu_rig);
    if (clay_state) setClay(prepareClay(*clay_state));
  }

  Gpu& gpu;
  SilhouetteMethod method;
  TimingPlan camera_timing, replay_timing;
  HandModel hand;
  GpuRig gpu_rig;
  Buffer<std::uint32_t> images;
  Silhouettes silhouettes;
  Carver carver;
  HandTracker tracker;
  bool is_robust;
  bool keeps_hull = false;                  ///< in frames whose tracking does not use it
  bool hull_is_current = true;              ///< the voxel model is that of the last frame
  std::uint32_t missing_cameras = 0;        ///< of the last frame
  std::unique_ptr<RobustTracker> robust;    ///< also has the evidence for room silhouettes
  std::unique_ptr<MaskImages> mask_images;  ///< what the robust fit uses in place of images
  bool masks_are_background = false;        ///< the evidence's background is that of mask_images
  std::unique_ptr<Clay> clay;
  std::unique_ptr<Sculptor> sculptor;
  std::optional<DistanceGrid> contact_grid;  ///< of the hand, once there is clay
  Buffer<GpuHandPose> replay_hands;
  bool background_changed = false;  ///< since its model was computed
  bool hand_was_replayed = false;   ///< the last frame was sculptWith()
  Recorder recorder;

  std::unique_ptr<PreparedClay> prepareClay(const ClayState& state) {
    if (!contact_grid) contact_grid = contactGrid(hand.skin);
    return std::make_unique<PreparedClay>(gpu, state, gpu_rig.rig().workspace.center, *contact_grid);
  }

  void setClay(std::unique_ptr<PreparedClay> prepared) {
    sculptor = prepared ? std::move(prepared->sculptor_) : nullptr;  // before the clay that it refers to
    clay = prepared ? std::move(prepared->clay_) : nullptr;
  }

  /// One submission per camera, so that a window can draw in between.
  void learn() {
    for (std::uint32_t camera = 0; camera < gpu_rig.cameraCount(); ++camera) {
      recorder.begin();
      silhouettes.recordLearning(recorder, images, {camera, 1});
      recorder.submitAndWait();
    }
    background_changed = true;
  }

  /// Computes the background model after its last frame.
  void finishBackground() {
    for (std::uint32_t camera = 0; background_changed && camera < gpu_rig.cameraCount(); ++camera) {
      recorder.begin();
      silhouettes.finishLearning(recorder, {camera, 1});
      if (robust) robust->recordBackground(recorder, silhouettes.model(), {camera, 1});
      recorder.submitAndWait();
    }
    if (background_changed) masks_are_background = false;
    background_changed = false;
  }

  void checkLearned() const {
    if (!silhouettes.learned())
      throw Error(
          "the empty workspace has not been learned; provide background images or empty first frames");
  }

  /// From images, or from masks that are already uploaded, to the voxel model.
  void recordHull(bool from_images, const FrameInput& input) {
    if (from_images) {
      checkLearned();
      recorder.stage("silhouette");
      if (method == SilhouetteMethod::kRoom) {
        robust->recordWholeEvidence(recorder, frameOf(from_images, input));
        robust->evidence().recordMasks(recorder, silhouettes.masks());
      } else {
        silhouettes.record(recorder, images);
      }
    }
    recordCarving(input.missing_cameras);
  }

  void recordCarving(std::uint32_t missing) {
    recorder.stage("carve");
    carver.record(recorder, silhouettes.masks(), missing);
    hull_is_current = true;
  }

  /// What the robust tracker uses: the images, or masks as images.
  RobustTracker::Frame frameOf(bool from_images, const FrameInput& input) const {
    const bool masks = !from_images || method == SilhouetteMethod::kPaper;
    return {masks ? mask_images->images() : images, masks ? mask_images->background() : silhouettes.model(),
            !masks, input.missing_cameras, input.camera_times_s};
  }

  /// From the voxel model to the new surface.
  void recordHandAndClay(const std::optional<SculptControls>& controls) {
    recorder.stage("fit");
    tracker.recordTracking(recorder);
    if (controls) recordClay(tracker.hands(), *controls);
  }

  void recordClay(const Buffer<GpuHandPose>& hands, const SculptControls& controls) {
    if (!sculptor) return;
    recorder.stage("clay");
    sculptor->record(recorder, hands, controls);
  }

  /// The hand's path between a tracked and a replayed pose is unknown.
  void setHandSource(bool replayed) {
    if (replayed != hand_was_replayed && sculptor) sculptor->forget();
    hand_was_replayed = replayed;
  }

  void submit(FrameResult& result) {
    recorder.submitAndWait();
    addStages(recorder.stageMs(), result.stage_ms);
  }

  /// The whole pipeline. While tracking, a frame is one submission; a search takes several more. Without
  /// controls, skips the clay.
  FrameResult process(bool from_images, const std::optional<SculptControls>& controls,
                      const FrameInput& input = {}) {
    if (is_robust) return processRobust(from_images, controls, input);
    FrameResult result;
    const auto start = Clock::now();
    if (controls) setHandSource(false);
    const bool following = tracker.hasPose();
    if (from_images) finishBackground();
    const Timing timing = camera_timing.next();
    recorder.begin(timing);
    recordHull(from_images, input);
    if (following) recordHandAndClay(controls);
    submit(result);

    HandFit fit;
    if (following) fit = tracker.finish();
    if (!fit.tracked) {
      result.searched = tracker.search(recorder, result.stage_ms);
      if (result.searched) {
        recorder.begin(timing);
        recordHandAndClay(controls);
        submit(result);
        fit = tracker.finish();
      }
    }
    if (fit.tracked || !tracker.isEmpty()) result.hands.push_back(std::move(fit));
    if (controls) finishClay(result);
    result.frame_ms = millisecondsSince(start);
    return result;
  }

  /// The background of what the tracker uses changes from images to masks or back.
  void useBackground(bool masks) {
    if (masks == masks_are_background) return;
    recorder.begin(Timing::kNone);
    robust->recordBackground(recorder, masks ? mask_images->background() : silhouettes.model(), {});
    recorder.submitAndWait();
    masks_are_background = masks;
    robust->forget();
  }

  /// The evidence, of masks or images; and the hull, if it is kept.
  void recordSilhouettes(bool from_images, const FrameInput& input, bool whole) {
    recorder.stage("silhouette");
    const bool is_room = from_images && method == SilhouetteMethod::kRoom;
    if (from_images && !is_room) silhouettes.record(recorder, images);
    if (!is_room) mask_images->record(recorder, silhouettes.masks());
    if (whole)
      robust->recordWholeEvidence(recorder, frameOf(from_images, input));
    else
      robust->recordEvidence(recorder, frameOf(from_images, input));
    if (is_room) robust->evidence().recordMasks(recorder, silhouettes.masks());
    hull_is_current = false;
    missing_cameras = input.missing_cameras;
    if (keeps_hull) recordCarving(missing_cameras);
  }

  /// The last frame's voxel model, if it was not kept.
  void updateHull() {
    if (hull_is_current) return;
    recorder.begin(Timing::kNone);
    recordCarving(missing_cameras);
    recorder.submitAndWait();
  }

  void recordRobustFit(const RobustTracker::Frame& frame, const std::optional<SculptControls>& controls) {
    recorder.stage("fit");
    robust->recordTracking(recorder, frame);
    if (controls) recordClay(robust->hands(), *controls);
  }

  /// The same with the robust fit.
  FrameResult processRobust(bool from_images, const std::optional<SculptControls>& controls,
                            const FrameInput& input) {
    FrameResult result;
    const auto start = Clock::now();
    if (controls) setHandSource(false);
    if (from_images) {
      finishBackground();
      checkLearned();
    }
    useBackground(!from_images || method == SilhouetteMethod::kPaper);
    const RobustTracker::Frame frame = frameOf(from_images, input);
    const Timing timing = camera_timing.next();
    HandFit fit;
    bool is_empty = false;
    if (robust->hasPose()) {
      recorder.begin(timing);
      recordSilhouettes(from_images, input, false);
      recordRobustFit(frame, controls);
      submit(result);
      fit = robust->finish();
    }
    if (!fit.tracked) {
      robust->beginSearch();
      recorder.begin(timing);
      recordSilhouettes(from_images, input, true);
      submit(result);
      result.searched = robust->search(recorder, frame, result.stage_ms);
      is_empty = !result.searched;
      if (result.searched) {
        recorder.begin(timing);
        recorder.stage("silhouette");
        robust->recordEvidence(recorder, frame);
        recordRobustFit(frame, controls);
        submit(result);
        fit = robust->finish();
      }
    }
    if (!is_empty) result.hands.push_back(std::move(fit));
    if (controls) finishClay(result);
    result.frame_ms = millisecondsSince(start);
    return result;
  }

  FrameResult sculptWith(std::span<const HandPose> hands, const SculptControls& controls) {
    if (hands.size() > kMaxHands)
      throw Error("too many hands; expected at most " + std::to_string(kMaxHands));
    FrameResult result;
    const auto start = Clock::now();
    setHandSource(true);
    std::ranges::fill(replay_hands.host(), noHandPose());
    for (std::size_t k = 0; k < hands.size(); ++k) {
      HandFit& fit = result.hands.emplace_back();
      fit.pose = hands[k];
      fit.tracked = true;
      fit.outside_fraction = 0;
      replay_hands.host()[k] = gpuHandPose(hands[k], poseFrame(tracker.model(), gpu_rig.rig().workspace));
    }
    if (hands.empty()) {
      finishClay(result);
      return result;
    }
    recorder.begin(replay_timing.next());
    recordClay(replay_hands, controls);
    submit(result);
    finishClay(result);
    result.frame_ms = millisecondsSince(start);
    return result;
  }

  void finishClay(FrameResult& result) {
    if (!sculptor) return;
    if (result.state() != HandState::kTracked) {
      sculptor->forget();
      return;
    }
    if (sculptor->needsHost()) sculptor->finishOnHost(recorder);
    result.clay = sculptor->step();
  }

  void uploadMasks(const std::vector<Silhouette>& masks) {
    const std::vector<Camera>& cameras = gpu_rig.rig().cameras;
    if (masks.size() != cameras.size()) throw Error("expected one mask per camera");
    for (std::size_t c = 0; c < cameras.size(); ++c)
      if (masks[c].width != cameras[c].width || masks[c].height != cameras[c].height)
        throw Error("the mask of camera " + cameras[c].name + " must have the camera's size in the rig");
    gpu_rig.pack(masks, silhouettes.masks().host());
  }

  void hull(bool from_images, const FrameInput& input) {
    if (from_images) finishBackground();
    recorder.begin(Timing::kNone);
    recordHull(from_images, input);
    recorder.submitAndWait();
  }
};

Pipeline::Pipeline(Gpu& gpu, const Rig& rig, const HandModel& hand, const PipelineOptions& options,
                   const std::optional<ClayState>& clay)
    : parts_(std::make_unique<Parts>(gpu, rig, hand, options, clay)) {}
Pipeline::~Pipeline() = default;

std::span<std::uint8_t> Pipeline::image(std::size_t camera) {
  return parts_->gpu_rig.image(parts_->images.host(), camera);
}

std::span<const std::uint8_t> Pipeline::image(std::size_t camera) const {
  return parts_->gpu_rig.image(parts_->images.host(), camera);  // Parts is not const through its pointer
}

const Evidence* Pipeline::evidence() const {
  return parts_->robust ? &parts_->robust->evidence() : nullptr;
}

void Pipeline::resetBackground() {
  parts_->silhouettes.forget();
  parts_->background_changed = false;
}

void Pipeline::learnBackground() {
  parts_->learn();
}

FrameResult Pipeline::processImages(const SculptControls& controls, const FrameInput& input) {
  return parts_->process(true, controls, input);
}

FrameResult Pipeline::trackImages(const FrameInput& input) {
  return parts_->process(true, std::nullopt, input);
}

FrameResult Pipeline::trackSilhouettes(const std::vector<Silhouette>& masks, const FrameInput& input) {
  parts_->uploadMasks(masks);
  return parts_->process(false, std::nullopt, input);
}

FrameResult Pipeline::processSilhouettes(const std::vector<Silhouette>& masks, const SculptControls& controls,
                                         const FrameInput& input) {
  parts_->uploadMasks(masks);
  return parts_->process(false, controls, input);
}

FrameResult Pipeline::sculptWith(std::span<const HandPose> hands, const SculptControls& controls) {
  return parts_->sculptWith(hands, controls);
}

void Pipeline::keepHull(bool keep) {
  parts_->keeps_hull = keep;
}

void Pipeline::updateHull() {
  parts_->updateHull();
}

void Pipeline::setClay(const std::optional<ClayState>& clay) {
  parts_->setClay(clay ? parts_->prepareClay(*clay) : nullptr);
}

std::unique_ptr<Pipeline::PreparedClay> Pipeline::prepareClay(const ClayState& clay) {
  return parts_->prepareClay(clay);
}

void Pipeline::setClay(std::unique_ptr<PreparedClay> prepared) {
  parts_->setClay(std::move(prepared));
}

void Pipeline::hullFromImages(const FrameInput& input) {
  parts_->hull(true, input);
}

void Pipeline::hullFromSilhouettes(const std::vector<Silhouette>& masks, const FrameInput& input) {
  parts_->uploadMasks(masks);
  parts_->hull(false, input);
}

void Pipeline::resetTracking() {
  parts_->tracker.forget();
  if (parts_->robust) parts_->robust->reset();
  if (parts_->sculptor) parts_->sculptor->forget();
}

const Rig& Pipeline::rig() const {
  return parts_->gpu_rig.rig();
}
const HandModel& Pipeline::hand() const {
  return parts_->hand;
}
const Silhouettes& Pipeline::silhouettes() const {
  return parts_->silhouettes;
}
const GpuRig& Pipeline::gpuRig() const {
  return parts_->gpu_rig;
}
const Carver& Pipeline::carver() const {
  return parts_->carver;
}
Clay& Pipeline::clay() {
  return *parts_->clay;
}
const Clay& Pipeline::clay() const {
  return *parts_->clay;
}

}  // namespace airclay
