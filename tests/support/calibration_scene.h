// SPDX-License-Identifier: MIT
// A moving board in front of known cameras, and the error of a recovered rig where it matters: inside the
// workspace.
#pragma once

#include <filesystem>
#include <random>

#include "capture/calibration/calibration.h"

namespace airclay {

/// 7 x 5 squares of 55 mm with markers of 41 mm: fills an A3 sheet.
Board a3Board();

struct Wave {
  int frames = 60;
  unsigned seed = 1;
  double reach_m = 0.22;  ///< largest distance of the board's centre from the workspace's
  double noise_px = 0.1;  ///< standard deviation of a corner's coordinate
  double outliers = 0;    ///< fraction of corners that are off by 10 px
};

/// world_from_board in each frame: the tilted board faces one camera after another.
std::vector<Pose> wavedBoards(const Rig& rig, const Board& board, const Wave& wave);

/// The corners that each camera sees of a board that faces it, with noise.
std::vector<CameraViews> seenCorners(const Rig& rig, const Board& board, const std::vector<Pose>& boards,
                                     const Wave& wave);

/// Renders the boards for every camera, with noise, into `folder`: NAME/0.png and so on.
void drawImages(const std::filesystem::path& folder, const Rig& rig, const Board& board,
                const std::vector<Pose>& boards);
/// The same as videos NAME.mp4, H.264.
void drawVideos(const std::filesystem::path& folder, const Rig& rig, const Board& board,
                const std::vector<Pose>& boards);

/// The error of points in the workspace: projected by the true cameras, triangulated with the recovered rig,
/// rigidly aligned (Umeyama 1991).
struct CubeError {
  double central_mm = 0;  ///< RMS in the central half of the workspace's edge
  double whole_mm = 0;    ///< RMS in the whole workspace
  double scale = 1;       ///< recovered lengths / true lengths
};
CubeError cubeError(const Rig& truth, const Rig& recovered);
/// The same without alignment: both rigs share the world frame. \pre cameras in the same order
CubeError cubeErrorInPlace(const Rig& truth, const Rig& recovered);

/// The recovered rig in the true rig's world, aligned as for cubeError() over the whole workspace.
Rig alignedTo(const Rig& truth, const Rig& recovered);

/// A camera moved by `by_m`, metres, and rotated by the rotation vector `turn`, radians, both in its own
/// frame.
Camera bumped(Camera camera, const Vec3& by_m, const Vec3& turn);

}  // namespace airclay
