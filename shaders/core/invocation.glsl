// SPDX-License-Identifier: MIT
// One invocation an item, in workgroups laid out in rows, for a device need not take more than 65,535 in x (groupRowsFor in
// engine/gpu/recorder.h).

layout(local_size_x_id = 0) in;  // before gl_WorkGroupSize is used, which would be 1 otherwise

uint invocation() {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}
