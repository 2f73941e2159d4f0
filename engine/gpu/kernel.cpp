// SPDX-License-Identifier: MIT
#include "engine/gpu/kernel.h"

#include "engine/gpu/shader_stage.h"

namespace airclay {

RawKernel::RawKernel(Gpu& gpu, const char* name, std::span<const std::uint32_t> spirv,
                     const std::vector<std::uint32_t>& constants, std::uint32_t args_bytes)
    : ShaderPipeline(gpu, name) {
  addPointersOf(spirv, args_bytes);
  createLayout(VK_SHADER_STAGE_COMPUTE_BIT, args_bytes);
  const ShaderStage stage(gpu, VK_SHADER_STAGE_COMPUTE_BIT, spirv, constants);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = stage.info();
  info.layout = layout();
  check(vkCreateComputePipelines(gpu.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_),
        "create a compute pipeline");
}

}  // namespace airclay
