// SPDX-License-Identifier: MIT
// The paper's skeletal model (fig. 2): links, joint angles, and a skin of triangle patches with weights.
#pragma once

#include <filesystem>
#include <string>

#include "engine/mesh/mesh.h"

namespace airclay {

/// The 25 joints of WebXR and OpenXR hand tracking, in the standard's order.
extern const std::array<const char*, 25> kJointNames;

/// The parent of kJointNames[joint] by the standard, -1 for the wrist.
int standardParent(int joint);

/// A joint of the skeleton; the link runs from its parent to it.
struct Joint {
  std::string name;                              ///< one of kJointNames
  int parent = -1;                               ///< index, -1 at the wrist; parents come before children
  Pose hand_from_joint_rest = Pose::Identity();  ///< in the rest pose
};

/// What holds a skin vertex to the skeleton: up to four joints, weights that sum to 1.
struct SkinWeights {
  std::array<int, 4> joints{};
  std::array<double, 4> weights{1, 0, 0, 0};
};

/// One skeleton, one skin. The hand's frame is that of the rest pose: the file's scene coordinates as they
/// stand.
struct HandModel {
  std::string name;
  std::vector<Joint> joints;
  TriangleMesh skin;                 ///< rest pose, hand frame; may be open at the wrist
  std::vector<SkinWeights> weights;  ///< one a skin vertex
  /// One a skin triangle: 1 where it belongs to the cut behind which the forearm goes on, so that no camera
  /// sees it (see cutPatches). A skin open at the wrist has none: withCaps() adds them after the skin's own
  /// triangles.
  std::vector<char> cut_patches;
};

/// The patches of a skin closed at the wrist that stand before the forearm: their centroids lie behind the
/// wrist joint, as seen from the middle finger's knuckle, and they face that way within 45°.
std::vector<char> cutPatches(const std::vector<Joint>& joints, const TriangleMesh& skin);

/// The skin with joint j turned by the rotation vector joint_angles[j] (radians, in the joint's own frame)
/// from the rest pose: linear blend skinning. An empty vector is the rest pose: straight fingers, the paper's
/// spatula.
TriangleMesh posedSkin(const HandModel& hand, const std::vector<Vec3>& joint_angles);

/// The built-in hand, straight fingers, about 19 cm; see hand_builtin.cpp for its measures and their sources.
/// Frame: origin at the wrist joint, x towards the middle finger's tip, y towards the thumb of the right
/// hand's (the index-finger side), z out of the back of the hand. The left hand is the mirror image in y.
HandModel builtInHand(bool left);

/// The forearm that continues the built-in hand, in the hand's frame: seen by cameras, no part of the model.
TriangleMesh builtInForearm(bool left);

/// Reads a skinned glTF binary whose joints bear the WebXR names. \throw Error naming the file and what it
/// lacks.
HandModel readHandModel(const std::filesystem::path& file);

/// `right`, `left`, or a glTF binary's path.
HandModel loadHand(const std::string& right_left_or_file);

}  // namespace airclay
