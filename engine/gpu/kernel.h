// SPDX-License-Identifier: MIT
// A compute shader that is dispatched with one struct of arguments.
#pragma once

#include "engine/gpu/shader_pipeline.h"

namespace airclay {

/// The untyped part of Kernel<Args>.
class RawKernel : public ShaderPipeline {
 public:
  RawKernel() = default;
  /// `constants` are the specialization constants 0, 1, …; constant 0 is the workgroup size by convention.
  RawKernel(Gpu& gpu, const char* name, std::span<const std::uint32_t> spirv,
            const std::vector<std::uint32_t>& constants, std::uint32_t args_bytes);
};

/// `Args` is the struct of the stage's *_io.h that the shader takes as push constants.
template <class Args>
class Kernel : public RawKernel {
  static_assert(sizeof(Args) <= 128, "push constants hold 128 bytes on every device");

 public:
  Kernel() = default;
  Kernel(Gpu& gpu, const char* name, std::span<const std::uint32_t> spirv,
         const std::vector<std::uint32_t>& constants = {})
      : RawKernel(gpu, name, spirv, constants, sizeof(Args)) {}
};

}  // namespace airclay
