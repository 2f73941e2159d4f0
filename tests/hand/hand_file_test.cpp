// SPDX-License-Identifier: MIT
// Hands in glTF binaries, valid and damaged, which the tests write themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <sstream>

#include "engine/core/error.h"
#include "engine/hand/hand_model.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

/// What the tests vary in an otherwise valid file.
struct Glb {
  int index_type = 5123;         // u16; 5121 u8, 5125 u32
  bool byte_weights = false;     // normalized u8 instead of float
  bool nested = false;           // joints form a hierarchy below a rotated root, instead of being siblings
  bool bound_elsewhere = false;  // vertices are rotated and shifted by the inverse bind matrices
  bool two_primitives = false;
  bool inside_out = false;
  std::string missing_joint = "", doubled_joint = "";
  bool without_skin = false, sparse = false, truncated = false, looped_nodes = false;
  double first_coordinate = -0.02;  // of the first vertex
  unsigned last_index = 23;
  int first_joint = 0;       // of the first vertex
  long accessor_count = 24;  // of POSITION
};

const Vec3 kShift(0.1, 0.2, -0.3), kTurn(0.2, -0.4, 1.1);
const double kEdge = 0.04;

/// An octahedron whose triangles share no vertices: 24 vertices at 6 positions.
std::vector<Vec3> looseOctahedron() {
  std::vector<Vec3> vertices;
  for (int octant = 0; octant < 8; ++octant) {
    const double x = octant & 1 ? 1 : -1, y = octant & 2 ? 1 : -1, z = octant & 4 ? 1 : -1;
    std::array<Vec3, 3> corners = {Vec3(x, 0, 0), Vec3(0, y, 0), Vec3(0, 0, z)};
    if (x * y * z < 0) std::swap(corners[1], corners[2]);
    for (const Vec3& corner : corners) vertices.push_back(kEdge / 2 * corner);
  }
  return vertices;
}

Pose placed(const Vec3& translation, const Vec3& rotation) {
  Pose pose = Pose::Identity();
  pose.translation() = translation;
  pose.linear() = rotationFromVector(rotation);
  return pose;
}

Pose jointWorld(int joint) {  // arbitrary rigid transforms of the file's joints
  return placed(Vec3(0.01 * joint, 0.02, -0.005 * (joint % 5)), {0.1 * joint, 0.3, -0.2});
}

class GlbWriter {
 public:
  explicit GlbWriter(const Glb& glb) : glb_(glb) {}

  std::string bytes() {
    std::vector<Vec3> vertices = looseOctahedron();
    if (glb_.first_coordinate != -0.02) vertices[0].x() = glb_.first_coordinate;
    std::string positions, joints, weights, indices, inverse_bind;
    for (size_t v = 0; v < vertices.size(); ++v) {
      for (int c = 0; c < 3; ++c) put(positions, float(vertices[v][c]));
      const int second = 6;
      for (const int joint : {v == 0 ? glb_.first_joint : 0, second, 0, 0}) put(joints, std::uint8_t(joint));
      const bool shared =
          vertices[v].z() > 0;  // a quarter of the weight belongs to the index finger's first phalanx
      for (const double weight : {shared ? 0.6 : 1., shared ? 0.4 : 0., 0., 0.}) {
        if (glb_.byte_weights)
          put(weights, std::uint8_t(255 * weight));
        else
          put(weights, float(weight));
      }
    }
    for (unsigned i = 0; i < 24; ++i) {
      unsigned index = glb_.inside_out ? i / 3 * 3 + 2 - i % 3 : i;
      if (i == 23) index = glb_.last_index;
      if (glb_.index_type == 5121) put(indices, std::uint8_t(index));
      if (glb_.index_type == 5123) put(indices, std::uint16_t(index));
      if (glb_.index_type == 5125) put(indices, std::uint32_t(index));
    }
    for (int j = 0; j < 25; ++j) {
      Pose bound_from_scene = Pose::Identity();
      if (glb_.bound_elsewhere) bound_from_scene = placed(kShift, kTurn);
      const Pose matrix = jointWorld(j).inverse() * bound_from_scene;
      for (int k = 0; k < 16; ++k) put(inverse_bind, float(matrix.matrix()(k % 4, k / 4)));
    }
    accessor(positions, 5126, glb_.accessor_count, "VEC3", false);
    accessor(joints, 5121, 24, "VEC4", false);
    accessor(weights, glb_.byte_weights ? 5121 : 5126, 24, "VEC4", glb_.byte_weights);
    const long half = glb_.two_primitives ? 12 : 24;
    const size_t index_bytes = indices.size() / 24;
    accessor(indices.substr(0, half * index_bytes), glb_.index_type, half, "SCALAR", false);
    accessor(inverse_bind, 5126, 25, "MAT4", false);
    if (glb_.two_primitives)
      accessor(indices.substr(half * index_bytes), glb_.index_type, 12, "SCALAR", false);
    return container(json());
  }

