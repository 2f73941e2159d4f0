// SPDX-License-Identifier: MIT
// Reads a skinned glTF binary with WebXR joint names as a hand model.
// Numbers in brackets refer to the glTF 2.0 specification,
// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>

#include "engine/core/error.h"
#include "engine/hand/hand_model.h"
#include "engine/mesh/gltf_elements.h"

#define TINYGLTF_NO_STB_IMAGE  // textures are ignored
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace airclay {
namespace {

constexpr std::uintmax_t kMaxFileBytes =
    64u << 20;  // a rigged hand of 100,000 triangles has 5 MB without its images
constexpr size_t kMaxTriangles = 1'000'000;
constexpr double kMaxCoordinate = 1e6;  // more indicates a damaged file; also keeps products finite
constexpr double kMinVolume = 1e-18;    // m³: a cube of a micrometre; less counts as flat

/// A parsed file and its path for error messages.
struct File {
  std::filesystem::path path;
  tinygltf::Model model;

  [[noreturn]] void fail(const std::string& what) const {
    throw Error("hand " + path.string() + ": " + what);
  }
};

bool skipImage(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
               void*) {
  return true;
}

/// File callbacks that open no files: a glTF binary contains its buffers.
tinygltf::FsCallbacks noFiles() {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string&, void*) { return false; };
  callbacks.ExpandFilePath = [](const std::string& name, void*) { return name; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>*, std::string* error, const std::string& name,
                               void*) {
    *error += "the buffer " + name + " is outside the file; export a single glTF binary";
    return false;
  };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  return callbacks;
}

std::vector<unsigned char> readBytes(const File& file) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(file.path, status))
    file.fail("no such file; expected right, left or a .glb file");
  const std::uintmax_t size = std::filesystem::file_size(file.path, status);
  if (status) file.fail("cannot be read: " + status.message());
  if (size > kMaxFileBytes)
    file.fail("the file has " + std::to_string(size >> 20) + " MB; expected at most " +
              std::to_string(kMaxFileBytes >> 20));
  std::vector<unsigned char> bytes(size);
  std::ifstream stream(file.path, std::ios::binary);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size))) file.fail("cannot be read");
  if (size < 20 || std::memcmp(bytes.data(), "glTF", 4) != 0)
    file.fail("not a glTF binary (it does not start with glTF); export the hand as .glb");
  return bytes;
}

