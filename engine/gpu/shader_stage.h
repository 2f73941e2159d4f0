// SPDX-License-Identifier: MIT
// A shader with its specialization constants, while a pipeline is created from it.
#pragma once

#include <span>
#include <vector>

#include "engine/gpu/gpu.h"

namespace airclay {

class ShaderStage {
 public:
  /// `constants` are the specialization constants 0, 1, …. Without SPIR-V there is no module, and info() must
  /// not be used.
  ShaderStage(Gpu& gpu, VkShaderStageFlagBits stage, std::span<const std::uint32_t> spirv,
              const std::vector<std::uint32_t>& constants)
      : device_(gpu.device()), stage_(stage), constants_(constants) {
    for (std::uint32_t i = 0; i < constants_.size(); ++i) entries_.push_back({i, i * 4, 4});
    specialization_ = {static_cast<std::uint32_t>(entries_.size()), entries_.data(), constants_.size() * 4,
                       constants_.data()};
    if (spirv.empty()) return;
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = spirv.size_bytes();
    info.pCode = spirv.data();
    check(vkCreateShaderModule(device_, &info, nullptr, &module_), "load a shader");
  }
  ~ShaderStage() { vkDestroyShaderModule(device_, module_, nullptr); }
  ShaderStage(const ShaderStage&) = delete;
  ShaderStage& operator=(const ShaderStage&) = delete;

  /// Valid while this object exists.
  VkPipelineShaderStageCreateInfo info() const {
    VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = stage_;
    info.module = module_;
    info.pName = "main";
    info.pSpecializationInfo = &specialization_;
    return info;
  }

 private:
  VkDevice device_;
  VkShaderStageFlagBits stage_;
  VkShaderModule module_ = VK_NULL_HANDLE;
  std::vector<std::uint32_t> constants_;
  std::vector<VkSpecializationMapEntry> entries_;
  VkSpecializationInfo specialization_{};
};

}  // namespace airclay
