// SPDX-License-Identifier: MIT
// The fit of the hand's outline to the images of all cameras, in device memory.
//
// Each silhouette edge of the posed skin searches its place along its normal, a line of pixels across the
// outline; a Gauss-Newton step moves the hand so that the edges come to these places (the correspondence
// lines of RBOT, Tjaden et al. 2018, and of SRT3D and M3T, Stoiber et al. 2021-2023). A coarse search weighs
// the evidence for the hand (evidence_io.h); a fine one compares the colours next to the line's two ends with
// the known background of every pixel.
#ifndef AIRCLAY_OUTLINE_IO_H
#define AIRCLAY_OUTLINE_IO_H

#include "shaders/hand/hand_pose_io.h"
#include "shaders/silhouette/evidence_io.h"

AIRCLAY_IO_BEGIN

const uint kOutlineWorkgroup = 64;
const uint kOutlineCameras = 32;

// An edge of the skin: its ends, and the opposite corners of the triangles at its left and right.
struct GpuOutlineEdge {
  uint from, to;
  uint left, right;
};

struct GpuTriangle {
  uint corners[3];
};

READ_POINTER(ReadOutlineEdges, GpuOutlineEdge)
READ_POINTER(ReadTriangles, GpuTriangle)
READ_POINTER(ReadVec2s, vec2)
WRITE_POINTER(WriteVec2s, vec2)
WRITE_POINTER(WriteVec4s, vec4)

// What the fit estimates: the root as in GpuHandPose, and the size relative to the model's.
struct GpuOutlinePose {
  vec4 rotation;
  vec3 position;
  float scale;
};

READ_POINTER(ReadOutlinePoses, GpuOutlinePose)
READ_WRITE_POINTER(ReadWriteOutlinePoses, GpuOutlinePose)

// The hand's motion during a frame, and the forearm.
struct GpuOutlineFrame {
  vec3 velocity;      // of the root's position, m/s
  float arm_radius;   // metres
  vec3 spin;          // rad/s
  uint cameras;       // bits of the cameras that have an image
  vec3 arm_from;      // ends of the forearm's axis, hand frame from the centre of gravity, metres
  float pad;
  vec3 arm_to;
  float pad2;
  float seconds[kOutlineCameras];  // each camera's time after the frame's
};

READ_POINTER(ReadOutlineFrames, GpuOutlineFrame)

// outline_project: projects the skin into each camera at the camera's own time, and the forearm. Each invocation
// projects several vertices of a camera. A vertex that the lens model does not cover is at
// kNotProjected.
const float kNotProjected = -1e9f;
const float kNearest = 0.05f;  // metres: the forearm's axis is cut off at this depth

struct OutlineProjectArgs {
  ReadCameras cameras;
  ReadOutlineFrames frame;
  ReadOutlinePoses pose;
  ReadVec3s vertices;  // from the centre of gravity, metres
  WriteVec2s pixels;   // vertices of camera 0, of camera 1, ...
  WriteVec4s forearms; // two per camera: the ends in pixels; the radius in pixels in z of the first
  uint vertex_count;
};

// outline_mask: sets the pixels whose centres are in a front-facing triangle. One invocation per triangle and
// camera.
struct OutlineMaskArgs {
  ReadCameras cameras;
  ReadTriangles triangles;
  ReadVec2s pixels;
  ReadWriteUints masks;
  uint triangle_count;
  uint vertex_count;
};

// outline_list: the edges between a front and a back face in each camera, in order: a count, then up to
// kOutlineLines edges. One subgroup per camera.
const uint kOutlineLines = 1023;
const uint kOutlineList = kOutlineLines + 1;

struct OutlineListArgs {
  ReadOutlineFrames frame;
  ReadOutlineEdges edges;
  ReadVec2s pixels;
  WriteUints lists;
  uint edge_count;
  uint vertex_count;
};

// A line's result: how the projected edge moves along the line's normal with the pose (position, rotation
// vector in workspace axes, logarithm of the scale), where the image has it, and the weight 1 / variance.
struct GpuOutlineLine {
  float row[7];
  float offset;  // pixels, positive outwards
  float weight;  // pixels⁻², 0: no evidence
  float length_;  // of the edge in pixels, 0: not part of the outline
  uint judged;    // 0: too short to tell whether the image agrees: thin fingers, narrow gaps
  float blur;     // how far the edge moves along the line during an exposure, pixels
};

READ_POINTER(ReadOutlineLines, GpuOutlineLine)
WRITE_POINTER(WriteOutlineLines, GpuOutlineLine)

// The mask just inside and just outside an edge must differ at this distance, and stay empty up to the second
// one, in pixels.
const float kBesideEdge = 1.5f;
const float kClearOfEdge = 2.5f;
const float kShortestEdge = 0.3f;
// The line's weight is that of a piece this long.
const float kLinePixels = 4;
const float kLongestLine = 6;

