// SPDX-License-Identifier: MIT
// From pixels to silhouettes: the background model, the segmentation, and the mask cleaning.
#ifndef AIRCLAY_SILHOUETTE_IO_H
#define AIRCLAY_SILHOUETTE_IO_H

#include "shaders/camera/camera_io.h"

AIRCLAY_IO_BEGIN

const uint kSilhouetteWorkgroup = 64;

// Masks are processed 64 pixels at a time, as a pair of words.
READ_POINTER(ReadPairs, uint64_t)
WRITE_POINTER(WritePairs, uint64_t)
READ_WRITE_POINTER(ReadWritePairs, uint64_t)

// A pixel of the background model is one word: mean B, G, R in the low three bytes; the spread, in eighths of
// a grey level, in the high one. While learning, a pixel has a pair of words for each of B, G, R: the sum,
// and the sum of squares.
const float kSpreadStep = 0.125f;
const uint kLearnSums = 3;
const uint kMaxLearnFrames = 256;  // 256 · 255² still fits 32 bits

// 2.5 grey levels: the noise of an ordinary camera indoors. H.264 smooths it away and repeats an empty image
// unchanged, so that the learned spread is 0; it then re-encodes what the hand passes, with errors as large
// as the noise was.
const float kMinSpread = 2.5f;

// A pixel's score is how far it differs from the background, in units of the expected chance deviation:
// linear in how much of the pixel the object covers. A shadow keeps the colour and reduces the brightness to
// no less than this fraction; a change of light raises it to no more than that.
const float kDarkest = 0.6f;
const float kBrightest = 1.2f;
// Colour may differ by this many spreads. 3: one pixel in 90 of Gaussian noise, which the majority removes.
const float kColourSpreads = 3.0f;

// The score is stored as bits: whether it is at least 1, 2, 4, 8; one pair of words per level for each pair
// of the mask, one after the other.
const uint kScoreLevels = 4;

// background_add: adds a frame to the sums. background_finish: turns the sums into the model.
struct BackgroundArgs {
  ReadCameras cameras;
  ReadUints images;
  ReadWritePairs sums;
  WriteUints model;
  uint frames;  // so far
  uint first_camera;
};

// segment: one invocation per pair of mask words writes its pairs of levels. `images` are BGR bytes, rows
// without padding, each camera's image starting at a whole word.
struct SegmentArgs {
  ReadCameras cameras;
  ReadUints images;
  ReadUints model;
  WritePairs levels;
};

// How far an edge is smeared: 2 pixels. Video has one colour sample per 2 x 2 pixels, and its coding blurs
// that.
const int kSmearReach = 2;

// edges: the masks from the levels. A pixel is object if its score is at least 1, unless it is the smear of
// an edge: along a row, a column or a diagonal there is background on one side, and on the other a score of 4
// or more (its own below 2) or of 8 or more (its own below 4): the object ends where the score has fallen to
// half. The sides must be opposite; otherwise every pinhole would erode an object of low contrast.
struct EdgeArgs {
  ReadCameras cameras;
  ReadPairs levels;
  WritePairs masks;
};

// majority: a pixel takes the value of at least five of its 3 x 3 neighbourhood.
struct MajorityArgs {
  ReadCameras cameras;
  ReadPairs masks;
  WritePairs cleaned;
};

// Connected parts, by runs of pixels. A row has at most kMaxRuns of them; run i of row y of a camera is entry
// (y · kMaxRuns + i) after the camera's first. Its label is the index of its parent entry (its own index at a
// root).
const uint kMaxRuns = 256;             // a row of noise has more: the rest is dropped as speckle
const uint kBorderArea = 0x80000000u;  // flag in a root's area: the part touches the image's border

struct RunArgs {
  ReadCameras cameras;
  ReadPairs masks;
  ReadWriteUints run_counts;  // one per row
  ReadWriteUints runs;        // first | last << 16
  ReadWriteUints labels;
  ReadWriteUints areas;    // at roots
  ReadWriteUints largest;  // one per camera: the label of its largest part
  WritePairs result;
  uint max_rows;
  uint holes;  // 1: the parts are of the background, four-connected; else of the object, eight-connected
  uint largest_hole;  // pixels: smaller holes are closed
};

AIRCLAY_IO_END

#endif
