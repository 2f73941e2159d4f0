// SPDX-License-Identifier: MIT
// A compute shader that is dispatched with one struct of arguments.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/gpu/gpu.h"
#include "engine/gpu/shader_interface.h"

namespace airclay {

/// The untyped part of Kernel<Args>.
class RawKernel {
 public:
  RawKernel() = default;
  /// `constants` are the specialization constants 0, 1, …; constant 0 is the workgroup size by convention.
  RawKernel(Gpu& gpu, const char* name, std::span<const std::uint32_t> spirv,
            std::vector<std::uint32_t> constants, std::uint32_t args_bytes);
  RawKernel(RawKernel&& other) noexcept { swap(other); }
  RawKernel& operator=(RawKernel&& other) noexcept {
    swap(other);
    return *this;
  }
  ~RawKernel();

  const std::string& name() const { return name_; }
  VkPipeline pipeline() const { return pipeline_; }
  VkPipelineLayout layout() const { return layout_; }
  const std::vector<PointerArgument>& pointers() const { return pointers_; }

 private:
  void swap(RawKernel& other) noexcept;

  Gpu* gpu_ = nullptr;
  std::string name_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  std::vector<PointerArgument> pointers_;
};

/// `Args` is the struct of the stage's *_io.h that the shader takes as push constants.
template <class Args>
class Kernel : public RawKernel {
  static_assert(sizeof(Args) <= 128, "push constants hold 128 bytes on every device");

 public:
  Kernel() = default;
  Kernel(Gpu& gpu, const char* name, std::span<const std::uint32_t> spirv,
         std::vector<std::uint32_t> constants = {})
      : RawKernel(gpu, name, spirv, std::move(constants), sizeof(Args)) {}
};

}  // namespace airclay
