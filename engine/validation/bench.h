// SPDX-License-Identifier: MIT
// How long each stage takes, beside its CPU reference and a peer: a plain implementation that one would write
// first.
#pragma once

#include <string>
#include <vector>

#include "engine/gpu/gpu.h"

namespace airclay {

struct StageTiming {
  std::string name, device;
  double gpu_ms = 0, wall_ms = 0;  ///< medians
  double work = 0;                 ///< done in one run, in `work_unit`
  std::string work_unit;           ///< voxels, pixels, data points, …
  double reference_ratio = 0;      ///< the CPU reference's time / ours; 0 where it was not measured
  std::string peer;                ///< who the peer is; empty where there is none
  double peer_ratio = 0;           ///< the peer's time / ours
};

struct BenchOptions {
  int voxels = 128;  ///< along the workspace's edge
};

/// Each stage in the way of the data, and `frame`, the whole: peer and ours alternate in the same run.
std::vector<StageTiming> benchStages(Gpu& gpu, const BenchOptions& options = {});

}  // namespace airclay
