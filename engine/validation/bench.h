// SPDX-License-Identifier: MIT
// Times each stage, and compares it with its CPU reference and with a peer: a straightforward implementation.
#pragma once

#include <string>
#include <vector>

#include "engine/gpu/gpu.h"

namespace airclay {

struct StageTiming {
  std::string name, device;
  double gpu_ms = 0, wall_ms = 0;  ///< medians
  double work = 0;                 ///< amount processed in one run, in `work_unit`
  std::string work_unit;           ///< voxels, pixels, data points, …
  double reference_ratio = 0;      ///< the CPU reference's time / Airclay's; 0: not measured
  std::string peer;                ///< the peer's name; empty if there is none
  double peer_ratio = 0;           ///< the peer's time / Airclay's
};

struct BenchOptions {
  int voxels = 128;      ///< along the workspace's edge
  double stage_s = 1.2;  ///< for repeated runs of each stage; there are at least three
};

/// Times each stage in processing order, and `frame`, the whole frame. Runs of the peer and of
/// Airclay alternate.
std::vector<StageTiming> benchStages(Gpu& gpu, const BenchOptions& options = {});

}  // namespace airclay
