// SPDX-License-Identifier: MIT
// Images of calibration boards whose truth is known.
#pragma once

#include <cstdint>

#include "capture/calibration/board.h"
#include "engine/camera/rig.h"

namespace airclay {

/// How an image is taken.
struct BoardShot {
  double noise_sigma = 0;  ///< of 255, Gaussian, the same on all three colours
  std::uint32_t seed = 1;  ///< of the noise
  double blur_px = 0;      ///< sigma of a Gaussian blur, on top of what a pixel's square gathers
  double black = 30, white = 220, background = 100;  ///< grey values of 255
  double paper_m = 0.02;                             ///< white paper around the board
};

/// What `camera` sees of a board on a sheet of paper, before a background of grey: BGR, 3 bytes a pixel, rows
/// from the top. A pixel gathers the light of its square, from u - 1/2 to u + 1/2, v alike, through the
/// camera's lens. From behind the sheet is plain, unless the board is two-sided.
std::vector<std::uint8_t> drawBoard(const Board& board, const Camera& camera, const Pose& world_from_board,
                                    const BoardShot& shot = {});

/// The corners that such an image shows, exactly where they are, up to `margin_px` from its edges; none from
/// behind, unless the board is two-sided.
BoardView trueView(const Board& board, const Camera& camera, const Pose& world_from_board,
                   double margin_px = 0);

/// A board whose centre stands `distance_m` before the camera on its axis, facing it, upright; then moved by
/// `offset_m` in the camera's frame and turned about its centre by the rotation vector `turn`, radians,
/// camera frame. world_from_board.
Pose boardBefore(const Board& board, const Camera& camera, double distance_m, const Vec3& turn = Vec3::Zero(),
                 const Vec3& offset_m = Vec3::Zero());

}  // namespace airclay
