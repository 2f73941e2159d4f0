// SPDX-License-Identifier: MIT
// The renderer's arguments. Everything is in metres in the workspace frame (camera_io.h); colours are linear
// light.
//
// Expensive lighting terms (the key light's soft shadow, openness) are computed per vertex by compute
// kernels; vertex shaders pass them on, and a pixel costs little. That suits a software device, and a fine
// mesh loses nothing.
#ifndef AIRCLAY_RENDERER_IO_H
#define AIRCLAY_RENDERER_IO_H

#include "shaders/core/io.h"

AIRCLAY_IO_BEGIN

const uint kRenderWorkgroup = 64;

// Half the edge of the lit square of ground, in workspace edges. Its vertices are denser towards the middle.
const float kGroundHalf = 1.6f;

// The density of surface: a pyramid of cubes around the workspace, kDensityCells along an edge and then half
// and a quarter as many. A cell stores surface area / (its own edge)²: about 1 for one sheet.
const uint kDensityCells = 32;
const uint kDensityLevels = 3;
const uint kDensityTotal = 32 * 32 * 32 + 16 * 16 * 16 + 8 * 8 * 8;
const float kDensityUnit = 65536;  // areas are summed as integers, so that their order does not matter

// The light kernel's parameters for an image.
struct RenderFrame {
  vec4 light_row[3];   // shadow_clip_from_workspace; parallel light
  vec3 key_direction;  // unit, towards the key light
  uint shadow_size;    // texels along the shadow map's edge
  float shadow_texel_m;
  float shadow_depth_m;  // from depth 0 to depth 1
  uint shadow_taps;
  float edge_m;  // of the workspace
  mat3 hand_from_workspace;
  vec3 workspace_in_hand;  // translation of hand_from_workspace
  vec3 grid_low_corner;    // the hand's distance grid (engine/mesh/distance_grid.h), hand frame
  float grid_cell_m;
  uint grid_size[3];
};
READ_POINTER(ReadRenderFrames, RenderFrame)

// The light that arrives at a vertex.
struct VertexLight {
  float key;         // fraction of the key light
  float open_front;  // openness to ambient light on the normal's side
  float open_behind;
  float upward;  // z component of the normal
  float hand_m;  // signed distance to the hand's skin; kFarM if it is not used
};
READ_POINTER(ReadVertexLights, VertexLight)
WRITE_POINTER(WriteVertexLights, VertexLight)

const float kFarM = 1.0f;

// render_density.comp: adds a mesh's area to the finest cells. One invocation per triangle.
struct RenderDensityArgs {
  ReadVec3s positions;
  ReadUints triangles;
  ReadWriteUints areas;
  mat3 rotation;  // workspace_from_mesh
  vec3 translation;
  uint triangle_count;
  float edge_m;
  float weight;  // factor of its area: less than 1 for translucent surfaces
};

// render_density_levels.comp: the pyramid from the finest cells. One invocation per coarsest cell.
struct RenderLevelArgs {
  ReadUints areas;
  WriteFloats densities;
};

// render_light.comp. One invocation per vertex.
struct RenderLightArgs {
  ReadRenderFrames frame;
  ReadFloats shadow_map;
  ReadFloats densities;
  ReadFloats hand_grid;  // 0: the vertices belong to the hand, or there is no hand
  ReadVec3s positions;
  ReadVec3s normals;
  WriteVertexLights lights;
  ReadUints device_count;  // 0: use `count`; else the smaller of the two
  mat3 rotation;           // workspace_from_mesh; may scale
  vec3 translation;
  uint count;
  uint two_sided;
  uint shows_touch;  // whether hand_m is required
};

// render_ground_cells.comp: the ground's triangles, one invocation per cell.
struct RenderGroundArgs {
  ReadVertexLights lights;
  WriteUints triangles;  // six indices per cell, all 0 without visible shade
  uint side;             // vertices along the square's edge
};

// render_depth.vert; render_mesh.vert with render_clay.frag or render_skin.frag. Lighting is computed in the
// mesh frame.
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
  ReadUints indices;  // two per segment, one per dot; 0: in order
  mat4 clip_from_strokes;
  vec3 eye;  // the strokes' frame
  vec4 color;
  vec2 viewport;  // pixels
  float width;    // pixels
};

// A stroke moves towards the eye by this fraction of the distance, so that it is drawn in front of the
// surface below it: 4 mm at a metre, more than the distance of a data point below the display surface.
const float kStrokeNearer = 0.004f;

// A sphere swept along a link: radius_a at a, radius_b at b.
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