 private:
  template <typename T>
  static void put(std::string& to, T value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  }

  void accessor(std::string data, int component, long count, const std::string& type, bool normalized) {
    std::ostringstream view, text;
    view << "{\"buffer\":0,\"byteOffset\":" << buffer_.size() << ",\"byteLength\":" << data.size() << "}";
    text << "{\"bufferView\":" << views_.size() << ",\"componentType\":" << component
         << ",\"count\":" << count << ",\"type\":\"" << type
         << "\",\"normalized\":" << (normalized ? "true" : "false");
    if (glb_.sparse && views_.empty())
      text << ",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"byteOffset\":0,\"componentType\":"
              "5123},"
              "\"values\":{\"bufferView\":0,\"byteOffset\":0}}";
    text << "}";
    views_.push_back(view.str());
    accessors_.push_back(text.str());
    data.resize((data.size() + 3) / 4 * 4);
    buffer_ += data;
  }

  static std::string joined(const std::vector<std::string>& parts) {
    std::string all;
    for (const std::string& part : parts) all += (all.empty() ? "" : ",") + part;
    return all;
  }

  std::string node(int joint) const {
    std::string name = kJointNames[joint];
    if (name == glb_.missing_joint) name = "unknown";
    if (joint > 0 && !glb_.doubled_joint.empty() && joint == 3) name = glb_.doubled_joint;
    const int parent = standardParent(joint);
    Pose parent_from_joint = jointWorld(joint);
    if (glb_.nested)
      parent_from_joint = (parent < 0 ? root() : jointWorld(parent)).inverse() * jointWorld(joint);
    const Eigen::Quaterniond q(parent_from_joint.linear());
    const Vec3 t = parent_from_joint.translation();
    std::ostringstream text;
    text.precision(17);
    text << "{\"name\":\"" << name << "\",\"rotation\":[" << q.x() << "," << q.y() << "," << q.z() << ","
         << q.w() << "],\"translation\":[" << t.x() << "," << t.y() << "," << t.z() << "]";
    std::vector<std::string> children;
    for (int child = 0; glb_.nested && child < 25; ++child)
      if (standardParent(child) == joint) children.push_back(std::to_string(child));
    if (glb_.looped_nodes && joint == 24) children.push_back("0");
    if (!children.empty()) text << ",\"children\":[" << joined(children) << "]";
    return text.str() + "}";
  }

  static Pose root() { return placed({1, 2, 3}, {0, 0.5, 0}); }

