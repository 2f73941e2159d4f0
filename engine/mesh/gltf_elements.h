// SPDX-License-Identifier: MIT
// Checked access to a glTF model's accessors, and the transforms of its nodes. Numbers in brackets refer to
// the glTF 2.0 specification.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>

namespace tinygltf {
struct Accessor;
class Model;
class Node;
}  // namespace tinygltf

namespace airclay {

/// An accessor's elements as numbers; the constructor checks all ranges [3.6.2]. The model must outlive it.
class GltfElements {
 public:
  /// `type` is a TINYGLTF_TYPE. \throw Error whose message begins with `where`
  GltfElements(const tinygltf::Model& model, int accessor, int type, const std::string& where);

  std::size_t size() const { return size_; }
  int componentType() const { return component_type_; }

  /// Component `c` of element `i`; integers may be normalized [3.6.2.2].
  double at(std::size_t i, std::size_t c = 0) const;

 private:
  std::size_t size_ = 0;
  int component_type_ = 0;
  bool is_normalized_ = false;
  const unsigned char* first_ = nullptr;
  std::size_t component_bytes_ = 0, stride_ = 0;
};

/// A node's transform relative to its parent, from its matrix or from translation, rotation and scale
/// [3.5.3].
Eigen::Affine3d parentFromNode(const tinygltf::Node& node);

}  // namespace airclay
