// SPDX-License-Identifier: MIT
// Every kernel against its CPU reference, on the user's own device.
#pragma once

#include <string>
#include <vector>

#include "engine/gpu/gpu.h"

namespace airclay {

struct KernelComparison {
  std::string name, device;
  double error = 0, tolerance = 0;  ///< in the same unit, which the kernel's test explains
  bool pass = false;
};

/// Runs each kernel and its reference on the same input. A kernel that fails to run is an Error.
std::vector<KernelComparison> compareKernels(Gpu& gpu);

}  // namespace airclay
