// SPDX-License-Identifier: MIT
// A board that is waved before known cameras, and how far a recovered rig is from the true one where it
// counts: in the cube.
#pragma once

#include <random>

#include "capture/calibration.h"

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

/// Points of the true rig's cube, seen by the true cameras, triangulated with the recovered rig, rigidly
/// aligned (Umeyama 1991).
struct CubeError {
  double central_mm = 0;  ///< RMS in the middle half of the cube's edge
  double whole_mm = 0;    ///< RMS in the whole cube
  double scale = 1;       ///< recovered lengths / true ones
};
CubeError cubeError(const Rig& truth, const Rig& recovered);

}  // namespace airclay
