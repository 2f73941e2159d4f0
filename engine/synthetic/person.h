// SPDX-License-Identifier: MIT
// A hand with its arm and the seated person that it belongs to: a mesh of rigid parts, and where they are for
// a pose of the hand.
#pragma once

#include "engine/hand/hand_model.h"
#include "engine/synthetic/room_options.h"
#include "engine/synthetic/texture.h"

namespace airclay {

enum class Bone { kHand, kForearm, kUpperArm, kTorso, kHead, kSecondTorso, kSecondHead };
inline constexpr int kBones = 7;
/// room_from_bone, by Bone.
using BonePoses = std::array<Pose, kBones>;

enum class Material : std::uint8_t { kHandSkin, kSkin, kShirt, kHair };

/// Vertices of one bone are contiguous.
struct FigureMesh {
  struct Part {
    Bone bone;
    std::uint32_t first, count;  ///< of its vertices
  };
  std::vector<Part> parts;
  std::vector<Vec3f> positions, normals;  ///< metres, bone frame; normals are unit vectors
  std::vector<Vec3f> texture;             ///< metres: position (skin), or along and around the body (shirt)
  std::vector<Vec3f> tint;                ///< factor of the albedo
  std::vector<float> open;                ///< ambient visibility, 0 to 1
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Material> materials;  ///< of the triangles
};

/// A ball that casts soft shadows.
struct ShadowBall {
  Bone bone;
  Vec3 center;  ///< bone frame
  double radius_m;
};

/// Whether a hand model is a left hand: seen with the fingers up and the thumb to the left, the fingers and
/// the thumb of a left hand bend towards the viewer, those of a right hand away.
bool isLeftHand(const HandModel& hand);

/// The joints of the arm whose wrist is at `room_from_wrist`; `side`: 1 for a right arm, -1 for a left one.
/// The shoulder leans towards a wrist out of reach.
struct ArmJoints {
  Vec3 shoulder, elbow, lean;
};
ArmJoints armJoints(const Pose& room_from_wrist, double side);

class Person {
 public:
  Person(const HandModel& hand, const RoomOptions& options);

  const FigureMesh& mesh() const { return mesh_; }
  const std::vector<ShadowBall>& shadowBalls() const { return balls_; }

  /// The pose of the wrist frame in which roomScript() moves the hand: origin at the wrist joint, x to the
  /// middle finger's knuckle, z out of the back of the hand. It accounts for the scale.
  const Pose& handFromWrist() const { return hand_from_wrist_; }
  /// The mirror image of a right hand's room_from_wrist if this hand is a left one.
  Pose sided(const Pose& room_from_wrist) const;
  /// Where every part is. The forearm ends at the wrist. The time moves only the second person.
  BonePoses poses(const Pose& room_from_wrist, double time_s = 0) const;

 private:
  void addHand(const HandModel& hand, const RoomOptions& options);
  void addForearm(const RoomOptions& options);
  void addBody(Bone torso, Bone head);
  void addRestingArm(Bone torso, double side);
  void addBalls(Bone bone, const Vec3& from, const Vec3& to, double radius_from, double radius_to);

  FigureMesh mesh_;
  std::vector<ShadowBall> balls_;
  Pose hand_from_wrist_;
  double side_ = 1;           ///< -1: the left hand
  double wrist_width_m_ = 0;  ///< half
  double wrist_depth_m_ = 0;  ///< half
};

}  // namespace airclay
