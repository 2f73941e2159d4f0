// SPDX-License-Identifier: MIT
// Triangles of glTF 2.0 scenes, in text and binary. Numbers in brackets refer to the specification,
// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "engine/core/task.h"
#include "engine/mesh/gltf_elements.h"
#include "engine/mesh/mesh_source.h"
#include "engine/mesh/point_merger.h"

#define TINYGLTF_NO_STB_IMAGE  // there are no textures
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace airclay {
namespace {

constexpr int kMaxNesting = 100;  // of JSON; tinygltf reads `extras` recursively

bool skipImage(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
               void*) {
  return true;
}

/// File access for tinygltf: the buffers next to a .gltf.
struct BufferFiles {
  std::filesystem::path folder;  ///< empty for a .glb, which contains its buffers

  /// Only files below the folder of the .gltf; tinygltf also searches the working directory.
  static bool exists(const std::string& name, void* self) {
    const std::filesystem::path& folder = static_cast<BufferFiles*>(self)->folder;
    std::error_code status;
    return !folder.empty() && name.starts_with(folder.string()) &&
           std::filesystem::is_regular_file(name, status);
  }
  static std::string expand(const std::string& name, void*) { return name; }
  static bool read(std::vector<unsigned char>* bytes, std::string* error, const std::string& name, void*) {
    try {
      const std::string content = readWhole(name, kMaxMeshFileBytes);
      bytes->assign(content.begin(), content.end());
      return true;
    } catch (const Error& reason) {
      *error += reason.what();
      return false;
    }
  }
  static bool write(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  }

  tinygltf::FsCallbacks callbacks() {
    tinygltf::FsCallbacks callbacks{};
    callbacks.FileExists = exists;
    callbacks.ExpandFilePath = expand;
    callbacks.ReadWholeFile = read;
    callbacks.WriteWholeFile = write;
    callbacks.user_data = this;
    return callbacks;
  }
};

/// The maximum depth of brackets outside strings.
int nestingDepth(std::string_view json) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (in_string) {
      if (json[i] == '\\')
        ++i;
      else if (json[i] == '"')
        in_string = false;
    } else if (json[i] == '"') {
      in_string = true;
    } else if (json[i] == '{' || json[i] == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (json[i] == '}' || json[i] == ']') {
      --depth;
    }
  }
  return deepest;
}

class GltfReader {
 public:
  GltfReader(const MeshFileContent& file, const std::filesystem::path& folder)
      : file_(file), is_binary_(file.bytes.starts_with("glTF")), merger_(mesh_.points) {
    load(folder);
    addScene();
    if (mesh_.faces.empty()) fail("no triangles in its scene");
    mesh_.format = is_binary_ ? "glTF, binary" : "glTF, text";
  }

  MeshSource take() { return std::move(mesh_); }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(file_.name + ": " + what); }

  void load(const std::filesystem::path& folder) {
    tinygltf::TinyGLTF reader;
    BufferFiles neighbours{is_binary_ ? std::filesystem::path() : folder.empty() ? "." : folder};
    reader.SetImageLoader(skipImage, nullptr);
    reader.SetFsCallbacks(neighbours.callbacks());
    std::string error, warning;
    bool is_read = false;
    try {
      if (is_binary_) {
        std::string_view json = file_.bytes.substr(std::min<std::size_t>(20, file_.bytes.size()));
        std::uint32_t json_bytes = 0;
        if (!json.empty()) std::memcpy(&json_bytes, file_.bytes.data() + 12, sizeof json_bytes);
        checkNesting(json.substr(0, json_bytes));
        is_read = reader.LoadBinaryFromMemory(&model_, &error, &warning,
                                              reinterpret_cast<const unsigned char*>(file_.bytes.data()),
                                              unsigned(file_.bytes.size()));
      } else {
        checkNesting(file_.bytes);
        const std::string json = withoutImages();
        is_read = reader.LoadASCIIFromString(&model_, &error, &warning, json.data(), unsigned(json.size()),
                                             neighbours.folder.string());
      }
    } catch (const Error&) {
      throw;
    } catch (const std::exception& reason) {
      error = reason.what();
    }
    if (is_read) return;
    for (char& c : error)
      if (c < ' ' || c > '~') c = c == '\n' ? ' ' : '?';  // the message quotes the file
    while (!error.empty() && error.back() == ' ') error.pop_back();
    fail("damaged glTF: " + (error.empty() ? "unreadable" : error.substr(0, 200)));
  }

  void checkNesting(std::string_view json) const {
    if (nestingDepth(json) > kMaxNesting)
      fail("damaged glTF: its JSON is nested more than " + std::to_string(kMaxNesting) + " levels deep");
  }

  /// The JSON without images, which tinygltf would load.
  std::string withoutImages() const {
    using nlohmann::json;
    json root = json::parse(file_.bytes.begin(), file_.bytes.end());  // throws with line and column
    if (!root.is_object()) fail("damaged glTF: its JSON is not an object");
    if (root.erase("images") == 0) return std::string(file_.bytes);
    return root.dump(-1, ' ', false, json::error_handler_t::replace);
  }

  // --- the scene [3.5] ---

  void addScene() {
    const std::vector<tinygltf::Node>& nodes = model_.nodes;
    const std::vector<tinygltf::Scene>& scenes = model_.scenes;
    if (scenes.empty()) {
      addAllNodes();
    } else {
      const std::size_t chosen = model_.defaultScene < 0 ? 0 : std::size_t(model_.defaultScene);
      if (chosen >= scenes.size()) fail("its default scene does not exist");
      std::vector<bool> is_visited(nodes.size(), false);
      std::vector<std::pair<int, Eigen::Affine3d>> open;
      for (const int node : scenes[chosen].nodes) open.emplace_back(node, Eigen::Affine3d::Identity());
      while (!open.empty()) {
        const auto [index, scene_from_parent] = open.back();
        open.pop_back();
        if (index < 0 || std::size_t(index) >= nodes.size())
          fail("node " + std::to_string(index) + " does not exist");
        if (is_visited[std::size_t(index)]) fail("node " + std::to_string(index) + " has two parents");
        is_visited[std::size_t(index)] = true;
        const tinygltf::Node& node = nodes[std::size_t(index)];
        const Eigen::Affine3d scene_from_node = scene_from_parent * parentFromNode(node);
        // The node of a skinned mesh does not move it [3.7.3.3].
        if (node.mesh >= 0)
          addMesh(node.mesh, node.skin >= 0 ? Eigen::Affine3d::Identity() : scene_from_node);
        for (const int child : node.children) open.emplace_back(child, scene_from_node);
      }
    }
  }

  /// Without a scene: each mesh untransformed.
  void addAllNodes() {
    for (std::size_t m = 0; m < model_.meshes.size(); ++m) addMesh(int(m), Eigen::Affine3d::Identity());
  }

  // --- meshes [3.7] ---

  void addMesh(int index, const Eigen::Affine3d& scene_from_mesh) {
    if (std::size_t(index) >= model_.meshes.size()) fail("mesh " + std::to_string(index) + " does not exist");
    for (const tinygltf::Primitive& primitive : model_.meshes[std::size_t(index)].primitives)
      addPrimitive(primitive, scene_from_mesh);
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const Eigen::Affine3d& scene_from_mesh) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    const auto positions = primitive.attributes.find("POSITION");
    if (positions == primitive.attributes.end()) return;  // nothing to draw
    std::vector<int> corners = readPoints(positions->second, scene_from_mesh);
    if (primitive.indices >= 0) corners = readIndices(primitive.indices, corners);
    if (mode < TINYGLTF_MODE_TRIANGLES) {  // points and lines; their points are loose
      if (mode != TINYGLTF_MODE_POINTS)
        mesh_.loose_edges += mode == TINYGLTF_MODE_LINE ? corners.size() / 2 : corners.size() - 1;
      return;
    }
    const bool mirrored = scene_from_mesh.linear().determinant() < 0;  // then clockwise [3.7.4]
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      if (mirrored) std::swap(b, c);
      addTriangle({corners[a], corners[b], corners[c]});
    };
    if (mode == TINYGLTF_MODE_TRIANGLES) {
      if (corners.size() % 3 != 0)
        fail("a primitive of triangles has " + std::to_string(corners.size()) + " corners");
      for (std::size_t i = 0; i + 2 < corners.size(); i += 3) add(i, i + 1, i + 2);
    } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        const int a = corners[i], b = corners[i + 1], c = corners[i + 2];
        if (a != b && b != c && c != a)
          add(i, i + 1 + i % 2, i + 2 - i % 2);  // degenerate ones connect two strips
      }
    } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      for (std::size_t i = 1; i + 1 < corners.size(); ++i) add(i, i + 1, 0);
    } else {
      fail("a primitive has the unknown mode " + std::to_string(mode));
    }
  }

  void addTriangle(const std::array<int, 3>& corners) {
    corner_count_ += 3;
    if (corner_count_ > kMaxMeshCorners)
      fail("more than " + std::to_string(kMaxMeshCorners) + " face corners");
    reportProgress(corner_count_, kMaxMeshCorners);
    mesh_.faces.emplace_back(corners.begin(), corners.end());
  }

  /// The mesh's index of each vertex.
  std::vector<int> readPoints(int accessor, const Eigen::Affine3d& scene_from_mesh) {
    const GltfElements positions(model_, accessor, TINYGLTF_TYPE_VEC3, file_.name + ": POSITION");
    vertex_count_ += positions.size();  // once per primitive that uses the accessor
    if (vertex_count_ > kMaxMeshCorners)
      fail("its primitives have more than " + std::to_string(kMaxMeshCorners) + " vertices");
    std::vector<int> vertices;
    vertices.reserve(positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const Vec3 in_mesh(positions.at(v, 0), positions.at(v, 1), positions.at(v, 2));
      const Vec3 point = scene_from_mesh * in_mesh;
      if (!point.allFinite())
        fail("POSITION of accessor " + std::to_string(accessor) + ": vertex " + std::to_string(v) +
             " is not finite");
      vertices.push_back(merger_.add(point));
      if (mesh_.points.size() > kMaxMeshPoints)
        fail("more than " + std::to_string(kMaxMeshPoints) + " vertices");
    }
    return vertices;
  }

  std::vector<int> readIndices(int accessor, const std::vector<int>& vertices) const {
    const GltfElements indices(model_, accessor, TINYGLTF_TYPE_SCALAR, file_.name + ": indices");
    if (indices.size() > kMaxMeshCorners)
      fail("more than " + std::to_string(kMaxMeshCorners) + " face corners");
    std::vector<int> corners;
    corners.reserve(indices.size());
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const double index = indices.at(i);
      if (!(index >= 0 && index < double(vertices.size())))
        fail("index " + exactNumber(index) + " at position " + std::to_string(i) + " of accessor " +
             std::to_string(accessor) + " is out of range; the primitive has " +
             std::to_string(vertices.size()) + " vertices");
      corners.push_back(vertices[std::size_t(index)]);
    }
    return corners;
  }

  const MeshFileContent& file_;
  const bool is_binary_;
  tinygltf::Model model_;
  MeshSource mesh_;
  PointMerger merger_;
  std::size_t corner_count_ = 0, vertex_count_ = 0;
};

}  // namespace

MeshSource parseGltf(const MeshFileContent& file, const std::filesystem::path& folder) {
  return GltfReader(file, folder).take();
}

}  // namespace airclay