// outline_coarse: searches a line up to `reach` pixels either way. The probability that the edge is at d is
// proportional to exp(kEvidenceTrust Σ evidence up to d - d² / (2 spread²)).
const float kEvidenceTrust = 0.4f;
const float kCoarseDeviation = 1;  // pixels, at least

struct OutlineCoarseArgs {
  ReadCameras cameras;
  ReadOutlineFrames frame;
  ReadOutlinePoses pose;
  ReadVec3s vertices;
  ReadOutlineEdges edges;
  ReadVec2s pixels;
  ReadUints lists;
  ReadUints masks;
  ReadVec4s forearms;
  ReadTileRegions regions;
  ReadUints evidence;
  WriteOutlineLines lines;
  uint vertex_count;
  uint reach;
  float spread;
};

// outline_fine: where the mixture of a linear colour on the inside and the known background on the outside
// explains the line's pixels best. Candidates are kFineStep apart; the transition is a ramp kFineRamp wide.
const int kFineInside = 4;   // pixels
const int kFineShortest = 3; // on the inside
const int kFineOutside = 6;
const int kFineReach = 3;
const float kFineStep = 0.5f;
const float kFineRamp = 2;         // pixels
const float kExposure = 0.01f;  // seconds, of an ordinary camera indoors
const float kMostBlur = 6;       // pixels
const float kFineNoise = 4;        // grey levels
const float kFineSlope = 6;        // grey levels per pixel: expected shading on the inside
const float kFineDeviation = 0.35f;  // pixels, at least
const float kFineOutlier = 1;      // pixels: half the weight
// Outside, from kFineNear to kFineFar pixels, the background must fit within this residual; otherwise another
// person is behind the hand, and the mean colour there replaces the background.
const int kFineNear = 3;
const int kFineFar = 6;
const float kFineOther = 10;  // grey levels
const float kFineFlat = 0.6f;  // of the variance of a uniform distribution: more than this is no evidence

struct OutlineFineArgs {
  ReadCameras cameras;
  ReadOutlineFrames frame;
  ReadOutlinePoses pose;
  ReadVec3s vertices;
  ReadOutlineEdges edges;
  ReadVec2s pixels;
  ReadUints lists;
  ReadUints masks;
  ReadVec4s forearms;
  ReadUints images;
  ReadUints model;
  ReadFloats gains;
  WriteOutlineLines lines;
  uint vertex_count;
};

// outline_solve: one damped Gauss-Newton step from all lines; the last one also reports. One workgroup.
const uint kOutlineUnknowns = 7;
const uint kOutlineSums = 28;
const float kOutlineShift = 0.02f;  // m: damping
const float kOutlineTurn = 0.3f;    // rad
const float kOutlineMaxShift = 0.03f;
const float kOutlineMaxTurn = 0.3f;
const float kGoodOffset = 1.5f;  // pixels, plus half the blur: a line that agrees

// The sums over the lines of the last step, before it: a measure of the fit.
struct GpuOutlineFit {
  GpuOutlinePose pose;
  float information[kOutlineSums];  // of the unknowns, lower triangle, row by row
  float residual;                   // Σ weight offset²
  float weight;                     // Σ weight
  uint lines;                       // with evidence
  float judged_length;              // of the outline that can be judged, pixels
  float camera_length[kOutlineCameras];  // of the outline, pixels
  float camera_good[kOutlineCameras];    // where the lines agree
};

WRITE_POINTER(WriteOutlineFits, GpuOutlineFit)

struct OutlineSolveArgs {
  ReadUints lists;
  ReadOutlineLines lines;
  ReadWriteOutlinePoses pose;
  WriteOutlineFits result;
  uint cameras;         // count
  float scale_weight;   // of the scale's prior, in 1 / its variance; 0: the scale is fixed
  float prior_scale;    // logarithm
};

// outline_judge: whether the images confirm the fit: kTrackedAgreement of the whole outline agrees, over all
// cameras, or nearly all of what can be judged of it; and kCameraAgreement of it in at least kAgreeingCameras.
// One invocation. Writes the pose for the clay.
const float kTrackedAgreement = 0.65f;
const float kJudgedAgreement = 0.92f;  // of what can be judged, if that is kLeastJudged of the outline
const float kLeastJudged = 0.4f;
const float kUncertainAgreement = 0.4f;
const float kCameraAgreement = 0.4f;
const uint kAgreeingCameras = 2;
const float kLeastOutline = 30;  // pixels: a camera with less has no say

READ_POINTER(ReadOutlineFits, GpuOutlineFit)

struct OutlineJudgeArgs {
  ReadOutlineFits fit;
  WriteHandPoses hand;
  uint cameras;  // count
};

AIRCLAY_IO_END

#endif
