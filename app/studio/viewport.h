// SPDX-License-Identifier: MIT
// What stands in the studio's image: clay, hand, ground, and the workings if they are to be seen.
#pragma once

#include <optional>

#include "app/session/images.h"
#include "app/session/session.h"
#include "app/studio/settings.h"
#include "app/studio/view_control.h"
#include "engine/render/renderer.h"

namespace airclay {

struct ViewportFrame {
  View view;
  int width = 0, height = 0;  ///< of the window, pixels
  bool moving = false;        ///< something changes from image to image: a software device saves detail
};

class Viewport {
 public:
  Viewport(Gpu& gpu, const Session& session, const std::optional<TriangleMesh>& forearm);

  /// Records the image of `snapshot`, unless the last one is like it; it is in image() when the work is
  /// done. The clay may not change its form until that is submitted. \pre the work recorded before is done
  void record(Recorder& recorder, const Session::ClayOnDevice& clay, const Snapshot& snapshot,
              const StudioSettings& settings, const ViewportFrame& frame);
  /// The last one.
  Image& image() { return drawn_->image(); }

  /// The smallest distance between the hand's skin and the clay's data points; negative: that deep inside.
  /// None when the hand is out of reach.
  std::optional<double> gapMetres() const { return gap_m_; }
  /// A ball around the clay, workspace frame.
  Vec3 clayCenter() const { return clay_center_; }
  double clayRadius() const { return clay_radius_m_; }
  /// The posed hand's outline in a camera's image: pairs of points, pixels.
  std::vector<std::pair<Vec2, Vec2>> outline(std::size_t camera, const Pose& world_from_hand) const;

 private:
  Scene sceneOf(const Session::ClayOnDevice& clay, const Snapshot& snapshot, const StudioSettings& settings,
                const std::optional<Pose>& workspace_from_hand);
  Renderer& rendererFor(int width, int height, bool moving);
  void measure(const Snapshot& snapshot, const std::optional<Pose>& workspace_from_hand);
  SurfaceBuffers recordSurface(Recorder& recorder, const Session::ClayOnDevice& clay,
                               std::uint64_t clay_serial, bool moving);

  /// An edge of the skin and the triangles on both sides.
  struct SkinEdge {
    int a = 0, b = 0, left = -1, right = -1;
  };

  Gpu& gpu_;
  const Session& session_;
  DrawnHand hand_;
  std::vector<SkinEdge> skin_edges_;
  std::array<std::unique_ptr<Renderer>, 2> renderers_;  ///< for what rests, and for what moves
  Renderer* drawn_ = nullptr;                           ///< the one of the last image
  std::vector<double> drawn_key_;                       ///< all that the last image depends on
  /// The clay as it is drawn, and of what clay it was evaluated last.
  struct DrawnClay {
    std::unique_ptr<DisplaySurface> surface;
    std::uint64_t structure_serial = 0, clay_serial = 0;
  };
  std::array<DrawnClay, 2> clays_;  ///< for what rests, and for what moves
  Buffer<std::uint32_t> cage_edges_;
  std::uint64_t cage_structure_serial_ = 0;
  double ground_z_m_ = 0;
  std::optional<double> gap_m_;
  Vec3 clay_center_ = Vec3::Zero();
  double clay_radius_m_ = 0.1;
  double clay_reach_m_ = 0.1;  ///< of its farthest point from the workspace's centre
};

}  // namespace airclay
