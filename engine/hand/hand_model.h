// SPDX-License-Identifier: MIT
// The paper's skeletal model (fig. 2): links, joint angles, and a skin of weighted triangle patches.
#pragma once

#include <filesystem>
#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// The 25 joints of WebXR hand tracking, in the standard's order.
extern const std::array<const char*, 25> kJointNames;

/// The parent of kJointNames[joint] in the standard's skeleton; -1 for the wrist.
int standardParent(int joint);

/// A joint of the skeleton; the link runs from its parent to it.
struct Joint {
  std::string name;                              ///< one of kJointNames
  int parent = -1;                               ///< index, -1 for the wrist; parents precede children
  Pose hand_from_joint_rest = Pose::Identity();  ///< in the rest pose
};

/// A skin vertex's joints, up to four, with weights that sum to 1.
struct SkinWeights {
  std::array<int, 4> joints{};
  std::array<double, 4> weights{1, 0, 0, 0};
};

/// One skeleton and one skin. The hand frame is that of the rest pose: the scene coordinates of the file.
struct HandModel {
  std::string name;
  std::vector<Joint> joints;
  TriangleMesh skin;                 ///< rest pose, hand frame; may be open at the wrist
  std::vector<SkinWeights> weights;  ///< one per skin vertex
  /// One per skin triangle: 1 if it is part of the cut where the forearm continues, which no camera sees
  /// (cutPatches()). A skin that is open at the wrist has no such triangles; withCaps() adds them after the
  /// skin's own.
  std::vector<char> cut_patches;
};

/// Marks the patches where the forearm continues, for a skin closed at the wrist: their centroids are behind
/// the wrist joint as seen from the middle finger's knuckle, and they face that direction within 45°.
std::vector<char> cutPatches(const std::vector<Joint>& joints, const TriangleMesh& skin);

/// The skin with each joint j rotated from the rest pose by the rotation vector joint_angles[j] (radians, in
/// the joint's own frame), by linear blend skinning. An empty vector is the rest pose with straight fingers,
/// the paper's spatula.
TriangleMesh posedSkin(const HandModel& hand, const std::vector<Vec3>& joint_angles);

/// The built-in hand with straight fingers, about 19 cm long; hand_builtin.cpp gives the sources of its
/// measures. Frame: origin at the wrist joint, x towards the tip of the middle finger, y towards the thumb
/// side of the right hand, z out of the back of the hand. The left hand is the mirror image in y.
HandModel builtInHand(bool left);

/// The forearm that continues the built-in hand, hand frame, metres. Cameras see it, but it is not part of
/// the model.
TriangleMesh builtInForearm(bool left);

/// Reads a skinned glTF binary whose joints have the WebXR names. \throw Error naming the file and what is
/// missing.
HandModel readHandModel(const std::filesystem::path& file);

/// Loads the built-in hand `right` or `left`, or a glTF binary.
HandModel loadHand(const std::string& right_left_or_file);

}  // namespace airclay
