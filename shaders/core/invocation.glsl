// SPDX-License-Identifier: MIT
// One invocation per item, in workgroups arranged in rows: a device need not accept more than 65,535 in x (groupRowsFor in
// engine/gpu/recorder.h).

layout(local_size_x_id = 0) in;  // must precede the use of gl_WorkGroupSize, which would be 1 otherwise

uint invocation() {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}
