// SPDX-License-Identifier: MIT
// Evidence for the hand in a real room: for each cell of 2 x 2 pixels, the logarithm of how much more likely
// its colour is for the hand than for anything else, in device memory.
//
// Three things explain a colour: the background in any light from full shadow to a little brighter, with one
// light factor per neighbourhood; the hand's colours; the colours of everything else that moves. The last two
// are histograms, learned while the hand is tracked.
#ifndef AIRCLAY_EVIDENCE_IO_H
#define AIRCLAY_EVIDENCE_IO_H

#include "shaders/silhouette/silhouette_io.h"

AIRCLAY_IO_BEGIN

const uint kEvidenceWorkgroup = 64;

// A cell is 2 x 2 pixels, a tile 4 x 4 cells. An image has width / 8 x height / 8 tiles, rounded down: up to
// 7 columns and rows at its right and lower edges have no evidence. Cells are stored row by row; the tiles
// and cells of all cameras follow one another, starting at pixels_before / 64 and 4 (pixels_before / 16).
const uint kCellPixels = 2;
const uint kTileCells = 4;
const uint kEvidenceTile = 8;  // pixels

// Evidence is one byte per cell, four cells per word: bit 0 is set if the cell differs from the background;
// the other bits are kEvidenceZero + kEvidenceSteps times the log-likelihood ratio, which is clipped at
// kMaxEvidence either way. Tiles outside a camera's region stay as they were.
const float kMaxEvidence = 4;
const float kEvidenceSteps = 15.75f;
const uint kEvidenceZero = 64;

// The mean colour of a cell, B, G, R, in quarters of a grey level, 10 bits each from the lowest.
const float kCellColourStep = 0.25f;

// The background of a cell.
struct GpuCellBackground {
  uint colour;     // as above
  float variance;  // of one pixel's channel, squared grey levels
};

READ_POINTER(ReadCellBackgrounds, GpuCellBackground)
WRITE_POINTER(WriteCellBackgrounds, GpuCellBackground)

// The tiles in which evidence is computed: x and y from low to less than high.
struct GpuTileRegion {
  uint low[2];
  uint high[2];
};

READ_POINTER(ReadTileRegions, GpuTileRegion)

// The light factor of a neighbourhood is limited to the range from the least light, an argument, to
// kMostLight. Where the hand has the table's colour, full shadow explains it; with kDaylight as the least
// light, a shadow counts as a change instead. Below kDimmest or above kBrighter it becomes
// an unlikely explanation, within kDimmerSpread and kBrighterSpread.
const float kFullShadow = 0.35f;
const float kDaylight = 0.9f;
const float kMostLight = 1.15f;
const float kDimmest = 0.75f;
const float kDimmerSpread = 0.25f;
const float kBrighter = 1.05f;
const float kBrighterSpread = 0.05f;
// The light factor leaves a residual in a tile. Where the hand has the table's colour, only the missing texture
// of the table gives it away: a cell's squared residual, in units of twice the variance, is increased by a
// trust, an argument, times the tile's mean beyond kTileNoise, by at most kTileChange either way.
const uint kTileSums = 3;
const float kTextureTrust = 2;
const float kTileNoise = 2;
const float kTileChange = 4;
// A cell counts as changed if its squared residual is this many times twice the variance, where light below
// kChangedLight counts as a residual as well, in units of kChangedLightSpread.
const float kChangedResidual = 6;
const float kChangedLight = 0.6f;
const float kChangedLightSpread = 0.15f;
// The noise of a colour is the background's plus this fraction of its brightness: texture that the light
// factor does not explain.
const float kTextureNoise = 0.02f;
// Probability of the background where a colour is not the hand's, and the weights of the uniform densities
// mixed into the histograms.
const float kBackgroundPrior = 0.7f;
const float kHandUniform = 0.02f;
const float kOtherUniform = 0.3f;
// Before its colours are known, the hand is assumed to be this much denser in colour space than uniform.
const float kUnknownHandDensity = 30;

// Colour histograms have kColourBins per channel. Tables give the smoothed density relative to a uniform one.
const uint kColourBins = 24;
const uint kColourTable = kColourBins * kColourBins * kColourBins;

// evidence_background: one invocation per cell, from the background model of every pixel.
struct EvidenceBackgroundArgs {
  ReadCameras cameras;
  ReadUints model;
  WriteCellBackgrounds cells;
  uint first_camera;
};

