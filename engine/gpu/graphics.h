// SPDX-License-Identifier: MIT
// Drawing: graphics pipelines that take one struct of arguments, like kernels, and render passes that draw
// with them.
//
//     struct LineArgs { ReadVec3s points; mat4 clip_from_world; … };  // line_io.h, at most 128 bytes
//     GraphicsPipeline<LineArgs> lines(gpu, "lines", {line_vert, line_frag}, {.blend = Blend::kAlpha});
//     Canvas canvas(gpu, 640, 480);
//     render(recorder, canvas.pass(vec4(0, 0, 0, 1)), {draw(lines, args, 2 * count)});
//     copyToBuffer(recorder, canvas.resolved, image.raw());
//
// There are no vertex inputs and no textures: shaders read everything through the arguments' device pointers,
// by gl_VertexIndex or by pixel, and the recorder derives the barriers from these as for kernels.
#pragma once

#include <optional>

#include "engine/gpu/image.h"
#include "engine/gpu/shader_pipeline.h"

namespace airclay {

enum class Blend {
  kOpaque,
  kAlpha,      ///< colour * alpha + destination * (1 - alpha)
  kDepthOnly,  ///< the colour does not change
};

/// The fixed state of a graphics pipeline.
struct GraphicsOptions {
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  /// Front faces are counterclockwise in the image, like our meshes seen from outside.
  VkCullModeFlags cull = VK_CULL_MODE_NONE;
  bool depth_test = true;   ///< nearer or equal passes
  bool depth_write = true;  ///< only with depth_test
  Blend blend = Blend::kOpaque;
  bool has_color = true, has_depth = true;  ///< the attachments of the pass; a shadow map has no colour
  ImageKind color_kind = ImageKind::kColor;
  std::uint32_t samples = kSamples;
  /// Depth bias: constant (in units of the depth resolution) and by slope. For shadow maps.
  float depth_bias = 0, depth_bias_slope = 0;
  std::vector<std::uint32_t> constants;  ///< specialization constants 0, 1, … of both shaders
};

/// SPIR-V. A pass without colour needs no fragment shader.
struct GraphicsShaders {
  std::span<const std::uint32_t> vertex, fragment;
};

/// The untyped part of GraphicsPipeline<Args>.
class RawGraphicsPipeline : public ShaderPipeline {
 public:
  RawGraphicsPipeline() = default;
  /// \throw Error if a shader writes through an argument: draws only read.
  RawGraphicsPipeline(Gpu& gpu, const char* name, const GraphicsShaders& shaders,
                      const GraphicsOptions& options, std::uint32_t args_bytes);
};

/// `Args` is the struct of an *_io.h that both shaders take as push constants.
template <class Args>
class GraphicsPipeline : public RawGraphicsPipeline {
  static_assert(sizeof(Args) <= 128, "push constants hold 128 bytes on every device");

 public:
  GraphicsPipeline() = default;
  GraphicsPipeline(Gpu& gpu, const char* name, const GraphicsShaders& shaders,
                   const GraphicsOptions& options = {})
      : RawGraphicsPipeline(gpu, name, shaders, options, sizeof(Args)) {}
};

/// One draw call with its arguments.
struct Draw {
  const RawGraphicsPipeline* pipeline = nullptr;  ///< must outlive the recording of the pass
  std::vector<unsigned char> args;
  std::uint32_t vertices = 0, instances = 1;
  std::uint32_t first = 0;  ///< of the indices
  /// Optional: four uints on the device (vertices, instances, 0, 0) that replace the two above.
  const RawBuffer* counts = nullptr;
  /// Optional: index values for gl_VertexIndex, so that a corner shared by triangles is processed once.
  const RawBuffer* indices = nullptr;
};

template <class Args>
Draw draw(const GraphicsPipeline<Args>& pipeline, const Args& args, std::uint32_t vertices,
          std::uint32_t instances = 1) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(&args);
  return {&pipeline, {bytes, bytes + sizeof(Args)}, vertices, instances};
}

/// The same, with counts computed by a kernel.
template <class Args>
Draw drawCounted(const GraphicsPipeline<Args>& pipeline, const Args& args, const RawBuffer& counts) {
  Draw counted = draw(pipeline, args, 0);
  counted.counts = &counts;
  return counted;
}

/// The same, with all of the given indices.
template <class Args>
Draw drawIndexed(const GraphicsPipeline<Args>& pipeline, const Args& args,
                 const Buffer<std::uint32_t>& indices) {
  Draw indexed = draw(pipeline, args, static_cast<std::uint32_t>(indices.count()));
  indexed.indices = &indices.raw();
  return indexed;
}

/// The attachments of a pass, all of one size. An attachment without a clear value keeps its content.
struct RenderPass {
  Image* color = nullptr;
  Image* resolve = nullptr;  ///< receives the average of colour's samples
  Image* depth = nullptr;
  std::optional<vec4> clear_color;  ///< linear light
  std::optional<float> clear_depth;
};

/// Records the draws in order. The barriers for their arguments precede the whole pass.
void render(Recorder& recorder, const RenderPass& pass, const std::vector<Draw>& draws);

/// The attachments for one image: colour and depth with kSamples samples, and the resolved colour.
struct Canvas {
  Image color, depth, resolved;

  Canvas() = default;
  Canvas(Gpu& gpu, std::uint32_t width, std::uint32_t height);
  /// A pass that clears the image first.
  RenderPass pass(const vec4& clear_color) { return {&color, &resolved, &depth, clear_color, 1.0f}; }
};

}  // namespace airclay
