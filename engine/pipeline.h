// SPDX-License-Identifier: MIT
// The way of the data, as every command and the window call it:
//
//     images -> silhouettes -> voxel model -> hand pose -> contact -> control points -> surface
//
// A tracked frame is one submission to the device.
#pragma once

#include <memory>
#include <optional>
#include <string>

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

struct FrameResult {
  HandState hand = HandState::kEmpty;
  HandFit fit;  ///< meaningful unless kEmpty
  ClayStep clay;
  bool searched = false;  ///< the hand was looked for all around: such a frame takes longer
  double frame_ms = 0;    ///< wall time from pixels in memory to the result
  /// On the device, disjoint, by name: silhouette, carve, fit, and with clay: clay. None in frames that are
  /// not timed (PipelineOptions).
  StageTimes stage_ms;
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
  FrameResult processImages(const SculptControls& controls = {});
  /// The same from masks that are used as they are, one a camera.
  FrameResult processMasks(const std::vector<Mask>& masks, const SculptControls& controls = {});
  /// The hand alone: for whoever looks at the pose before it sculpts with sculptWith().
  /// Cameras whose bits are in `absent` have no image of this instant, and no say.
  FrameResult trackImages(std::uint32_t missing_cameras = 0);
  FrameResult trackMasks(const std::vector<Mask>& masks);
  /// A frame without cameras: the hand is where the caller says, and only the clay's stage runs. The tracker
  /// is left alone. Between such a frame and one with cameras the hand's way is not known, so the clay
  /// doesn't move in the first of either. Without clay nothing moves.
  FrameResult sculptWith(const Pose& world_from_hand, const SculptControls& controls = {});
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

  /// There was no hand to give: the next sculptWith() starts anew.
  void resetGivenHand();
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
