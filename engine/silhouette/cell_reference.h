// SPDX-License-Identifier: MIT
// The reference implementation of the kernels around the evidence (shaders/silhouette/evidence_io.h), in
// double precision: background and sums of cells, masks, and colours that are learned.
//
// Spans start at a camera's first pixel, cell or tile.
#pragma once

#include "engine/silhouette/evidence.h"

namespace airclay {

/// The background of a cell: mean colour, and the variance of one pixel's channel.
struct CellBackground {
  Vec3 colour = Vec3::Zero();
  double variance = 0;
};
CellBackground cellBackgroundReference(int width, std::span<const std::uint32_t> model, int x, int y);

/// A tile's sums of image times background, of background squared and of image squared, from packed colours.
Vec3 tileSumsReference(std::span<const std::uint32_t> colours, std::span<const GpuCellBackground> background,
                       std::uint32_t tile_columns, int tile_x, int tile_y);

/// The increase of the residual of cell (x, y) by the texture that its tiles lack. `sums`: kTileSums per
/// tile; `noise`: the cell's variance with the unexplained texture.
double textureReference(std::span<const float> sums, std::uint32_t tile_columns, const GpuTileRegion& region,
                        int x, int y, double noise, const EvidenceAssumptions& assumptions);

/// The mask of the cells whose evidence is positive. `evidence`: one byte per cell.
Silhouette evidenceMaskReference(const Camera& camera, const GpuTileRegion& region,
                                 std::span<const std::uint8_t> evidence);

/// A mask as an image: BGR bytes, white on black.
std::vector<std::uint8_t> maskImageReference(const Silhouette& mask);

/// The input of colourCountsReference().
struct ColourView {
  GpuTileRegion region;
  std::span<const std::uint32_t> colours;  ///< packed
  std::span<const std::uint8_t> evidence;
  Silhouette mask;  ///< of the fitted hand
  Vec2 arm_from = Vec2::Zero(), arm_to = Vec2::Zero();
  double arm_radius = 0;  ///< pixels
};
/// The numbers of colours of the hand and of everything else that moves: kColourCounts each.
std::vector<std::uint32_t> colourCountsReference(const ColourView& view);

/// A histogram after learning `counts`: kColourTable bins, then their sum.
std::vector<double> histogramReference(std::span<const float> histogram,
                                       std::span<const std::uint32_t> counts, double rate);

}  // namespace airclay
