// SPDX-License-Identifier: MIT
#include "engine/gpu/shader_pipeline.h"

#include <algorithm>
#include <utility>

#include "engine/core/error.h"

namespace airclay {

ShaderPipeline::~ShaderPipeline() {
  if (!gpu_) return;
  vkDestroyPipeline(gpu_->device(), pipeline_, nullptr);
  vkDestroyPipelineLayout(gpu_->device(), layout_, nullptr);
}

void ShaderPipeline::addPointersOf(std::span<const std::uint32_t> spirv, std::uint32_t args_bytes) {
  const ShaderInterface interface = shaderInterface(spirv);
  if (interface.push_constant_bytes > args_bytes)
    throw Error("a shader of " + name_ + " expects more arguments than its C++ struct has", Fault::kDevice);
  for (const PointerArgument& pointer : interface.pointers) {
    const auto known = std::find_if(pointers_.begin(), pointers_.end(),
                                    [&](const PointerArgument& p) { return p.offset == pointer.offset; });
    if (known == pointers_.end()) {
      pointers_.push_back(pointer);
    } else {
      known->reads |= pointer.reads;
      known->writes |= pointer.writes;
    }
  }
}

void ShaderPipeline::createLayout(VkShaderStageFlags stages, std::uint32_t args_bytes) {
  const VkPushConstantRange range{stages, 0, args_bytes};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &range;
  check(vkCreatePipelineLayout(gpu_->device(), &info, nullptr, &layout_), "create a pipeline layout");
}

void ShaderPipeline::swap(ShaderPipeline& other) noexcept {
  std::swap(gpu_, other.gpu_);
  std::swap(name_, other.name_);
  std::swap(layout_, other.layout_);
  std::swap(pipeline_, other.pipeline_);
  std::swap(pointers_, other.pointers_);
}

}  // namespace airclay
