// SPDX-License-Identifier: MIT
// Compares every kernel with its CPU reference, on the user's device.
#pragma once

#include <string>
#include <vector>

#include "engine/gpu/gpu.h"

namespace airclay {

struct KernelComparison {
  std::string name, device;
  double error = 0, tolerance = 0;  ///< in the same unit, given in `name`
  bool pass = false;
};

/// Runs each kernel and its reference on the same input. \throw Error if a kernel fails to run
std::vector<KernelComparison> compareKernels(Gpu& gpu);

}  // namespace airclay
