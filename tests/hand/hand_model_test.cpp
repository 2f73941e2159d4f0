// SPDX-License-Identifier: MIT
// The built-in hand's shape, and posing compared with closed forms.
#include "engine/hand/hand_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "engine/core/error.h"
#include "engine/mesh/distance_grid.h"

namespace airclay {
namespace {

int jointIndex(const std::string& name) {
  for (size_t j = 0; j < kJointNames.size(); ++j)
    if (name == kJointNames[j]) return int(j);
  throw std::runtime_error(name);
}

/// Closed: each edge occurs once in each direction; one fan of triangles around each vertex; the Euler
/// characteristic.
void expectOneClosedManifold(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> third;  // the corner opposite each directed edge
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i)
      ASSERT_TRUE(third.emplace(std::pair{t[i], t[(i + 1) % 3]}, t[(i + 2) % 3]).second)
          << "an edge run twice";
  std::vector<int> degree(mesh.vertices.size()), start(mesh.vertices.size(), -1);
  for (const auto& [edge, corner] : third) {
    ASSERT_TRUE(third.count({edge.second, edge.first})) << "an open edge";
    ++degree[edge.first], start[edge.first] = edge.second;
  }
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    ASSERT_GT(degree[v], 0) << "a vertex without triangles";
    int walked = 0, at = start[v];
    do {
      at = third.at({int(v), at});
      ++walked;
    } while (at != start[v] && walked <= degree[v]);
    ASSERT_EQ(walked, degree[v]) << "two fans at one vertex";
  }
  std::vector<int> component(mesh.vertices.size(), 0), open{0};
  component[0] = 1;
  std::multimap<int, int> neighbours;
  for (const auto& [edge, corner] : third) neighbours.insert(edge);
  size_t reached = 0;
  for (; !open.empty(); ++reached) {
    const int v = open.back();
    open.pop_back();
    for (auto [n, end] = neighbours.equal_range(v); n != end; ++n)
      if (!component[n->second]++) open.push_back(n->second);
  }
  EXPECT_EQ(reached, mesh.vertices.size()) << "more than one component";
  EXPECT_EQ(int(mesh.vertices.size()) - int(third.size() / 2) + int(mesh.triangles.size()), 2);
}

Eigen::AlignedBox3d boundsOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

class BuiltInHand : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(RightAndLeft, BuiltInHand, testing::Bool());

TEST_P(BuiltInHand, IsAClosedManifoldOfHandSize) {
  const HandModel hand = builtInHand(GetParam());
  expectOneClosedManifold(hand.skin);
  EXPECT_GE(hand.skin.triangles.size(), 2500u);
  EXPECT_LE(hand.skin.triangles.size(), 6000u);
  const double volume_m3 = massProperties(hand.skin).volume_m3;  // positive: outward
  EXPECT_GT(volume_m3, 300e-6);
  EXPECT_LT(volume_m3, 450e-6);
  const Eigen::AlignedBox3d box = boundsOf(hand.skin);
  EXPECT_GT(box.max().x(), 0.185);  // from the wrist, at the origin, to the tip of the middle finger
  EXPECT_LT(box.max().x(), 0.195);
  EXPECT_LT(box.min().x(), -0.010);
  EXPECT_GT(box.min().x(), -0.015);
}

TEST_P(BuiltInHand, TrianglesHaveWellDefinedNormals) {
  const HandModel hand = builtInHand(GetParam());
  for (const auto& t : hand.skin.triangles) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = hand.skin.vertices[t[(i + 1) % 3]] - hand.skin.vertices[t[i]];
      const Vec3 b = hand.skin.vertices[t[(i + 2) % 3]] - hand.skin.vertices[t[i]];
      ASSERT_GT(std::atan2(a.cross(b).norm(), a.dot(b)), 10 * std::numbers::pi / 180);
    }
  }
}

