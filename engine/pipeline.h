// SPDX-License-Identifier: MIT
// The way of the data, as every command and the window call it:
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
#include "engine/silhouette/silhouette.h"

namespace airclay {

struct PipelineOptions {
  int voxels = 128;    ///< along the workspace's edge
  int time_every = 0;  ///< stages are timed in one frame of so many (TimingPlan)
};

enum class HandState {
  kEmpty,  ///< nobody there: too little in the image to be a hand
  kTracked,
  kLost,  ///< something is there, but no pose explains it
};

/// What the cameras recorded at one instant, besides the images.
struct FrameInput {
  std::uint32_t missing_cameras = 0;   ///< bit k: camera k has no image of this instant and is left out
  std::vector<double> camera_times_s;  ///< each camera's own timestamp, in the rig's order; may be empty
};

struct FrameResult {
  /// The hands in the voxel model, tracked or lost: at most kMaxHands, empty if nothing there could be a
  /// hand.
  std::vector<HandFit> hands;
  ClayStep clay;
  bool searched = false;  ///< the hand was looked for all around: such a frame takes longer
  double frame_ms = 0;    ///< wall time from pixels in memory to the result
  /// On the device, disjoint, by name: silhouette, carve, fit, and with clay: clay. None in frames that are
  /// not timed (PipelineOptions).
  StageTimes stage_ms;

  HandState state() const;
  /// The first hand that is tracked, or null.
  const HandFit* trackedHand() const;
};

class Pipeline {
 public:
  /// Without `clay` only the hand is tracked. \throw Error as its parts do.
  Pipeline(Gpu& gpu, const Rig& rig, const HandModel& hand, const PipelineOptions& options = {},
           const std::optional<ClayState>& clay = std::nullopt);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// Where camera `camera`'s next image goes: tightly packed BGR, 3 bytes a pixel, in memory that the
  /// kernels read.
  std::span<std::uint8_t> image(std::size_t camera);
  /// The images now in memory show the empty workspace.
  void learnBackground();
  /// The empty workspace is another one by now; it is to be learned anew.
  void resetBackground();
  /// The images now in memory, through all stages.
  /// \pre learnBackground() was called
  FrameResult processImages(const SculptControls& controls = {}, const FrameInput& input = {});
  /// The same from masks that are used as they are, one a camera.
  FrameResult processMasks(const std::vector<Mask>& masks, const SculptControls& controls = {},
                           const FrameInput& input = {});
  /// The hand alone: for whoever looks at the pose before it sculpts with sculptWith().
  FrameResult trackImages(const FrameInput& input = {});
  FrameResult trackMasks(const std::vector<Mask>& masks, const FrameInput& input = {});
  /// A frame without cameras: only the clay's stage runs, with the given hands, at most kMaxHands; the first
  /// one sculpts. The tracker keeps its state. Between such a frame and one with cameras the hand's path is
  /// unknown, so the clay does not move in the first frame of either. Without hands, or without clay, nothing
  /// moves.
  FrameResult sculptWith(std::span<const HandPose> hands, const SculptControls& controls = {});
  /// Silhouettes and voxel model alone, of the images in memory or of masks.
  void hullFromImages();
  void hullFromMasks(const std::vector<Mask>& masks);

  /// Replaces the clay, or takes it away; references to the old one hold no more. The tracker goes on. For
  /// other control points of the same cage Clay::setControlPoints() does. \throw Error as Clay, and the old
  /// clay stays.
  void setClay(const std::optional<ClayState>& clay);
  /// The same in two steps: making the clay takes long where it is large, and may be cancelled
  /// (engine/core/task.h); putting it in the old one's place does not. \throw Error as Clay
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
  void setClay(std::unique_ptr<PreparedClay> made);

  /// Forgets the hand: the next frame searches again.
  void resetTracking();

  const Rig& rig() const;
  const HandModel& hand() const;
  const Silhouettes& silhouettes() const;
  const GpuRig& gpuRig() const;
  const Carver& carver() const;
  /// \pre made with clay
  Clay& clay();
  const Clay& clay() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace airclay