  std::string json() const {
    std::vector<std::string> nodes, joints;
    for (int j = 0; j < 25; ++j) {
      nodes.push_back(node(j));
      joints.push_back(std::to_string(j));
    }
    nodes.push_back(glb_.without_skin ? R"({"mesh":0})" : R"({"mesh":0,"skin":0})");
    std::ostringstream armature;  // the root, as a matrix
    armature.precision(17);
    const Eigen::Matrix4d matrix =
        glb_.nested ? root().matrix() : Eigen::Matrix4d(Eigen::Matrix4d::Identity());
    std::vector<std::string> entries;
    for (int k = 0; k < 16; ++k) {
      std::ostringstream entry;
      entry.precision(17);
      entry << matrix(k % 4, k / 4);
      entries.push_back(entry.str());
    }
    const bool looped = glb_.looped_nodes;
    armature << "{\"matrix\":[" << joined(entries) << "],\"children\":["
             << (looped        ? "25"
                 : glb_.nested ? "0,25"
                               : joined(joints) + ",25")
             << "]}";
    nodes.push_back(armature.str());
    const auto primitive = [](int indices) {
      return R"({"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2},"indices":)" +
             std::to_string(indices) + "}";
    };
    std::ostringstream text;
    text << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[26]}],"nodes":[)" << joined(nodes)
         << R"(],"meshes":[{"primitives":[)" << primitive(3)
         << (glb_.two_primitives ? "," + primitive(5) : "") << "]}],";
    if (!glb_.without_skin)
      text << R"("skins":[{"inverseBindMatrices":4,"joints":[)" << joined(joints) << "]}],";
    text << R"("accessors":[)" << joined(accessors_) << R"(],"bufferViews":[)" << joined(views_)
         << R"(],"buffers":[{"byteLength":)" << buffer_.size() << "}]}";
    return text.str();
  }

  std::string container(std::string text) const {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string all = "glTF";
    put(all, std::uint32_t(2));
    put(all, std::uint32_t(12 + 8 + text.size() + 8 + buffer_.size()));
    put(all, std::uint32_t(text.size()));
    all += "JSON" + text;
    put(all, std::uint32_t(buffer_.size()));
    all += std::string("BIN\0", 4) + buffer_;
    return glb_.truncated ? all.substr(0, all.size() / 2) : all;
  }

  Glb glb_;
  std::string buffer_;
  std::vector<std::string> views_, accessors_;
};

class HandFile : public testing::Test {
 protected:
  HandModel read(const Glb& glb) { return readBytes(GlbWriter(glb).bytes()); }

  HandModel readBytes(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return readHandModel(path_);
  }

  /// The error's only line, which must name the file.
  std::string errorOf(const Glb& glb) { return errorOfBytes(GlbWriter(glb).bytes()); }