TEST_P(BuiltInHand, WebXrJointsAreInsideTheSkin) {
  const HandModel hand = builtInHand(GetParam());
  ASSERT_EQ(hand.joints.size(), kJointNames.size());
  const double side = GetParam() ? -1 : 1;
  for (size_t j = 0; j < hand.joints.size(); ++j) {
    EXPECT_EQ(hand.joints[j].name, kJointNames[j]);
    EXPECT_LT(hand.joints[j].parent, int(j));
    EXPECT_EQ(hand.joints[j].parent, standardParent(int(j)));
    const Mat3 frame = hand.joints[j].hand_from_joint_rest.linear();
    EXPECT_LT((frame * frame.transpose() - Mat3::Identity()).norm(), 1e-12);
    EXPECT_NEAR(frame.determinant(), 1, 1e-12);
  }
  const auto place = [&](const char* name) {
    return Vec3(hand.joints[jointIndex(name)].hand_from_joint_rest.translation());
  };
  EXPECT_EQ(place("wrist"), Vec3(0, 0, 0));
  EXPECT_LT(std::abs(place("middle-finger-tip").y()), 0.003);
  EXPECT_GT(side * place("thumb-tip").y(), 0.05);
  EXPECT_GT(side * place("index-finger-tip").y(), side * place("pinky-finger-tip").y());
  // Buryanov and Kotiuk 2010, mm; the last segment includes the soft tip.
  const std::map<std::string, double> lengths = {{"thumb-phalanx-proximal", 46.22},
                                                 {"thumb-phalanx-distal", 31.57},
                                                 {"thumb-tip", 21.67 + 5.67},
                                                 {"index-finger-phalanx-proximal", 68.12},
                                                 {"index-finger-phalanx-intermediate", 39.78},
                                                 {"middle-finger-phalanx-intermediate", 44.63},
                                                 {"middle-finger-phalanx-distal", 26.33},
                                                 {"middle-finger-tip", 17.40 + 3.95},
                                                 {"ring-finger-phalanx-proximal", 58.00},
                                                 {"ring-finger-phalanx-distal", 25.65},
                                                 {"pinky-finger-phalanx-distal", 18.11},
                                                 {"pinky-finger-tip", 15.96 + 3.73}};
  for (const auto& [name, length_mm] : lengths) {
    const Vec3 parent = hand.joints[hand.joints[jointIndex(name)].parent].hand_from_joint_rest.translation();
    EXPECT_NEAR((place(name.c_str()) - parent).norm() * 1e3, length_mm, 1e-9) << name;
  }
  // -z of a joint points along its bone, y out of the back of the hand.
  const Mat3 knuckle = hand.joints[jointIndex("index-finger-phalanx-proximal")].hand_from_joint_rest.linear();
  const Vec3 bone = place("index-finger-phalanx-intermediate") - place("index-finger-phalanx-proximal");
  EXPECT_GT((-knuckle.col(2)).dot(bone.normalized()), 1 - 1e-12);
  EXPECT_GT(knuckle(2, 1), 0.95);
}

