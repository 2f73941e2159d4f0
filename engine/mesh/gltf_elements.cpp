// SPDX-License-Identifier: MIT
#include "engine/mesh/gltf_elements.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/core/error.h"
#include "engine/core/math.h"

#define TINYGLTF_NO_STB_IMAGE  // there are no textures
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace airclay {
namespace {

template <typename T>
double numberAt(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return double(value);
}

}  // namespace

GltfElements::GltfElements(const tinygltf::Model& model, int accessor, int type, const std::string& where) {
  const auto fail = [&](const char* what) { throw Error(where + ": " + what); };
  if (accessor < 0 || std::size_t(accessor) >= model.accessors.size()) fail("no such accessor");
  const tinygltf::Accessor& source = model.accessors[std::size_t(accessor)];
  if (source.sparse.isSparse) fail("sparse accessors are not supported; export without sparse data");
  if (source.type != type) fail("an accessor of the wrong type");
  if (source.bufferView < 0 || std::size_t(source.bufferView) >= model.bufferViews.size())
    fail("compressed data is not supported; export without compression");
  const tinygltf::BufferView& view = model.bufferViews[std::size_t(source.bufferView)];
  if (view.buffer < 0 || std::size_t(view.buffer) >= model.buffers.size()) fail("no such buffer");
  const std::vector<unsigned char>& data = model.buffers[std::size_t(view.buffer)].data;
  const int components = tinygltf::GetNumComponentsInType(std::uint32_t(type));
  const int component_bytes = tinygltf::GetComponentSizeInBytes(std::uint32_t(source.componentType));
  const int stride = source.ByteStride(view);
  if (component_bytes <= 0 || stride <= 0) fail("an accessor of an unknown layout");
  size_ = source.count;
  component_type_ = source.componentType;
  is_normalized_ = source.normalized;
  component_bytes_ = std::size_t(component_bytes);
  stride_ = std::size_t(stride);
  const bool view_fits = view.byteOffset <= data.size() && view.byteLength <= data.size() - view.byteOffset;
  const std::size_t element_bytes = std::size_t(components) * component_bytes_;
  if (!view_fits || size_ == 0 || source.byteOffset > view.byteLength ||
      element_bytes > view.byteLength - source.byteOffset || stride_ < element_bytes ||
      size_ - 1 > (view.byteLength - source.byteOffset - element_bytes) / stride_)
    fail("the accessor extends beyond its buffer, or is empty");
  first_ = data.data() + view.byteOffset + source.byteOffset;
}

double GltfElements::at(std::size_t i, std::size_t c) const {
  const unsigned char* bytes = first_ + i * stride_ + c * component_bytes_;
  const auto scaled = [this](double value, double largest) {
    return is_normalized_ ? std::max(value / largest, -1.) : value;
  };
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return numberAt<float>(bytes);
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return scaled(numberAt<std::int8_t>(bytes), 127);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return scaled(numberAt<std::uint8_t>(bytes), 255);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return scaled(numberAt<std::int16_t>(bytes), 32767);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return scaled(numberAt<std::uint16_t>(bytes), 65535);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return numberAt<std::uint32_t>(bytes);
    default:
      return std::nan("");
  }
}

Eigen::Affine3d parentFromNode(const tinygltf::Node& node) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (node.matrix.size() == 16) {
    transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());  // column-major
    transform.makeAffine();
    return transform;
  }
  if (node.translation.size() == 3) transform.translate(Eigen::Map<const Vec3>(node.translation.data()));
  if (node.rotation.size() == 4) {
    const std::vector<double>& q = node.rotation;  // x y z w
    transform.rotate(Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized());
  }
  if (node.scale.size() == 3) transform.scale(Eigen::Map<const Vec3>(node.scale.data()));
  return transform;
}

}  // namespace airclay
