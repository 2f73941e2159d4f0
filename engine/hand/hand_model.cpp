// SPDX-License-Identifier: MIT
// The hand skeleton of the WebXR standard, and linear blend skinning.
#include "engine/hand/hand_model.h"

#include <cmath>

#include "engine/core/error.h"

namespace airclay {

// https://www.w3.org/TR/webxr-hand-input-1/#skeleton-joints-section
const std::array<const char*, 25> kJointNames = {
    "wrist",
    "thumb-metacarpal",
    "thumb-phalanx-proximal",
    "thumb-phalanx-distal",
    "thumb-tip",
    "index-finger-metacarpal",
    "index-finger-phalanx-proximal",
    "index-finger-phalanx-intermediate",
    "index-finger-phalanx-distal",
    "index-finger-tip",
    "middle-finger-metacarpal",
    "middle-finger-phalanx-proximal",
    "middle-finger-phalanx-intermediate",
    "middle-finger-phalanx-distal",
    "middle-finger-tip",
    "ring-finger-metacarpal",
    "ring-finger-phalanx-proximal",
    "ring-finger-phalanx-intermediate",
    "ring-finger-phalanx-distal",
    "ring-finger-tip",
    "pinky-finger-metacarpal",
    "pinky-finger-phalanx-proximal",
    "pinky-finger-phalanx-intermediate",
    "pinky-finger-phalanx-distal",
    "pinky-finger-tip",
};

int standardParent(int joint) {
  const bool begins_a_finger = joint == 1 || joint % 5 == 0;
  return joint == 0 ? -1 : begins_a_finger ? 0 : joint - 1;
}

std::vector<char> cutPatches(const std::vector<Joint>& joints, const TriangleMesh& skin) {
  constexpr int kWrist = 0, kMiddleKnuckle = 11;
  const Vec3 wrist = joints[kWrist].hand_from_joint_rest.translation();
  const Vec3 forward = (joints[kMiddleKnuckle].hand_from_joint_rest.translation() - wrist).normalized();
  std::vector<char> is_cut;
  for (const auto& [ia, ib, ic] : skin.triangles) {
    const Vec3 &a = skin.vertices[ia], &b = skin.vertices[ib], &c = skin.vertices[ic];
    const bool behind = forward.dot((a + b + c) / 3 - wrist) < 0;
    is_cut.push_back(behind && forward.dot((b - a).cross(c - a).normalized()) < -std::sqrt(0.5));
  }
  return is_cut;
}

TriangleMesh posedSkin(const HandModel& hand, const std::vector<Vec3>& joint_angles) {
  if (joint_angles.empty()) return hand.skin;
  if (joint_angles.size() != hand.joints.size())
    throw Error("hand " + hand.name + ": got " + std::to_string(joint_angles.size()) +
                " joint angles; expected one for each of its " + std::to_string(hand.joints.size()) +
                " joints");
  std::vector<Pose> hand_from_joint(hand.joints.size());
  std::vector<Pose> posed_from_rest(hand.joints.size());  // of the parts attached to the joint, hand frame
  for (size_t j = 0; j < hand.joints.size(); ++j) {
    const Joint& joint = hand.joints[j];
    Pose joint_from_turned = Pose::Identity();
    joint_from_turned.linear() = rotationFromVector(joint_angles[j]);
    hand_from_joint[j] = joint.hand_from_joint_rest * joint_from_turned;
    if (joint.parent >= 0) hand_from_joint[j] = posed_from_rest[joint.parent] * hand_from_joint[j];
    posed_from_rest[j] = hand_from_joint[j] * joint.hand_from_joint_rest.inverse();
  }
  TriangleMesh posed = hand.skin;
  for (size_t v = 0; v < posed.vertices.size(); ++v) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 4; ++i) {
      const SkinWeights& held = hand.weights[v];
      if (held.weights[i] > 0)
        sum += held.weights[i] * (posed_from_rest[held.joints[i]] * hand.skin.vertices[v]);
    }
    posed.vertices[v] = sum;
  }
  return posed;
}

HandModel loadHand(const std::string& right_left_or_file) {
  if (right_left_or_file == "right" || right_left_or_file == "left")
    return builtInHand(right_left_or_file == "left");
  return readHandModel(right_left_or_file);
}

}  // namespace airclay
