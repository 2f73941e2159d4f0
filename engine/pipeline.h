// SPDX-License-Identifier: MIT
// The pipeline that every command and the window use:
//
//     images -> silhouettes -> voxel model -> hand pose -> contact -> control points -> surface
//
// A tracked frame is one submission to the device.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/clay/clay.h"
#include "engine/clay/clay_state.h"
#include "engine/clay/solve.h"
#include "engine/clay/subdivide.h"
#include "engine/hand/fit.h"
#include "engine/hand/hand_model.h"
#include "engine/hull/carve.h"
#include "engine/mesh/distance_grid.h"
#include "engine/sculpt/sculptor.h"
#include "engine/silhouette/evidence.h"
#include "engine/silhouette/silhouette.h"

namespace airclay {

/// How silhouettes come from images.
enum class SilhouetteMethod {
  kRoom,   ///< probabilities that survive a real room (silhouette/evidence.h)
  kPaper,  ///< the largest part that differs from the background (silhouette/silhouette.h)
};

/// How the hand is fitted.
enum class FitMethod {
  kRobust,  ///< its outline in the images (hand/robust_tracker.h)
  kPaper,   ///< forces on the patches outside the voxel model, as published (hand/tracker.h)
};

struct PipelineOptions {
  int voxels = 128;  ///< along the workspace's edge
  SilhouetteMethod silhouettes = SilhouetteMethod::kRoom;
  FitMethod fit = FitMethod::kRobust;
  int time_every = 0;  ///< time the stages of one frame in this many (TimingPlan)
};

enum class HandState {
  kEmpty,  ///< too little in the images to be a hand
  kTracked,
  kUncertain,  ///< there is a pose, but it is not to be trusted for sculpting
  kLost,       ///< there is something, but no pose fits it
};

/// A frame's camera data except the images.
struct FrameInput {
  std::uint32_t missing_cameras = 0;   ///< bit k: camera k has no image of this instant and is left out
  std::vector<double> camera_times_s;  ///< each camera's own timestamp, in the rig's order; may be empty
};

struct FrameResult {
  /// The hands in the voxel model, tracked or lost, at most kMaxHands; empty if nothing could be a hand.
  std::vector<HandFit> hands;
  ClayStep clay;
  bool searched = false;  ///< the hand was searched for in all orientations, which takes longer
  double frame_ms = 0;    ///< wall time from pixels in memory to the result
  /// Device time of the stages silhouette, carve (of frames that compute the voxel model), fit and, with
  /// clay, clay; empty in frames that are not timed (PipelineOptions).
  StageTimes stage_ms;

  HandState state() const;
  /// The first hand that is tracked, uncertain or not, or null.
  const HandFit* trackedHand() const;
};

class Pipeline {
 public:
  /// Without `clay`, only tracks the hand. \throw Error like the constructors of its parts.
  Pipeline(Gpu& gpu, const Rig& rig, const HandModel& hand, const PipelineOptions& options = {},
           const std::optional<ClayState>& clay = std::nullopt);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// The buffer for a camera's next image: BGR, 3 bytes per pixel, rows without padding, in memory that the
  /// kernels read.
  std::span<std::uint8_t> image(std::size_t camera);
  std::span<const std::uint8_t> image(std::size_t camera) const;
  /// Learns from the images in memory, which show the empty workspace.
  void learnBackground();
  /// Discards the learned background, because the empty workspace has changed.
  void resetBackground();
  /// Processes the images in memory through all stages. \pre learnBackground() was called
  FrameResult processImages(const SculptControls& controls = {}, const FrameInput& input = {});
  /// The same from masks instead of images, one per camera.
  FrameResult processSilhouettes(const std::vector<Silhouette>& masks, const SculptControls& controls = {},
                                 const FrameInput& input = {});
  /// Only tracks the hand, so that the caller can check the pose before sculptWith().
  FrameResult trackImages(const FrameInput& input = {});
  FrameResult trackSilhouettes(const std::vector<Silhouette>& masks, const FrameInput& input = {});
  /// A frame without cameras: runs only the clay stage with the given hands, at most kMaxHands; the first one
  /// sculpts. The tracker keeps its state. Between such a frame and one with cameras the hand's path is
  /// unknown, so the clay does not move in the first frame of either kind. Without hands or clay, nothing
  /// moves.
  FrameResult sculptWith(std::span<const HandPose> hands, const SculptControls& controls = {});
  /// Computes only silhouettes and voxel model, from the images in memory or from masks.
  void hullFromImages(const FrameInput& input = {});
  void hullFromSilhouettes(const std::vector<Silhouette>& masks, const FrameInput& input = {});

  /// The robust fit does not use the voxel model. Whether each frame computes it all the same, for display;
  /// initially not.
  void keepHull(bool keep);
  /// Computes the last frame's voxel model, unless the frame has.
  void updateHull();

  /// Replaces or removes the clay; references to the old one become invalid. The tracker keeps its state. To
  /// change only control points, use Clay::setControlPoints(). \throw Error like Clay; then the old clay
  /// stays.
  void setClay(const std::optional<ClayState>& clay);
  /// The same in two steps: preparing large clay takes long and can be cancelled (engine/core/task.h);
  /// replacing the old clay is fast. \throw Error like Clay
  class PreparedClay {
   public:
    PreparedClay(Gpu& gpu, const ClayState& state, const Vec3& workspace_center, const DistanceGrid& hand);
    ~PreparedClay();

   private:
    friend class Pipeline;
    std::unique_ptr<Clay> clay_;
    std::unique_ptr<Sculptor> sculptor_;
  };
  std::unique_ptr<PreparedClay> prepareClay(const ClayState& clay);
  void setClay(std::unique_ptr<PreparedClay> prepared);

  /// Forgets the hand: the next frame searches again.
  void resetTracking();

  const Rig& rig() const;
  const HandModel& hand() const;
  const Silhouettes& silhouettes() const;
  /// The evidence for the hand (room silhouettes or robust fit), otherwise null.
  const Evidence* evidence() const;
  const GpuRig& gpuRig() const;
  /// The voxel model; see keepHull().
  const Carver& carver() const;
  /// \pre there is clay
  Clay& clay();
  const Clay& clay() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
