// SPDX-License-Identifier: MIT
// Decides whether a frame's repeats continue, and how far the next step goes: for a check of one workgroup, whose arguments have
// `args.decision`.
//
// Target displacements x of the touched points (along their directions, or as vectors) move them by Q x, Q = E A A⁺ Eᵀ (E maps them to all
// data points), symmetric with eigenvalues between 0 and 1, mostly far below 1: the cage spreads the displacements of few points over all.
// The largest Rayleigh quotient of Q found in this frame, from the steps so far and their results, estimates its largest eigenvalue L; 1 /
// L is the step of gradient descent.
// Nesterov's momentum (1983) is added, as in Mazhar et al. 2015, "Using Nesterov's method to accelerate multibody dynamics with friction
// and contact".
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require

// Partial sums over some of the points.
struct Findings {
  float achieved;  // sum of the last target displacements times the achieved ones
  float pushed;    // sum of the squares of the target displacements
  float left_m;    // the largest remaining depth or lag
  uint touched;
};

shared float achieved_of[32], pushed_of[32], left_of[32];  // at most 32 subgroups
shared uint touched_of[32];

void decideAll(Findings found) {
  const ContactGroups groups = args.decision.groups;
  GpuContactFrame frame = args.decision.frame.at[0];
  frame.touched = found.touched;
  frame.depth_m = found.left_m;
  if (found.touched > 0) frame.gripped = 1;
  if (found.pushed > 0) frame.quotient = max(frame.quotient, clamp(found.achieved / found.pushed, kContactMinQuotient, 1));
  if (frame.repeats == 0 || found.left_m < kContactShrinks * frame.least_m) {
    frame.least_m = found.left_m;
    frame.stalls = 0;
  } else {
    ++frame.stalls;
  }
  const bool done = frame.mode != kFrameSweep || found.left_m < args.decision.target_m || frame.stalls == args.decision.max_stalls ||
                    frame.repeats == args.decision.max_repeats;
  frame.done = done ? 1 : 0;
  frame.step = frame.quotient > 0 ? 1 / frame.quotient : 1;
  frame.momentum = 0;
  if (frame.repeats >= 2) {  // the first step has no quotient yet, and the second is the first with its step size
    const float next = 0.5 * (1 + sqrt(1 + 4 * frame.theta * frame.theta));
    frame.momentum = (frame.theta - 1) / next;
    frame.theta = next;
  }
  if (!done) ++frame.repeats;
  frame.find_groups = GpuGroups(done ? 0 : groups.points_x, groups.points_y, groups.images);
  frame.point_groups = GpuGroups(done ? 0 : groups.points_x, groups.points_y, 1);
  frame.project_groups = GpuGroups(done ? 0 : groups.project, 1, 1);
  frame.apply_groups = GpuGroups(done ? 0 : groups.apply, 1, 1);
  frame.check_groups = GpuGroups(done ? 0 : 1, 1, 1);
  frame.normal_groups = GpuGroups(done && frame.repeats > 0 ? groups.points_x : 0, groups.points_y, 1);
  args.decision.frame.at[0] = frame;
  args.decision.summary.at[0] = GpuContactSummary(found.touched, frame.repeats, found.left_m, frame.done);
}

// `found` is this invocation's part. Sums in a fixed order.
void decide(Findings found) {
  found.achieved = subgroupAdd(found.achieved);
  found.pushed = subgroupAdd(found.pushed);
  found.left_m = subgroupMax(found.left_m);
  found.touched = subgroupAdd(found.touched);
  if (gl_NumSubgroups > 1) {
    if (subgroupElect()) {
      achieved_of[gl_SubgroupID] = found.achieved;
      pushed_of[gl_SubgroupID] = found.pushed;
      left_of[gl_SubgroupID] = found.left_m;
      touched_of[gl_SubgroupID] = found.touched;
    }
    barrier();
    if (gl_LocalInvocationID.x == 0)
      for (uint i = 1; i < gl_NumSubgroups; ++i) {
        found.achieved += achieved_of[i];
        found.pushed += pushed_of[i];
        found.left_m = max(found.left_m, left_of[i]);
        found.touched += touched_of[i];
      }
  }
  if (gl_LocalInvocationID.x == 0) decideAll(found);
}
