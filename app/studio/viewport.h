// SPDX-License-Identifier: MIT
// Renders the studio's 3D view: clay, hand, ground, and optional overlays.
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
  int width = 0, height = 0;  ///< size of the window, pixels
  bool moving = false;        ///< the scene is moving: a software device reduces detail
};

class Viewport {
 public:
  Viewport(Gpu& gpu, const Session& session, const std::optional<TriangleMesh>& forearm);

  /// Records the rendering of `snapshot` into image(), unless nothing has changed. The clay's structure may
  /// not change until the recorder is submitted. \pre previously recorded work has finished
  void record(Recorder& recorder, const Session::ClayOnDevice& clay, const Snapshot& snapshot,
              const StudioSettings& settings, const ViewportFrame& frame);
  /// The last image.
  Image& image() { return drawn_->image(); }

  /// The smallest distance between the hand's skin and the clay's data points; negative: inside. Nullopt if
  /// the hand is far away.
  std::optional<double> gapMetres() const { return gap_m_; }
  /// Bounding sphere of the clay, workspace frame.
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

  /// An edge of the skin and its two triangles.
  struct SkinEdge {
    int a = 0, b = 0, left = -1, right = -1;
  };

  Gpu& gpu_;
  const Session& session_;
  DrawnHand hand_;
  std::vector<SkinEdge> skin_edges_;
  std::array<std::unique_ptr<Renderer>, 2> renderers_;  ///< full detail at rest, reduced in motion
  Renderer* drawn_ = nullptr;                           ///< the renderer of the last image
  std::vector<double> drawn_key_;                       ///< everything that the last image depends on
  /// The displayed surface, and the clay that it was evaluated from.
  struct DrawnClay {
    std::unique_ptr<DisplaySurface> surface;
    std::uint64_t structure_serial = 0, clay_serial = 0;
  };
  std::array<DrawnClay, 2> clays_;  ///< full detail at rest, reduced in motion
  Buffer<std::uint32_t> cage_edges_;
  std::uint64_t cage_structure_serial_ = 0;
  double ground_z_m_ = 0;
  std::optional<double> gap_m_;
  Vec3 clay_center_ = Vec3::Zero();
  double clay_radius_m_ = 0.1;
  double clay_reach_m_ = 0.1;  ///< distance of its farthest point from the workspace's center
};

}  // namespace airclay
