// SPDX-License-Identifier: MIT
#pragma once

#include "engine/math.h"

namespace airclay {

/// How a fit ended.
enum class FitOutcome {
  kIncluded,         ///< no patch is outside the voxel model any more
  kStalled,          ///< the steps became too small to matter
  kOutOfIterations,  ///< still moving at the iteration limit
};

/// Where the hand was found.
struct HandFit {
  Pose world_from_hand = Pose::Identity();
  FitOutcome outcome = FitOutcome::kOutOfIterations;
  int iterations = 0;
  double outside_fraction = 1;    ///< share of the skin's patches that are outside the voxel model
  double uncovered_fraction = 1;  ///< share of the voxel model near the hand that the hand leaves uncovered
};

}  // namespace airclay
