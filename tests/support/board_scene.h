// SPDX-License-Identifier: MIT
// Rendered images of calibration boards with known corners.
#pragma once

#include <cstdint>

#include "capture/calibration/board.h"
#include "engine/camera/rig.h"

namespace airclay {

/// Properties of an image.
struct BoardShot {
  double noise_sigma = 0;  ///< grey levels of 255; Gaussian, equal in all three channels
  std::uint32_t seed = 1;  ///< of the noise
  double blur_px = 0;      ///< sigma of a Gaussian blur, in addition to the pixel's area
  double black = 30, white = 220, background = 100;  ///< grey values of 255
  double paper_m = 0.02;                             ///< white paper around the board
};

/// The image of a board on a sheet of paper in front of a grey background: BGR, 3 bytes per pixel, rows
/// from the top. A pixel integrates the light of its square, from u - 1/2 to u + 1/2, likewise v, through
/// the camera's lens. The back of the sheet is blank unless the board is two-sided.
std::vector<std::uint8_t> drawBoard(const Board& board, const Camera& camera, const Pose& world_from_board,
                                    const BoardShot& shot = {});

/// The exact corners in such an image that are at least `margin_px` from its edges; empty from behind,
/// unless the board is two-sided.
BoardView trueView(const Board& board, const Camera& camera, const Pose& world_from_board,
                   double margin_px = 0);

/// world_from_board of a board whose centre is `distance_m` in front of the camera on its axis, upright and
/// facing it; then moved by `offset_m` in the camera frame and rotated about its centre by the rotation
/// vector `turn`, radians, camera frame.
Pose boardBefore(const Board& board, const Camera& camera, double distance_m, const Vec3& turn = Vec3::Zero(),
                 const Vec3& offset_m = Vec3::Zero());

}  // namespace airclay
