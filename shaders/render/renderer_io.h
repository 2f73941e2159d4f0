// SPDX-License-Identifier: MIT
// The renderer's arguments. All is in metres in the workspace's frame (camera_io.h), colours are linear
// light.
//
// Light that is slow to find (the key light's soft shadow, how open a place is) is found per vertex by
// compute kernels; a vertex shader then hands it on, and a pixel costs little. That suits a software device,
// and a fine surface loses nothing.
#ifndef AIRCLAY_RENDERER_IO_H
#define AIRCLAY_RENDERER_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

const uint kRenderWorkgroup = 64;

// The square of ground that is lit reaches so many workspace edges to each side. Its vertices stand closer
// towards its middle.
const float kGroundHalf = 1.6f;

// How much surface stands where: a pyramid of cubes around the workspace, kDensityCells along an edge and
// then half and a quarter as many. A cell holds surface area / (its own edge)²: about 1 where one sheet
// passes.
const uint kDensityCells = 32;
const uint kDensityLevels = 3;
const uint kDensityTotal = 32 * 32 * 32 + 16 * 16 * 16 + 8 * 8 * 8;
const float kDensityUnit = 65536;  // areas are summed in whole numbers, so that their order is of no matter

// What the light kernel knows of an image.
struct RenderFrame {
  vec4 light_row[3];   // the shadow map's clip space from the workspace; parallel light
  vec3 key_direction;  // unit, towards the key light
  uint shadow_size;    // texels along the shadow map's edge
  float shadow_texel_m;
  float shadow_depth_m;  // from depth 0 to depth 1
  uint shadow_taps;
  float edge_m;  // the workspace's
  mat3 hand_from_workspace;
  vec3 workspace_in_hand;  // its translation
  vec3 grid_low_corner;    // the hand's distance grid (engine/mesh/distance_grid.h), hand frame
  float grid_cell_m;
  uint grid_size[3];
};
READ_POINTER(ReadRenderFrames, RenderFrame)

// What arrives at a vertex.
struct VertexLight {
  float key;         // share of the key light
  float open_front;  // openness to the light all around, on the normal's side
  float open_behind;
  float upward;  // the normal's part along z
  float hand_m;  // signed distance to the hand's skin; kFarM where it does not count
};
READ_POINTER(ReadVertexLights, VertexLight)
WRITE_POINTER(WriteVertexLights, VertexLight)

const float kFarM = 1.0f;

// render_density.comp: adds a mesh's area to the finest cells. An invocation a triangle.
struct RenderDensityArgs {
  ReadVec3s positions;
  ReadUints triangles;
  ReadWriteUints areas;
  mat3 rotation;  // workspace_from_mesh
  vec3 translation;
  uint triangle_count;
  float edge_m;
  float weight;  // of its area: less than 1 where light comes through
};

// render_density_levels.comp: the pyramid from the finest cells. An invocation one of the coarsest cells.
struct RenderLevelArgs {
  ReadUints areas;
  WriteFloats densities;
};

// render_light.comp. An invocation a vertex.
struct RenderLightArgs {
  ReadRenderFrames frame;
  ReadFloats shadow_map;
  ReadFloats densities;
  ReadFloats hand_grid;  // 0: the vertices belong to the hand or there is none
  ReadVec3s positions;
  ReadVec3s normals;
  WriteVertexLights lights;
  ReadUints device_count;  // 0: `count` holds; else the smaller of the two
  mat3 rotation;           // workspace_from_mesh; may scale
  vec3 translation;
  uint count;
  uint two_sided;
  uint shows_touch;  // whether hand_m is wanted
};

// render_ground_cells.comp: the ground's triangles, an invocation a cell.
struct RenderGroundArgs {
  ReadVertexLights lights;
  WriteUints triangles;  // six indices a cell, all 0 where there is no shade to be seen
  uint side;             // vertices along the square's
};

// render_depth.vert; render_mesh.vert with render_clay.frag or render_skin.frag. Light is reckoned in the
// mesh's own frame.
struct RenderMeshArgs {
  ReadVec3s positions;
  ReadVec3s normals;
  ReadVertexLights lights;
  mat4 clip_from_mesh;
  vec3 eye;            // mesh frame
  vec3 key_direction;  // mesh frame
  vec3 albedo;
  float opacity;
};

// render_backdrop.vert, .frag; render_ground.vert, .frag
struct RenderBackdropArgs {
  ReadVec3s positions;  // of the ground: -1 to 1; 0 for the backdrop
  ReadVertexLights lights;
  mat4 clip_from_ground;
  vec3 top;  // colour of the image's upper edge
  vec3 bottom;
  vec2 viewport;  // pixels
};

// render_strokes.vert, .frag: a segment or a dot of constant width in the image, with round ends.
// Specialization constant 0: 1 for dots.
struct RenderStrokeArgs {
  ReadVec3s points;
  ReadUints indices;  // two a segment, one a dot; 0: in order
  mat4 clip_from_strokes;
  vec3 eye;  // the strokes' frame
  vec4 color;
  vec2 viewport;  // pixels
  float width;    // pixels
};

// A stroke is pulled this share of the distance towards the eye, so that it stands before the surface on
// which it lies: 4 mm at a metre, more than a data point lies beneath the display surface.
const float kStrokeNearer = 0.004f;

// A ball pulled along a link: radius a at a, radius b at b.
struct RenderCapsule {
  vec3 a;
  vec3 b;
  float radius_a;
  float radius_b;
  vec3 albedo;
};
READ_POINTER(ReadCapsules, RenderCapsule)

const uint kCapsuleSides = 20;
const uint kCapsuleRings = 8;  // from pole to pole, half of them at each end
const uint kCapsuleVertices = kCapsuleSides * (kCapsuleRings - 1) * 6;

// render_capsules.vert, .frag
struct RenderCapsuleArgs {
  ReadCapsules capsules;
  mat4 clip_from_workspace;
  vec3 eye;
  vec3 key_direction;
};

AIRCLAY_IO_END

#endif
