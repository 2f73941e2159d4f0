#version 460
// SPDX-License-Identifier: MIT
// Selects the hypothesis whose patches stick out least; the first one on a tie.
#extension GL_GOOGLE_include_directive : require
#include "shaders/hand/fit_io.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { FitChooseArgs args; };

void main() {
  uint best = 0;
  for (uint i = 1; i < args.count; ++i)
    if (args.fits.at[i].outside_m < args.fits.at[best].outside_m) best = i;
  GpuFit fit = args.fits.at[best];
  const bool somebody = args.hull.at[0].occupied >= args.min_occupied;
  fit.pose.tracked = somebody && fit.outside_m <= args.lost_outside_m ? 1 : 0;
  args.result.at[0] = fit;
  args.hand.at[0] = fit.pose;
}
