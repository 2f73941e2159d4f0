// SPDX-License-Identifier: MIT
#include "engine/gpu/kernel.h"

#include <utility>

#include "engine/core/error.h"

namespace airclay {

RawKernel::RawKernel(Gpu& gpu, const char* name, std::span<const std::uint32_t> spirv,
                     std::vector<std::uint32_t> constants, std::uint32_t args_bytes)
    : gpu_(&gpu), name_(name) {
  const ShaderInterface interface = shaderInterface(spirv);
  if (interface.push_constant_bytes > args_bytes)
    throw Error("the shader " + name_ + " expects more arguments than its C++ struct has", Fault::kDevice);
  pointers_ = interface.pointers;

  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, args_bytes};
  VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  check(vkCreatePipelineLayout(gpu.device(), &layout, nullptr, &layout_), "create a pipeline layout");

  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module_info.codeSize = spirv.size_bytes();
  module_info.pCode = spirv.data();
  VkShaderModule module;
  check(vkCreateShaderModule(gpu.device(), &module_info, nullptr, &module), "load a shader");

  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t i = 0; i < constants.size(); ++i) entries.push_back({i, i * 4, 4});
  const VkSpecializationInfo specialization{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                            constants.size() * 4, constants.data()};
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialization;
  info.layout = layout_;
  const VkResult result =
      vkCreateComputePipelines(gpu.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
  vkDestroyShaderModule(gpu.device(), module, nullptr);
  check(result, "create a compute pipeline");
}

RawKernel::~RawKernel() {
  if (!gpu_) return;
  vkDestroyPipeline(gpu_->device(), pipeline_, nullptr);
  vkDestroyPipelineLayout(gpu_->device(), layout_, nullptr);
}

void RawKernel::swap(RawKernel& other) noexcept {
  std::swap(gpu_, other.gpu_);
  std::swap(name_, other.name_);
  std::swap(layout_, other.layout_);
  std::swap(pipeline_, other.pipeline_);
  std::swap(pointers_, other.pointers_);
}

}  // namespace airclay
