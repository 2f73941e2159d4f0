// SPDX-License-Identifier: MIT
#include "engine/gpu/graphics.h"

#include <algorithm>
#include <utility>

#include "engine/core/error.h"
#include "engine/gpu/shader_stage.h"

namespace airclay {
namespace {

constexpr VkShaderStageFlags kStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

VkPipelineRasterizationStateCreateInfo rasterization(const GraphicsOptions& options) {
  VkPipelineRasterizationStateCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  info.polygonMode = VK_POLYGON_MODE_FILL;
  info.cullMode = options.cull;
  info.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  info.depthBiasEnable = options.depth_bias != 0 || options.depth_bias_slope != 0;
  info.depthBiasConstantFactor = options.depth_bias;
  info.depthBiasSlopeFactor = options.depth_bias_slope;
  info.lineWidth = 1;
  return info;
}

VkPipelineDepthStencilStateCreateInfo depthState(const GraphicsOptions& options) {
  VkPipelineDepthStencilStateCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  info.depthTestEnable = options.depth_test;
  info.depthWriteEnable = options.depth_write;
  info.depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL;
  return info;
}

VkPipelineColorBlendAttachmentState blendState(Blend blend) {
  VkPipelineColorBlendAttachmentState state{};
  if (blend == Blend::kDepthOnly) return state;
  state.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                         VK_COLOR_COMPONENT_A_BIT;
  state.blendEnable = blend == Blend::kAlpha;
  state.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
  state.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  state.colorBlendOp = VK_BLEND_OP_ADD;
  // so that opaque pixels stay opaque
  state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  state.alphaBlendOp = VK_BLEND_OP_ADD;
  return state;
}

VkRenderingAttachmentInfo attachment(VkCommandBuffer commands, Image& image, VkImageLayout layout,
                                     bool clears) {
  image.transition(commands, layout, !clears);
  VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  info.imageView = image.view();
  info.imageLayout = layout;
  info.loadOp = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  return info;
}

void beginRendering(VkCommandBuffer commands, const RenderPass& pass, VkExtent2D extent) {
  VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
  info.renderArea.extent = extent;
  info.layerCount = 1;
  VkRenderingAttachmentInfo color, depth;
  if (pass.color) {
    color = attachment(commands, *pass.color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                       pass.clear_color.has_value());
    if (pass.clear_color) std::copy_n(pass.clear_color->data(), 4, color.clearValue.color.float32);
    if (pass.resolve) {
      pass.resolve->transition(commands, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, false);
      color.resolveMode = VK_RESOLVE_MODE_AVERAGE_BIT;
      color.resolveImageView = pass.resolve->view();
      color.resolveImageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    }
    info.colorAttachmentCount = 1;
    info.pColorAttachments = &color;
  }
  if (pass.depth) {
    depth = attachment(commands, *pass.depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                       pass.clear_depth.has_value());
    if (pass.clear_depth) depth.clearValue.depthStencil.depth = *pass.clear_depth;
    info.pDepthAttachment = &depth;
  }
  vkCmdBeginRendering(commands, &info);
}

}  // namespace

RawGraphicsPipeline::RawGraphicsPipeline(Gpu& gpu, const char* name, const GraphicsShaders& shaders,
                                         const GraphicsOptions& options, std::uint32_t args_bytes)
    : ShaderPipeline(gpu, name) {
  addPointersOf(shaders.vertex, args_bytes);
  if (!shaders.fragment.empty()) addPointersOf(shaders.fragment, args_bytes);
  if (std::any_of(pointers().begin(), pointers().end(), [](const PointerArgument& p) { return p.writes; }))
    throw Error(
        "a shader of " + this->name() + " writes through an argument; draws only read (Read… pointers)",
        Fault::kDevice);
  createLayout(kStages, args_bytes);
  const ShaderStage vertex(gpu, VK_SHADER_STAGE_VERTEX_BIT, shaders.vertex, options.constants),
      fragment(gpu, VK_SHADER_STAGE_FRAGMENT_BIT, shaders.fragment, options.constants);
  const VkPipelineShaderStageCreateInfo stages[] = {vertex.info(), fragment.info()};

  const VkPipelineVertexInputStateCreateInfo no_input{
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = options.topology;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = viewport.scissorCount = 1;
  const VkPipelineRasterizationStateCreateInfo raster = rasterization(options);
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  multisample.rasterizationSamples = static_cast<VkSampleCountFlagBits>(options.samples);
  const VkPipelineDepthStencilStateCreateInfo depth = depthState(options);
  const VkPipelineColorBlendAttachmentState blend_state = blendState(options.blend);
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = options.has_color;
  blend.pAttachments = &blend_state;
  const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = 2;
  dynamic.pDynamicStates = dynamic_states;
  const VkFormat color_format = formatOf(options.color_kind);
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.colorAttachmentCount = options.has_color;
  rendering.pColorAttachmentFormats = &color_format;
  if (options.has_depth) rendering.depthAttachmentFormat = formatOf(ImageKind::kDepth);

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.pNext = &rendering;
  info.stageCount = shaders.fragment.empty() ? 1 : 2;
  info.pStages = stages;
  info.pVertexInputState = &no_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &multisample;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = layout();
  check(vkCreateGraphicsPipelines(gpu.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_),
        "create a graphics pipeline");
}

void render(Recorder& recorder, const RenderPass& pass, const std::vector<Draw>& draws) {
  const Image* sized = pass.color ? pass.color : pass.depth;
  if (!sized) throw Error("a render pass has no attachment", Fault::kDevice);
  std::vector<Access> accesses;
  for (const Draw& d : draws) {
    const std::vector<Access> of_draw = recorder.accessesOf(d.pipeline->pointers(), d.args.data());
    accesses.insert(accesses.end(), of_draw.begin(), of_draw.end());
    for (const RawBuffer* read : {d.counts, d.indices})
      if (read) accesses.push_back({read->address(), true, false});
  }
  const std::string name = draws.empty() ? "clear" : draws.front().pipeline->name();
  VkCommandBuffer commands = recorder.commandsFor(name, accesses);

  const VkExtent2D extent{sized->width(), sized->height()};
  beginRendering(commands, pass, extent);
  const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
  const VkRect2D scissor{{0, 0}, extent};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
  for (const Draw& d : draws) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, d.pipeline->pipeline());
    vkCmdPushConstants(commands, d.pipeline->layout(), kStages, 0, static_cast<std::uint32_t>(d.args.size()),
                       d.args.data());
    if (d.indices) {
      vkCmdBindIndexBuffer(commands, d.indices->handle(), d.indices->offset(), VK_INDEX_TYPE_UINT32);
      vkCmdDrawIndexed(commands, d.vertices, d.instances, d.first, 0, 0);
    } else if (d.counts) {
      vkCmdDrawIndirect(commands, d.counts->handle(), d.counts->offset(), 1, 0);
    } else {
      vkCmdDraw(commands, d.vertices, d.instances, 0, 0);
    }
  }
  vkCmdEndRendering(commands);
}

Canvas::Canvas(Gpu& gpu, std::uint32_t width, std::uint32_t height)
    : color(gpu, ImageKind::kColor, width, height, kSamples),
      depth(gpu, ImageKind::kDepth, width, height, kSamples),
      resolved(gpu, ImageKind::kColor, width, height) {}

}  // namespace airclay