void parse(File& file) {
  const std::vector<unsigned char> bytes = readBytes(file);
  tinygltf::TinyGLTF reader;
  reader.SetImageLoader(skipImage, nullptr);
  reader.SetFsCallbacks(noFiles());
  std::string error, warning;
  bool read = false;
  try {
    read = reader.LoadBinaryFromMemory(&file.model, &error, &warning, bytes.data(), unsigned(bytes.size()));
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (read) return;
  std::replace(error.begin(), error.end(), '\n', ' ');
  while (!error.empty() && error.back() == ' ') error.pop_back();
  file.fail("damaged glTF binary: " + (error.empty() ? "unreadable" : error));
}

/// Elements of an accessor of the file.
GltfElements elementsOf(const File& file, int accessor, int type, const std::string& what) {
  return GltfElements(file.model, accessor, type, "hand " + file.path.string() + ": " + what);
}

std::vector<int> nodeParents(const File& file) {
  const std::vector<tinygltf::Node>& nodes = file.model.nodes;
  std::vector<int> parents(nodes.size(), -1);
  for (size_t n = 0; n < nodes.size(); ++n) {
    for (const int child : nodes[n].children) {
      if (child < 0 || size_t(child) >= nodes.size())
        file.fail("node " + std::to_string(n) + ": no such child");
      if (parents[child] >= 0) file.fail("node " + std::to_string(child) + ": two parents");
      parents[child] = int(n);
    }
  }
  return parents;
}

/// A node's global transform [3.5.2].
Eigen::Affine3d sceneFromNode(const File& file, const std::vector<int>& parents, int node) {
  Eigen::Affine3d scene_from_node = Eigen::Affine3d::Identity();
  size_t steps = 0;
  for (int n = node; n >= 0; n = parents[n]) {
    if (++steps > parents.size()) file.fail("node " + std::to_string(node) + ": it is its own ancestor");
    scene_from_node = parentFromNode(file.model.nodes[n]) * scene_from_node;
  }
  if (!scene_from_node.matrix().allFinite() ||
      scene_from_node.matrix().cwiseAbs().maxCoeff() > kMaxCoordinate)
    file.fail("node " + std::to_string(node) + ": a transform that is not finite");
  return scene_from_node;
}

/// The skin's joints: the joint of kJointNames that each one follows, and its transform of vertices.
struct FileSkin {
  int index = -1;
  std::vector<int> hand_joints;                   // in the skin's order
  std::vector<Eigen::Affine3d> scene_from_bound;  // joint_world * inverse_bind
  std::array<int, 25> nodes{};                    // in the order of kJointNames
};

int jointByName(const std::string& name) {
  const auto found = std::find(kJointNames.begin(), kJointNames.end(), name);
  return found == kJointNames.end() ? -1 : int(found - kJointNames.begin());
}

/// The first skin that has the wrist, otherwise the first skin; its joints must include all 25 names.
FileSkin findSkin(const File& file, const std::vector<int>& parents) {
  const tinygltf::Model& model = file.model;
  if (model.skins.empty()) file.fail("no skin; export the hand with its armature");
  for (const tinygltf::Skin& skin : model.skins)
    for (const int node : skin.joints)
      if (node < 0 || size_t(node) >= model.nodes.size()) file.fail("a skin's joint is not a node");
  const auto has_wrist = [&](const tinygltf::Skin& skin) {
    return std::any_of(skin.joints.begin(), skin.joints.end(),
                       [&](int node) { return model.nodes[node].name == kJointNames[0]; });
  };
  const auto chosen = std::find_if(model.skins.begin(), model.skins.end(), has_wrist);
  const tinygltf::Skin& skin = chosen == model.skins.end() ? model.skins.front() : *chosen;

  FileSkin result;
  result.index = int(&skin - model.skins.data());
  result.nodes.fill(-1);
  for (const int node : skin.joints) {
    const int joint = jointByName(model.nodes[node].name);
    if (joint < 0) continue;
    if (result.nodes[joint] >= 0) file.fail("two joints are named " + model.nodes[node].name);
    result.nodes[joint] = node;
  }
  for (size_t j = 0; j < kJointNames.size(); ++j)
    if (result.nodes[j] < 0) file.fail("the skin lacks the joint " + std::string(kJointNames[j]));

  const bool bound = skin.inverseBindMatrices >= 0;
  std::vector<GltfElements> inverse_bind;
  if (bound)
    inverse_bind.push_back(
        elementsOf(file, skin.inverseBindMatrices, TINYGLTF_TYPE_MAT4, "inverseBindMatrices"));
  if (bound && inverse_bind[0].size() < skin.joints.size())
    file.fail("fewer inverseBindMatrices than joints");
  for (size_t i = 0; i < skin.joints.size(); ++i) {
    Eigen::Affine3d joint_from_bound = Eigen::Affine3d::Identity();
    for (int k = 0; bound && k < 16; ++k) joint_from_bound.matrix()(k % 4, k / 4) = inverse_bind[0].at(i, k);
    if (!joint_from_bound.matrix().allFinite() ||
        joint_from_bound.matrix().cwiseAbs().maxCoeff() > kMaxCoordinate)
      file.fail("inverseBindMatrices: not finite");
    result.scene_from_bound.push_back(sceneFromNode(file, parents, skin.joints[i]) * joint_from_bound);
    // A joint that is not in the standard (a twist bone, a palm) follows its nearest ancestor that is.
    int node = skin.joints[i];
    while (node >= 0 && jointByName(model.nodes[node].name) < 0) node = parents[node];
    result.hand_joints.push_back(node < 0 ? 0 : jointByName(model.nodes[node].name));
  }
  return result;
}

std::vector<Joint> readSkeleton(const File& file, const std::vector<int>& parents, const FileSkin& skin) {
  std::vector<Joint> joints;
  for (size_t j = 0; j < kJointNames.size(); ++j) {
    const Eigen::Affine3d scene_from_joint = sceneFromNode(file, parents, skin.nodes[j]);
    if (std::abs(scene_from_joint.linear().determinant()) < kMinVolume)
      file.fail("joint " + std::string(kJointNames[j]) + ": a transform without an inverse");
    Joint joint{kJointNames[j], standardParent(int(j)), Pose::Identity()};
    joint.hand_from_joint_rest.linear() = scene_from_joint.rotation();  // scale dropped
    joint.hand_from_joint_rest.translation() = scene_from_joint.translation();
    joints.push_back(joint);
  }
  return joints;
}

/// Adds primitives to a hand. Merges vertices with the same position, because texture seams would otherwise
/// be cuts in the skin.
class SkinBuilder {
 public:
  SkinBuilder(const File& file, const FileSkin& skin, HandModel& hand)
      : file_(file), skin_(skin), hand_(hand) {}

  void add(const tinygltf::Primitive& primitive) {
    if (primitive.mode != -1 && primitive.mode != TINYGLTF_MODE_TRIANGLES)
      file_.fail("a primitive of points, lines or strips; export triangles");
    const GltfElements positions =
        elementsOf(file_, attribute(primitive, "POSITION"), TINYGLTF_TYPE_VEC3, "POSITION");
    if (positions.componentType() != TINYGLTF_COMPONENT_TYPE_FLOAT) file_.fail("POSITION: not floats");
    if (positions.size() > 3 * kMaxTriangles) file_.fail("more than 3 million vertices");
    const std::vector<int> vertices = addVertices(primitive, positions);
    if (primitive.indices < 0) {
      addTriangles(vertices, positions.size(), [](size_t i) { return double(i); });
    } else {
      const GltfElements indices = elementsOf(file_, primitive.indices, TINYGLTF_TYPE_SCALAR, "indices");
      if (indices.componentType() == TINYGLTF_COMPONENT_TYPE_FLOAT) file_.fail("indices: not integers");
      addTriangles(vertices, indices.size(), [&](size_t i) { return indices.at(i); });
    }
  }

 private:
  static int attribute(const tinygltf::Primitive& primitive, const std::string& name) {
    const auto found = primitive.attributes.find(name);
    return found == primitive.attributes.end() ? -1 : found->second;
  }

  std::vector<int> addVertices(const tinygltf::Primitive& primitive, const GltfElements& positions) {
    std::vector<GltfElements> joints,
        weights;  // JOINTS_0, WEIGHTS_0; more sets if vertices have over four joints
    for (int set = 0; set == 0 || attribute(primitive, "JOINTS_" + std::to_string(set)) >= 0; ++set) {
      const std::string joints_name = "JOINTS_" + std::to_string(set),
                        weights_name = "WEIGHTS_" + std::to_string(set);
      joints.push_back(elementsOf(file_, attribute(primitive, joints_name), TINYGLTF_TYPE_VEC4, joints_name));
      weights.push_back(
          elementsOf(file_, attribute(primitive, weights_name), TINYGLTF_TYPE_VEC4, weights_name));
      if (joints.back().size() < positions.size() || weights.back().size() < positions.size())
        file_.fail(joints_name + ", " + weights_name + ": fewer than vertices");
    }
    std::vector<int> vertices(positions.size());
    for (size_t v = 0; v < positions.size(); ++v) {
      const Vec3 bound(positions.at(v, 0), positions.at(v, 1), positions.at(v, 2));
      if (!bound.allFinite() || bound.cwiseAbs().maxCoeff() > kMaxCoordinate)
        file_.fail("POSITION: vertex " + std::to_string(v) + " is not finite");
      // Adding 0 makes a negative zero positive.
      const auto [known, is_new] = by_position_.try_emplace({bound.x() + 0., bound.y() + 0., bound.z() + 0.},
                                                            int(hand_.weights.size()));
      if (is_new) addVertex(v, bound, joints, weights);
      vertices[v] = known->second;
    }
    return vertices;
  }

  void addVertex(size_t v, const Vec3& bound, const std::vector<GltfElements>& joints,
                 const std::vector<GltfElements>& weights) {
    Vec3 sum = Vec3::Zero();
    double total = 0;
    std::map<int, double> held;  // by index in kJointNames
    for (size_t i = 0; i < 4 * joints.size(); ++i) {
      const double joint = joints[i / 4].at(v, i % 4), weight = weights[i / 4].at(v, i % 4);
      if (!(weight >= 0 && weight <= 1.001))
        file_.fail("vertex " + std::to_string(v) + ": a weight outside 0 to 1");
      if (weight == 0) continue;
      if (!(joint >= 0 && joint < double(skin_.hand_joints.size())))
        file_.fail("vertex " + std::to_string(v) + ": joint index out of range; the skin has " +
                   std::to_string(skin_.hand_joints.size()) + " joints");
      sum += weight * (skin_.scene_from_bound[size_t(joint)] * bound);
      held[skin_.hand_joints[size_t(joint)]] += weight;
      total += weight;
    }
    if (total < 1e-6) file_.fail("vertex " + std::to_string(v) + ": no weight");
    hand_.skin.vertices.push_back(sum / total);
    hand_.weights.push_back(strongestFour(held));
  }

  static SkinWeights strongestFour(const std::map<int, double>& held) {
    std::vector<std::pair<int, double>> sorted(held.begin(), held.end());
    std::stable_sort(sorted.begin(), sorted.end(), [](auto& a, auto& b) { return a.second > b.second; });
    sorted.resize(std::min<size_t>(sorted.size(), 4));
    SkinWeights result;
    double total = 0;
    for (const auto& [joint, weight] : sorted) total += weight;
    for (size_t i = 0; i < sorted.size(); ++i) {
      result.joints[i] = sorted[i].first;
      result.weights[i] = sorted[i].second / total;
    }
    return result;
  }

  template <typename IndexAt>
  void addTriangles(const std::vector<int>& vertices, size_t corners, IndexAt index_at) {
    if (corners % 3 != 0) file_.fail("the number of indices is not a multiple of three");
    if (hand_.skin.triangles.size() + corners / 3 > kMaxTriangles)
      file_.fail("more than a million triangles");
    for (size_t i = 0; i < corners; i += 3) {
      std::array<int, 3> triangle{};
      for (size_t k = 0; k < 3; ++k) {
        const double index = index_at(i + k);
        if (!(index >= 0 && index < double(vertices.size())))
          file_.fail("index " + std::to_string((long long)index) + " out of range; the primitive has " +
                     std::to_string(vertices.size()) + " vertices");
        triangle[k] = vertices[size_t(index)];
      }
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
        hand_.skin.triangles.push_back(triangle);
    }
  }

  const File& file_;
  const FileSkin& skin_;
  HandModel& hand_;
  std::map<std::array<double, 3>, int> by_position_;
};

}  // namespace