// evidence_gain: one workgroup per camera; the ratio of image to background in each channel, from every
// kGainStep-th pixel in x and y: the mean of the ratios within kGainSpread of their median, from a histogram
// of kGainBins between kLeastGain and kLeastGain + 1, repeated kGainRounds times about the last mean. Pixels
// that are dark in the background or saturated do not count. Four floats per camera: B, G, R, unused.
const uint kGainStep = 16;
const uint kGainBins = 256;
const uint kGainRounds = 4;
const float kLeastGain = 0.5f;
const float kGainSpread = 0.08f;
const float kGainOffset = 4;  // grey levels, added to both
const uint kGainDark = 8;
const uint kGainSaturated = 250;

struct EvidenceGainArgs {
  ReadCameras cameras;
  ReadUints images;
  ReadUints model;
  WriteFloats gains;
};

// evidence_cells: one invocation per tile of the region: the colours of its cells, divided by the gains, and
// the sums of image times background, of background squared and of image squared, over cells and channels.
struct EvidenceCellArgs {
  ReadCameras cameras;
  ReadUints images;
  ReadFloats gains;
  ReadCellBackgrounds background;
  ReadTileRegions regions;
  WriteUints colours;
  WriteFloats sums;  // kTileSums per tile
};

// evidence: one invocation per row of four cells of a tile. The light factor is the ratio of the tiles' sums,
// each interpolated bilinearly between the tiles' centres.
struct EvidenceArgs {
  ReadCameras cameras;
  ReadCellBackgrounds background;
  ReadTileRegions regions;
  ReadUints colours;
  ReadFloats sums;
  ReadFloats tables;  // per camera: the hand's density, then that of everything else
  WriteUints evidence;
  float least_light;
  float texture_trust;
};

// evidence_count: counts the colours of cells well inside the fitted hand, and of changed cells away from it
// and its forearm. One invocation per row of four cells of a tile; the counts of all bins, then the sum.
const uint kColourCounts = kColourTable + 1;
const int kInsideCells = 1;    // the hand covers the 3 x 3 cells
const int kOutsideCells = 4;   // the hand covers none of the 9 x 9 cells
struct EvidenceCountArgs {
  ReadCameras cameras;
  ReadTileRegions regions;
  ReadUints colours;
  ReadUints evidence;
  ReadUints masks;         // of the fitted hand, one bit per pixel
  ReadVec4s forearms;      // two per camera: both ends in pixels, and the radius in z of the first
  ReadWriteUints counts;   // of the hand, then of everything else
  uint camera;
};

// evidence_histogram: blends the counts into a camera's histograms, which have a sum of 1. A histogram with
// fewer than kMinColours new colours stays as it is. One invocation per bin and histogram.
const uint kMinColours = 8;
struct EvidenceHistogramArgs {
  ReadUints counts;
  ReadWriteFloats histograms;  // per camera: the hand's, then that of everything else
  uint camera;
  float rate;  // weight of the new colours
};

// evidence_table: smooths a camera's histograms by the binomial filter 1 2 1 in each channel and mixes in the
// uniform density. One invocation per row of bins along the last channel, and histogram.
struct EvidenceTableArgs {
  ReadFloats histograms;
  WriteFloats tables;
  uint camera;
};

// background_adapt: keeps the background up to date outside the region of the hand, in every kAdaptRows-th row
// of cells per frame, from row `phase` on. A pixel that shows the same other colour kAdaptVisits times in a row
// has a new background: a cup put down, a cloud. Anything that moves, shadows included, changes nothing. One
// invocation per cell.
const uint kAdaptRows = 16;
const uint kAdaptVisits = 20;  // about 10 s at 30 Hz
const uint kAdaptNoise = 4;    // grey levels per channel: still the background
const uint kAdaptSame = 8;     // still the other colour

struct BackgroundAdaptArgs {
  ReadCameras cameras;
  ReadUints images;
  ReadFloats gains;
  ReadTileRegions regions;  // not adapted
  ReadWriteUints model;
  ReadWriteUints candidates;  // per pixel: the other colour, and how many times it was seen, in the high byte
  WriteCellBackgrounds cells;
  uint phase;
};

// evidence_mask: the pixels of cells whose evidence is positive, as a mask. One invocation per word of a mask
// and row of cells; pixels outside the region are not set.
struct EvidenceMaskArgs {
  ReadCameras cameras;
  ReadTileRegions regions;
  ReadUints evidence;
  WriteUints masks;
};

// mask_image: a mask as an image, white on black. One invocation per word of the image.
struct MaskImageArgs {
  ReadCameras cameras;
  ReadUints masks;
  WriteUints images;
};

AIRCLAY_IO_END

#endif