TEST_P(BuiltInHand, EveryVertexHasWeights) {
  const HandModel hand = builtInHand(GetParam());
  ASSERT_EQ(hand.weights.size(), hand.skin.vertices.size());
  for (const SkinWeights& held : hand.weights) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      EXPECT_GE(held.weights[i], 0);
      EXPECT_GE(held.joints[i], 0);
      EXPECT_LT(held.joints[i], int(hand.joints.size()));
      sum += held.weights[i];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST_P(BuiltInHand, WristCutIsFlat) {
  const HandModel hand = builtInHand(GetParam());
  ASSERT_EQ(hand.cut_patches.size(), hand.skin.triangles.size());
  double area_m2 = 0;
  for (size_t t = 0; t < hand.cut_patches.size(); ++t) {
    const auto& [a, b, c] = hand.skin.triangles[t];
    if (!hand.cut_patches[t]) continue;
    for (const int v : {a, b, c}) EXPECT_LT(hand.skin.vertices[v].x(), -0.005);
    area_m2 -= (hand.skin.vertices[b] - hand.skin.vertices[a])
                   .cross(hand.skin.vertices[c] - hand.skin.vertices[a])
                   .x() /
               2;
  }
  const double ellipse_m2 = std::numbers::pi * 0.030 * 0.021;  // about the wrist
  EXPECT_GT(area_m2, 0.75 * ellipse_m2);
  EXPECT_LT(area_m2, 1.1 * ellipse_m2);
}

TEST(BuiltInHands, MirrorEachOther) {
  const HandModel right = builtInHand(false), left = builtInHand(true);
  ASSERT_EQ(left.skin.vertices.size(), right.skin.vertices.size());
  for (size_t v = 0; v < left.skin.vertices.size(); ++v) {
    const Vec3& vertex = right.skin.vertices[v];
    EXPECT_EQ(left.skin.vertices[v], Vec3(vertex.x(), -vertex.y(), vertex.z()));
  }
  EXPECT_NEAR(massProperties(left.skin).volume_m3, massProperties(right.skin).volume_m3, 1e-15);
  // Both fists close by the same angles, about x of each joint.
  std::vector<Vec3> angles(25, Vec3::Zero());
  for (const char* name :
       {"index-finger-phalanx-proximal", "ring-finger-phalanx-intermediate", "thumb-phalanx-distal"})
    angles[jointIndex(name)] = Vec3(-0.8, 0, 0);
  const TriangleMesh right_posed = posedSkin(right, angles), left_posed = posedSkin(left, angles);
  for (size_t v = 0; v < left_posed.vertices.size(); ++v) {
    const Vec3& vertex = right_posed.vertices[v];
    EXPECT_LT((left_posed.vertices[v] - Vec3(vertex.x(), -vertex.y(), vertex.z())).norm(), 1e-12);
  }
  EXPECT_LT(boundsOf(right_posed).min().z(), boundsOf(right.skin).min().z());  // towards the palm
}

TEST(BuiltInForearm, ContinuesTheWristBackwards) {
  const TriangleMesh forearm = builtInForearm(false);
  expectOneClosedManifold(forearm);
  EXPECT_GT(massProperties(forearm).volume_m3, 0);
  const TriangleMesh skin = builtInHand(false).skin;
  const Eigen::AlignedBox3d box = boundsOf(forearm);
  EXPECT_GT(box.max().x(), boundsOf(skin).min().x());  // no gap
  for (const Vec3& vertex : forearm.vertices) {        // the part inside the hand is hidden
    if (vertex.x() > -0.006) {
      EXPECT_LT(signedDistance(skin, vertex), 0) << vertex.transpose();
    }
  }
  EXPECT_NEAR(box.min().x(), -0.235, 0.01);  // extends 22 cm from the cut
}

TEST(PosedSkin, ZeroAnglesGiveTheRestPose) {
  const HandModel hand = builtInHand(false);
  const TriangleMesh posed = posedSkin(hand, std::vector<Vec3>(hand.joints.size(), Vec3::Zero()));
  EXPECT_EQ(posed.triangles, hand.skin.triangles);
  for (size_t v = 0; v < posed.vertices.size(); ++v)
    EXPECT_LT((posed.vertices[v] - hand.skin.vertices[v]).norm(), 1e-14);
  EXPECT_EQ(posedSkin(hand, {}).vertices.size(), hand.skin.vertices.size());
  EXPECT_THROW(posedSkin(hand, std::vector<Vec3>(3, Vec3::Zero())), Error);
}

TEST(PosedSkin, BentFingertipRotatesAboutItsKnuckle) {
  const HandModel hand = builtInHand(false);
  const int knuckle = jointIndex("index-finger-phalanx-proximal"),
            distal = jointIndex("index-finger-phalanx-distal");
  const Vec3 angle(-1.1, 0.2, 0.1);
  std::vector<Vec3> angles(hand.joints.size(), Vec3::Zero());
  angles[knuckle] = angle;
  const TriangleMesh posed = posedSkin(hand, angles);
  const Pose& hand_from_knuckle = hand.joints[knuckle].hand_from_joint_rest;
  const Pose& hand_from_tip = hand.joints[jointIndex("index-finger-tip")].hand_from_joint_rest;
  int checked = 0, still = 0;
  for (size_t v = 0; v < posed.vertices.size(); ++v) {
    const Vec3& rest = hand.skin.vertices[v];
    double on_finger = 0;  // the fraction that rotates
    for (int i = 0; i < 4; ++i)
      if (hand.weights[v].joints[i] >= knuckle && hand.weights[v].joints[i] <= distal + 1)
        on_finger += hand.weights[v].weights[i];
    const Vec3 turned =
        hand_from_knuckle * (rotationFromVector(angle) * (hand_from_knuckle.inverse() * rest));
    ASSERT_LT((posed.vertices[v] - (on_finger * turned + (1 - on_finger) * rest)).norm(), 1e-12);
    if ((rest - hand_from_tip.translation()).norm() < 0.012) {
      EXPECT_GT(on_finger, 0.999);
      ++checked;
    }
    if (rest.x() < 0.05 || rest.y() < -0.02) {
      EXPECT_LT(on_finger, 0.02);
      ++still;
    }
  }
  EXPECT_GT(checked, 10);
  EXPECT_GT(still, 500);
}

TEST(PosedSkin, RotationsComposeAlongTheFinger) {
  HandModel hand = builtInHand(false);
  const int knuckle = jointIndex("index-finger-phalanx-proximal"), tip = jointIndex("index-finger-tip");
  hand.skin.vertices = {hand.joints[tip].hand_from_joint_rest.translation()};
  hand.skin.triangles.clear();
  hand.weights = {SkinWeights{{tip, 0, 0, 0}, {1, 0, 0, 0}}};
  std::vector<Vec3> angles(hand.joints.size(), Vec3::Zero());
  Pose hand_from_joint = hand.joints[knuckle].hand_from_joint_rest;
  for (int j = knuckle; j < tip; ++j) {
    angles[j] = Vec3(-0.3 * (j - knuckle + 1), 0.05, 0);
    hand_from_joint.rotate(rotationFromVector(angles[j]));
    hand_from_joint = hand_from_joint * hand.joints[j].hand_from_joint_rest.inverse() *
                      hand.joints[j + 1].hand_from_joint_rest;
  }
  EXPECT_LT((posedSkin(hand, angles).vertices[0] - hand_from_joint.translation()).norm(), 1e-14);
}

TEST(LoadHand, LoadsRightAndLeft) {
  EXPECT_EQ(loadHand("right").name, "right");
  EXPECT_LT(loadHand("left").joints[jointIndex("thumb-tip")].hand_from_joint_rest.translation().y(), 0);
  EXPECT_THROW(loadHand("neither.glb"), Error);
}

}  // namespace
}  // namespace airclay