HandModel readHandModel(const std::filesystem::path& path) {
  File file{path, {}};
  parse(file);
  const std::vector<int> parents = nodeParents(file);
  const FileSkin skin = findSkin(file, parents);
  HandModel hand;
  hand.name = path.stem().string();
  hand.joints = readSkeleton(file, parents, skin);
  SkinBuilder builder(file, skin, hand);
  std::vector<char> used(file.model.meshes.size(), 0);
  for (const tinygltf::Node& node : file.model.nodes) {
    if (node.skin != skin.index || node.mesh < 0) continue;
    if (size_t(node.mesh) >= used.size()) file.fail("a node's mesh does not exist");
    if (used[node.mesh]++) continue;
    for (const tinygltf::Primitive& primitive : file.model.meshes[node.mesh].primitives)
      builder.add(primitive);
  }
  if (hand.skin.triangles.empty()) file.fail("no mesh is bound to the skin");
  const double volume_m3 = massProperties(hand.skin).volume_m3;
  if (!(std::abs(volume_m3) > kMinVolume)) file.fail("the skin encloses no volume");
  if (volume_m3 < 0)  // a mirrored rig: reverse the triangles
    for (auto& triangle : hand.skin.triangles) std::swap(triangle[1], triangle[2]);
  hand.cut_patches = cutPatches(hand.joints, hand.skin);
  return hand;
}

}  // namespace airclay
