// SPDX-License-Identifier: MIT
// A board that is waved before known cameras, and how far a recovered rig is from the true one where it
// counts: in the cube.
#pragma once

#include <filesystem>
#include <random>

#include "capture/calibration/calibration.h"

namespace airclay {

/// 7 x 5 squares of 55 mm with markers of 41 mm: fills a sheet of A3.
Board a3Board();

struct Wave {
  int frames = 60;
  unsigned seed = 1;
  double reach_m = 0.22;  ///< of the board's middle from the cube's
  double noise_px = 0.1;  ///< standard deviation of a corner's coordinate
  double outliers = 0;    ///< share of corners that are off by 10 px
};

/// Where the board is in each frame, world_from_board: it turns its face to one camera after another, tilted.
std::vector<Pose> wavedBoards(const Rig& rig, const Board& board, const Wave& wave);

/// The corners that each camera sees of a board that faces it, with noise.
std::vector<CameraViews> seenCorners(const Rig& rig, const Board& board, const std::vector<Pose>& boards,
                                     const Wave& wave);

/// Takes images of the boards with every camera, noise on them, into `folder`: NAME/0.png and on.
void drawImages(const std::filesystem::path& folder, const Rig& rig, const Board& board,
                const std::vector<Pose>& boards);
/// The same into a video NAME.mp4 each, H.264.
void drawVideos(const std::filesystem::path& folder, const Rig& rig, const Board& board,
                const std::vector<Pose>& boards);

/// Points of the true rig's cube, seen by the true cameras, triangulated with the recovered rig, rigidly
/// aligned (Umeyama 1991).
struct CubeError {
  double central_mm = 0;  ///< RMS in the middle half of the cube's edge
  double whole_mm = 0;    ///< RMS in the whole cube
  double scale = 1;       ///< recovered lengths / true ones
};
CubeError cubeError(const Rig& truth, const Rig& recovered);
/// The same without alignment: the recovered rig's world must be the true one's. \pre cameras in one order
CubeError cubeErrorInPlace(const Rig& truth, const Rig& recovered);

/// The recovered rig in the true one's world, aligned as for cubeError() over the whole cube, with its cube.
Rig alignedTo(const Rig& truth, const Rig& recovered);

/// A camera that was pushed by `by_m`, metres, and turned by the rotation vector `turn`, radians, both in its
/// own frame.
Camera bumped(Camera camera, const Vec3& by_m, const Vec3& turn);

}  // namespace airclay