  std::string errorOfBytes(const std::string& bytes) {
    try {
      readBytes(bytes);
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("test-hand.glb"), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message;
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "test-hand.glb";
};

void expectOctahedron(const HandModel& hand, const Pose& scene_from_bound) {
  ASSERT_EQ(hand.skin.vertices.size(), 6u);  // welded
  ASSERT_EQ(hand.skin.triangles.size(), 8u);
  EXPECT_EQ(withCaps(hand.skin).triangles.size(), 8u);  // closed
  EXPECT_NEAR(massProperties(hand.skin).volume_m3, std::pow(kEdge / 2, 3) * 4 / 3, 1e-11);
  for (const Vec3& corner : looseOctahedron()) {
    double nearest = 1;
    for (const Vec3& vertex : hand.skin.vertices)
      nearest = std::min(nearest, (vertex - scene_from_bound * corner).norm());
    EXPECT_LT(nearest, 1e-6);  // the file stores floats
  }
}

TEST_F(HandFile, ReadsEveryVariant) {
  for (const int index_type : {5121, 5123, 5125}) {
    for (const bool byte_weights : {false, true}) {
      for (const bool nested : {false, true}) {
        Glb glb;
        glb.index_type = index_type, glb.byte_weights = byte_weights, glb.nested = nested;
        glb.two_primitives = nested;
        const HandModel hand = read(glb);
        EXPECT_EQ(hand.name, "test-hand");
        expectOctahedron(hand, Pose::Identity());
        ASSERT_EQ(hand.joints.size(), 25u);
        for (int j = 0; j < 25; ++j) {
          EXPECT_EQ(hand.joints[j].name, kJointNames[j]);
          EXPECT_EQ(hand.joints[j].parent, standardParent(j));
          EXPECT_LT((hand.joints[j].hand_from_joint_rest.matrix() - jointWorld(j).matrix()).norm(), 1e-12);
        }
        for (size_t v = 0; v < hand.skin.vertices.size(); ++v) {
          const double on_index = hand.skin.vertices[v].z() > 0.01 ? 0.4 : 0;
          double found = 0, sum = 0;
          for (int i = 0; i < 4; ++i) {
            sum += hand.weights[v].weights[i];
            if (hand.weights[v].joints[i] == 6) found += hand.weights[v].weights[i];
          }
          EXPECT_NEAR(sum, 1, 1e-12);
          EXPECT_NEAR(found, on_index, 1e-6);
        }
      }
    }
  }
}

TEST_F(HandFile, AppliesBindMatrices) {
  Glb glb;
  glb.bound_elsewhere = true;
  glb.nested = true;
  expectOctahedron(read(glb), placed(kShift, kTurn));
}

TEST_F(HandFile, OrientsTrianglesOutwards) {
  Glb glb;
  glb.inside_out = true;
  glb.last_index = 21;
  expectOctahedron(read(glb), Pose::Identity());
}

TEST_F(HandFile, RejectsInvalidFilesWithTheReason) {
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos ? testing::AssertionSuccess()
                                                : testing::AssertionFailure() << text << " lacks " << part;
  };
  EXPECT_TRUE(contains(errorOf({.missing_joint = "ring-finger-tip"}), "lacks the joint ring-finger-tip"));
  EXPECT_TRUE(contains(errorOf({.doubled_joint = "wrist"}), "two joints are named wrist"));
  EXPECT_TRUE(contains(errorOf({.without_skin = true}), "no skin"));
  EXPECT_TRUE(contains(errorOf({.sparse = true}), "sparse"));
  EXPECT_TRUE(contains(errorOf({.nested = true, .looped_nodes = true}), "its own ancestor"));
  EXPECT_TRUE(
      contains(errorOf({.first_coordinate = std::numeric_limits<double>::quiet_NaN()}), "not finite"));
  EXPECT_TRUE(contains(errorOf({.last_index = 24}), "index 24 out of range"));
  EXPECT_TRUE(
      contains(errorOf({.index_type = 5125, .last_index = 4000000000u}), "index 4000000000 out of range"));
  EXPECT_TRUE(contains(errorOf({.first_joint = 25}), "joint index out of range"));
  EXPECT_TRUE(contains(errorOf({.accessor_count = 25}), "extends beyond"));
  EXPECT_TRUE(contains(errorOf({.accessor_count = 4611686018427387904}), "extends beyond"));
  EXPECT_TRUE(
      contains(errorOf({.accessor_count = 20}), "out of range"));  // fewer vertices than the indices use
  EXPECT_TRUE(contains(errorOfBytes("solid stl, not a hand"), "not a glTF binary"));
  EXPECT_TRUE(contains(errorOfBytes(""), "not a glTF binary"));
  EXPECT_TRUE(contains(errorOfBytes(std::string("glTF\2\0\0\0\xff\xff\xff\xff____JSON{}", 24)), "damaged"));
  EXPECT_TRUE(contains(errorOf({.truncated = true}), "damaged"));
}

TEST_F(HandFile, RejectsLargeAndMissingFiles) {
  std::ofstream(path_) << "glTF";
  std::filesystem::resize_file(path_, 65u << 20);  // a sparse file
  EXPECT_THROW(readHandModel(path_), Error);
  EXPECT_THROW(readHandModel(folder_ / "absent.glb"), Error);
  EXPECT_THROW(readHandModel(folder_.path()), Error);
}

TEST_F(HandFile, TruncatedFilesGiveOneKindOfError) {
  const std::string whole = GlbWriter({}).bytes();
  for (size_t length = 0; length < whole.size(); length += 97)
    EXPECT_THROW(readBytes(whole.substr(0, length)), Error);
}

}  // namespace
}  // namespace airclay
