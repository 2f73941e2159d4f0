// SPDX-License-Identifier: MIT
// Writes a mesh as a glTF 2.0 binary. Numbers in brackets refer to the specification,
// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <cmath>
#include <cstring>
#include <sstream>

#include "engine/core/error.h"
#include "engine/mesh/mesh_export.h"

#define TINYGLTF_NO_STB_IMAGE  // there are no textures
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace airclay {
namespace {

/// [3.4] y up, z forward: the world rotated about x by 90 degrees.
Eigen::Vector3f yUp(const Vec3& in_world) {
  return Vec3(in_world.x(), in_world.z(), -in_world.y()).cast<float>();
}

/// Appends data to the buffer, with its own buffer view and accessor.
int addAccessor(tinygltf::Model& model, const void* data, std::size_t bytes, int target,
                tinygltf::Accessor accessor) {
  std::vector<unsigned char>& buffer = model.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = buffer.size();  // aligned, because every component has four bytes
  view.byteLength = bytes;
  view.target = target;
  buffer.resize(buffer.size() + bytes);
  std::memcpy(buffer.data() + view.byteOffset, data, bytes);
  accessor.bufferView = int(model.bufferViews.size());
  model.bufferViews.push_back(view);
  model.accessors.push_back(std::move(accessor));
  return int(model.accessors.size()) - 1;
}

int addVectors(tinygltf::Model& model, const std::vector<Eigen::Vector3f>& vectors, bool with_bounds) {
  tinygltf::Accessor accessor;
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  accessor.type = TINYGLTF_TYPE_VEC3;
  accessor.count = vectors.size();
  if (with_bounds) {  // [3.7.2.1] required for positions
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& vector : vectors) box.extend(vector);
    for (int axis = 0; axis < 3; ++axis) {
      accessor.minValues.push_back(box.min()[axis]);
      accessor.maxValues.push_back(box.max()[axis]);
    }
  }
  static_assert(sizeof(Eigen::Vector3f) == 12);
  return addAccessor(model, vectors.data(), 12 * vectors.size(), TINYGLTF_TARGET_ARRAY_BUFFER,
                     std::move(accessor));
}

int addIndices(tinygltf::Model& model, const std::vector<std::array<int, 3>>& triangles) {
  static_assert(sizeof(std::array<int, 3>) == 12);
  tinygltf::Accessor accessor;
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  accessor.type = TINYGLTF_TYPE_SCALAR;
  accessor.count = 3 * triangles.size();
  return addAccessor(model, triangles.data(), 12 * triangles.size(), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER,
                     std::move(accessor));
}

tinygltf::Material clayMaterial(bool open) {
  tinygltf::Material material;
  material.name = "clay";
  material.pbrMetallicRoughness.baseColorFactor = {linearFromSrgb(kClayColor[0]),
                                                   linearFromSrgb(kClayColor[1]),
                                                   linearFromSrgb(kClayColor[2]), 1};  // [3.9.2]
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.9;  // matt, with a faint highlight
  material.doubleSided = open;
  return material;
}

}  // namespace

std::string gltfBinary(const TriangleMesh& mesh, const std::vector<Vec3>& normals, bool open) {
  std::vector<Eigen::Vector3f> positions, directions;
  for (const Vec3& vertex : mesh.vertices) positions.push_back(yUp(vertex));
  for (const Vec3& normal : normals) directions.push_back(yUp(normal));

  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "Airclay";
  model.buffers.resize(1);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = addVectors(model, positions, true);
  primitive.attributes["NORMAL"] = addVectors(model, directions, false);
  primitive.indices = addIndices(model, mesh.triangles);
  primitive.material = 0;
  model.materials.push_back(clayMaterial(open));
  model.meshes.resize(1);
  model.meshes[0].name = "clay";
  model.meshes[0].primitives.push_back(primitive);
  model.nodes.resize(1);
  model.nodes[0].name = "clay";
  model.nodes[0].mesh = 0;
  model.scenes.resize(1);
  model.scenes[0].nodes = {0};
  model.defaultScene = 0;

  std::ostringstream bytes;
  if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, bytes, false, true))
    throw Error("could not compose the glTF binary");
  return std::move(bytes).str();
}

float linearFromSrgb(int value) {
  const double s = value / 255.0;
  return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

}  // namespace airclay
