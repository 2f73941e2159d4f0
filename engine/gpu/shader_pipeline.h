// SPDX-License-Identifier: MIT
// The part that kernels and graphics pipelines share: a Vulkan pipeline whose shaders take one struct of
// arguments as push constants.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/gpu/gpu.h"
#include "engine/gpu/shader_interface.h"

namespace airclay {

class ShaderPipeline {
 public:
  const std::string& name() const { return name_; }
  VkPipeline pipeline() const { return pipeline_; }
  VkPipelineLayout layout() const { return layout_; }
  /// The pointers of all shaders, each once.
  const std::vector<PointerArgument>& pointers() const { return pointers_; }

 protected:
  ShaderPipeline() = default;
  ShaderPipeline(Gpu& gpu, const char* name) : gpu_(&gpu), name_(name) {}
  ShaderPipeline(ShaderPipeline&& other) noexcept { swap(other); }
  ShaderPipeline& operator=(ShaderPipeline&& other) noexcept {
    swap(other);
    return *this;
  }
  ~ShaderPipeline();

  /// Adds a shader's pointers. \throw Error if the shader expects more than `args_bytes` of arguments
  void addPointersOf(std::span<const std::uint32_t> spirv, std::uint32_t args_bytes);
  void createLayout(VkShaderStageFlags stages, std::uint32_t args_bytes);

  Gpu* gpu_ = nullptr;
  VkPipeline pipeline_ = VK_NULL_HANDLE;

 private:
  void swap(ShaderPipeline& other) noexcept;

  std::string name_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  std::vector<PointerArgument> pointers_;
};

}  // namespace airclay
