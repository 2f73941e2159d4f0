// SPDX-License-Identifier: MIT
// The search for the hand from nothing, in device memory: a coarse hull of what is probably the hand, and the
// score of many hypothetical poses.
#ifndef AIRCLAY_SEARCH_IO_H
#define AIRCLAY_SEARCH_IO_H

#include "shaders/hand/outline_io.h"

AIRCLAY_IO_BEGIN

// search_shrink: the mean probability of the hand in each block of 4 x 4 pixels, 0 to 255, one byte. The four
// blocks of a tile are one word: two in the upper row, two in the lower. One invocation per tile.
const uint kBlockPixels = 4;

struct SearchShrinkArgs {
  ReadCameras cameras;
  ReadUints evidence;
  WriteUints blocks;
};

// search_hull: voxels whose mean log-probability over the cameras exceeds that of kHullProbability; a camera
// that does not see a voxel counts as ½, and two must see it. One invocation per kHullRun voxels along x: one
// word.
const uint kHullVoxels = 64;  // along the workspace's edge
const uint kHullRun = 32;
const float kHullProbability = 0.683f;
const float kHullLeast = 0.02f;  // probabilities are limited to this and its complement

struct SearchHullArgs {
  ReadCameras cameras;
  ReadUints blocks;
  WriteUints words;
  uint camera_count;
  uint camera_bits;  // that have an image
  float voxel_m;
};

// search_score: how badly the blocks agree with a pose in one camera: the squared difference of the
// hypothesis (1 where a point of the skin projects, 0 elsewhere within kScoreMargin cells) and the
// probability, summed over the cells except the forearm's, divided by the cells of the hand. A cell is the
// whole number of blocks closest to kScoreCell; the window has kScoreWindow² cells around the centre of
// gravity. -1 where the camera sees too little. One workgroup per pose and camera.
const uint kScoreWindow = 64;
const uint kScoreMargin = 3;
const float kScoreCell = 0.007f;  // metres at the hand's distance
const uint kScoreLeast = 20;      // cells of the hand

struct SearchScoreArgs {
  ReadCameras cameras;
  ReadOutlineFrames frame;
  ReadOutlinePoses poses;
  ReadVec3s points;  // of the skin, from the centre of gravity
  ReadUints blocks;
  WriteFloats scores;  // of pose 0 in each camera, of pose 1, ...
  uint point_count;
  uint camera_count;
};

AIRCLAY_IO_END

#endif
