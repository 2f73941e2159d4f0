// SPDX-License-Identifier: MIT
#include "engine/synthetic/person.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "engine/synthetic/sensor.h"

namespace airclay {
namespace {

// An adult's measures, metres, rounded.
constexpr double kUpperArm = 0.31, kForearm = 0.27;
const Vec3 kHip(0, -0.80, -0.50);              // on a chair at the desk
const Vec3 kNeck(0, -0.79, 0.20);              // the neck's base, sitting upright
const Vec3 kShoulderFromNeck(0.19, 0, -0.06);  // of the right shoulder joint

/// The section of a limb or body at `x` along its axis: half widths along y and z.
struct Ring {
  double x, y, z;
};

/// The section at `x`, smooth between the given ones.
Ring between(const std::vector<Ring>& rings, double x) {
  std::size_t i = 0;
  while (i + 2 < rings.size() && rings[i + 1].x < x) ++i;
  const Ring &a = rings[i], &b = rings[i + 1];
  const double t = std::clamp((x - a.x) / (b.x - a.x), 0., 1.), s = t * t * (3 - 2 * t);
  return {x, a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
}

/// The rings of a body that ends in half ellipsoids of length `cap`, from pole to pole.
std::vector<Ring> closedRings(const std::vector<Ring>& keys, double cap) {
  constexpr int kCapSteps = 5;
  std::vector<Ring> rings;
  const auto addCap = [&](const Ring& end, double sign, int step) {
    const double angle = std::numbers::pi / 2 * step / kCapSteps;
    rings.push_back({end.x + sign * cap * std::sin(angle), end.y * std::cos(angle), end.z * std::cos(angle)});
  };
  for (int step = kCapSteps; step > 0; --step) addCap(keys.front(), -1, step);
  const double length = keys.back().x - keys.front().x;
  const int steps = std::max(1, static_cast<int>(std::ceil(length / 0.03)));
  for (int step = 0; step <= steps; ++step)
    rings.push_back(between(keys, keys.front().x + length * step / steps));
  for (int step = 1; step <= kCapSteps; ++step) addCap(keys.back(), 1, step);
  return rings;
}

void endPart(FigureMesh& mesh, Bone bone) {
  const std::uint32_t first = mesh.parts.empty() ? 0 : mesh.parts.back().first + mesh.parts.back().count;
  mesh.parts.push_back({bone, first, static_cast<std::uint32_t>(mesh.positions.size()) - first});
}

/// Adds a body with elliptic sections along the loft's x.
void addLoft(FigureMesh& mesh, Bone bone, Material material, const Pose& bone_from_loft,
             const std::vector<Ring>& keys, double cap) {
  const std::vector<Ring> rings = closedRings(keys, cap);
  constexpr int kAround = 24;
  const auto point = [&](std::size_t ring, int column) {
    const double angle = 2 * std::numbers::pi * column / kAround;
    return Vec3(rings[ring].x, rings[ring].y * std::cos(angle), rings[ring].z * std::sin(angle));
  };
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  double girth = 0;
  for (const Ring& key : keys) girth = std::max(girth, 2 * std::numbers::pi * std::max(key.y, key.z));
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (int c = 0; c <= kAround; ++c) {  // the first column again, for the texture
      const std::size_t before = r == 0 ? 0 : r - 1, after = std::min(r + 1, rings.size() - 1);
      Vec3 normal = (point(r, c + 1) - point(r, c - 1)).cross(point(after, c) - point(before, c));
      if (r == 0 || r + 1 == rings.size()) normal = Vec3(r == 0 ? -1 : 1, 0, 0);
      const Vec3 place = bone_from_loft * point(r, c);
      mesh.positions.push_back(place.cast<float>());
      mesh.normals.push_back((bone_from_loft.linear() * normal.normalized()).cast<float>());
      mesh.texture.push_back(material == Material::kShirt
                                 ? Vec3(rings[r].x, girth * c / kAround, 0).cast<float>().eval()
                                 : mesh.positions.back());
      mesh.tint.push_back(Vec3f::Ones());
      mesh.open.push_back(1);
    }
  const std::uint32_t row = kAround + 1;
  for (std::uint32_t r = 0; r + 1 < rings.size(); ++r)
    for (std::uint32_t c = 0; c < kAround; ++c) {
      const std::uint32_t a = first + r * row + c;
      mesh.triangles.push_back({a, a + 1, a + row});
      mesh.triangles.push_back({a + 1, a + row + 1, a + row});
      mesh.materials.insert(mesh.materials.end(), 2, material);
    }
  endPart(mesh, bone);
}

/// x along `along`, z as near to `back` as possible.
Pose frameAt(const Vec3& origin, const Vec3& along, const Vec3& back) {
  Pose frame = Pose::Identity();
  const Vec3 x = along.normalized(), z = (back - x * x.dot(back)).normalized();
  frame.linear() << x, z.cross(x), z;
  frame.translation() = origin;
  return frame;
}

Vec3 jointAt(const HandModel& hand, const std::string& name) {
  const auto joint = std::ranges::find(hand.joints, name, &Joint::name);
  if (joint == hand.joints.end()) throw std::logic_error("the hand model has no joint " + name);
  return joint->hand_from_joint_rest.translation();
}

/// Out of the back of a right hand, out of the palm of a left one.
Vec3 acrossThePalm(const HandModel& hand) {
  const Vec3 along = jointAt(hand, "middle-finger-phalanx-proximal") - jointAt(hand, "wrist");
  const Vec3 to_thumb =
      jointAt(hand, "index-finger-phalanx-proximal") - jointAt(hand, "pinky-finger-phalanx-proximal");
  return along.cross(to_thumb).normalized();
}

Pose wristFrame(const HandModel& hand, double scale) {
  const Vec3 wrist = jointAt(hand, "wrist");
  const Vec3 along = jointAt(hand, "middle-finger-phalanx-proximal") - wrist;
  return frameAt(scale * wrist, along, (isLeftHand(hand) ? -1 : 1) * acrossThePalm(hand));
}

/// `direction`, turned about `axis` (both unit, perpendicular) by the smallest angle that brings its z to
/// `lowest`, or as high as it gets.
Vec3 aboveDesk(const Vec3& direction, const Vec3& axis, double lowest) {
  if (direction.z() >= lowest) return direction;
  const Vec3 sideways = axis.cross(direction);
  // z = highest cos(angle - angle of the highest)
  const double highest = std::hypot(direction.z(), sideways.z()),
               at = std::atan2(sideways.z(), direction.z());
  const double within = std::acos(std::clamp(lowest / highest, -1., 1.));
  const double angle = at > 0 ? at - within : at + within;
  return std::cos(angle) * direction + std::sin(angle) * sideways;
}

/// `length`, or a little more than `limit` where it exceeds that: without a kink.
double softExcess(double length, double limit) {
  const double over = length - limit;
  return 0.5 * (over + std::sqrt(over * over + 0.03 * 0.03));
}

}  // namespace

bool isLeftHand(const HandModel& hand) {
  const Vec3 across = acrossThePalm(hand);
  double bend_m = 0;
  for (const std::string finger : {"index", "middle", "ring", "pinky"})
    bend_m += across.dot(jointAt(hand, finger + "-finger-tip") -
                         jointAt(hand, finger + "-finger-phalanx-proximal"));
  bend_m += 4 * across.dot(jointAt(hand, "thumb-tip") - jointAt(hand, "index-finger-metacarpal"));
  return bend_m > 0;
}

Person::Person(const HandModel& hand, const RoomOptions& options)
    : hand_from_wrist_(wristFrame(hand, options.hand_scale)), side_(isLeftHand(hand) ? -1 : 1) {
  addHand(hand, options);
  if (options.arm == Arm::kNone) return;
  addForearm(options);
  if (!options.has_person) return;
  const Pose straight = Pose::Identity();
  const bool bare = options.arm == Arm::kBare;
  if (bare)
    addLoft(mesh_, Bone::kUpperArm, Material::kSkin, straight, {{-0.20, 0.043, 0.043}, {0, 0.040, 0.038}},
            0.036);
  addLoft(
      mesh_, Bone::kUpperArm, Material::kShirt, straight,
      {{-kUpperArm, 0.062, 0.060}, {-0.15, 0.056, 0.056}, {bare ? -0.13 : 0, bare ? 0.056 : 0.048, 0.048}},
      bare ? 0.004 : 0.044);
  addBalls(Bone::kUpperArm, {-kUpperArm, 0, 0}, Vec3::Zero(), 0.06, 0.045);
  addBody(Bone::kTorso, Bone::kHead);
  addRestingArm(Bone::kTorso, -side_);
  if (!options.has_second_person) return;
  addBody(Bone::kSecondTorso, Bone::kSecondHead);
  for (const double side : {-1., 1.}) addRestingArm(Bone::kSecondTorso, side);
}

void Person::addHand(const HandModel& hand, const RoomOptions& options) {
  TriangleMesh skin = withCaps(hand.skin);
  for (Vec3& vertex : skin.vertices) vertex *= options.hand_scale;
  const std::vector<Vec3> normals = vertexNormals(skin);
  const std::vector<double> open = openness(skin, normals);
  const Pose wrist_from_hand = hand_from_wrist_.inverse();
  // the darker the skin, the lighter the palm compared with it
  const double paler = 1 + 0.9 * std::max(0., 0.62 - options.skin.mean());
  wrist_width_m_ = wrist_depth_m_ = 0;
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const Vec3 in_wrist = wrist_from_hand * skin.vertices[i];
    if (std::abs(in_wrist.x() - 0.004) < 0.012) {
      wrist_width_m_ = std::max(wrist_width_m_, std::abs(in_wrist.y()));
      wrist_depth_m_ = std::max(wrist_depth_m_, std::abs(in_wrist.z()));
    }
    double redness = 0;  // knuckles and finger tips
    for (const Joint& joint : hand.joints) {
      const bool red = joint.name.ends_with("tip") || joint.name.ends_with("proximal") ||
                       joint.name.ends_with("intermediate");
      const double distance_m =
          (skin.vertices[i] - options.hand_scale * joint.hand_from_joint_rest.translation()).norm();
      if (red) redness = std::max(redness, std::exp(-std::pow(distance_m / 0.013, 2)));
    }
    const double palm = std::clamp(0.5 - 1.2 * (wrist_from_hand.linear() * normals[i]).z(), 0., 1.);
    const Vec3 tint = (1 + palm * (paler - 1)) * (Vec3(1, 1, 1) - redness * Vec3(0.03, 0.17, 0.15));
    mesh_.positions.push_back(skin.vertices[i].cast<float>());
    mesh_.normals.push_back(normals[i].cast<float>());
    mesh_.texture.push_back(skin.vertices[i].cast<float>());
    mesh_.tint.push_back(tint.cast<float>());
    mesh_.open.push_back(static_cast<float>(open[i]));
  }
  if (wrist_width_m_ == 0) wrist_width_m_ = 0.029, wrist_depth_m_ = 0.02;
  for (const auto& triangle : skin.triangles) {
    mesh_.triangles.push_back({static_cast<std::uint32_t>(triangle[0]),
                               static_cast<std::uint32_t>(triangle[1]),
                               static_cast<std::uint32_t>(triangle[2])});
    mesh_.materials.push_back(Material::kHandSkin);
  }
  endPart(mesh_, Bone::kHand);
  for (const Joint& joint : hand.joints) {
    if (joint.parent < 0) continue;
    const bool palm = joint.name.ends_with("proximal") || joint.name.ends_with("metacarpal");
    const double radius_m = options.hand_scale * (palm ? 0.014 : 0.0085);
    const Vec3 to = options.hand_scale * joint.hand_from_joint_rest.translation();
    const Vec3 from = options.hand_scale *
                      hand.joints[static_cast<std::size_t>(joint.parent)].hand_from_joint_rest.translation();
    addBalls(Bone::kHand, from, to, radius_m, radius_m);
  }
}

void Person::addForearm(const RoomOptions& options) {
  const double width = 0.95 * wrist_width_m_, depth = 0.95 * wrist_depth_m_;
  const std::vector<Ring> limb = {{-kForearm, 0.044, 0.042},
                                  {-0.19, 0.046, 0.042},
                                  {-0.07, 1.06 * width, 1.08 * depth},
                                  {-0.002, width, depth}};
  const bool sleeve = options.arm == Arm::kSleeve;
  const double cuff = -std::clamp(options.sleeve_from_wrist_m, 0.0, 0.9 * kForearm);
  std::vector<Ring> bare = limb;
  if (sleeve)
    bare = {between(limb, std::max(cuff - 0.03, -kForearm)), between(limb, 0.5 * cuff), limb.back()};
  addLoft(mesh_, Bone::kForearm, Material::kSkin, Pose::Identity(), bare, sleeve ? 0.01 : 0.008);
  if (sleeve) {
    Ring end = between(limb, cuff);
    end.y += 0.007;
    end.z += 0.009;
    addLoft(mesh_, Bone::kForearm, Material::kShirt, Pose::Identity(),
            {{-kForearm, 0.050, 0.050}, {0.5 * (cuff - kForearm), 0.052, 0.050}, end}, 0.003);
  }
  addLoft(mesh_, Bone::kForearm, sleeve ? Material::kShirt : Material::kSkin, Pose::Identity(),
          {{-kForearm - 0.005, sleeve ? 0.05 : 0.041, sleeve ? 0.05 : 0.039},
           {-kForearm + 0.005, sleeve ? 0.05 : 0.042, sleeve ? 0.05 : 0.040}},
          0.042);  // the elbow
  addBalls(Bone::kForearm, {-kForearm, 0, 0}, Vec3::Zero(), 0.044, depth);
}

void Person::addBody(Bone torso, Bone head) {
  const double neck = (kNeck - kHip).norm();
  const Pose straight = Pose::Identity();
  addLoft(mesh_, torso, Material::kShirt, straight,
          {{-0.06, 0.175, 0.140},
           {0.18, 0.160, 0.125},
           {0.42, 0.175, 0.125},
           {0.56, 0.180, 0.105},
           {0.64, 0.150, 0.085},
           {neck - 0.01, 0.065, 0.065}},
          0.03);
  addBalls(torso, {0.05, 0, 0}, {0.60, 0, 0}, 0.15, 0.14);
  addLoft(mesh_, head, Material::kSkin, straight, {{-0.10, 0.060, 0.060}, {0.06, 0.056, 0.058}}, 0.02);
  Pose face = Pose::Identity();
  face.translation() = Vec3(0.14, 0, 0.025);
  addLoft(mesh_, head, Material::kSkin, face, {{-0.02, 0.070, 0.088}, {0.02, 0.075, 0.092}}, 0.10);
  Pose hair = Pose::Identity();
  hair.linear() = Eigen::AngleAxisd(-0.5, Vec3::UnitY()).toRotationMatrix();  // low at the neck
  hair.translation() = Vec3(0.168, 0, 0.002);
  addLoft(mesh_, head, Material::kHair, hair, {{-0.02, 0.080, 0.092}, {0.02, 0.080, 0.092}}, 0.072);
  addBalls(head, {0.14, 0, 0.02}, {0.16, 0, 0.02}, 0.1, 0.1);
}

/// An arm that rests on the lap, or in front of the body.
void Person::addRestingArm(Bone torso, double side) {
  const Vec3 shoulder((kNeck - kHip).norm() + kShoulderFromNeck.z(), side * kShoulderFromNeck.x(), 0);
  const Vec3 elbow = shoulder + Vec3(-0.29, 0.07 * side, 0.05),
             wrist = elbow + Vec3(-0.07, -0.10 * side, 0.22);
  addLoft(mesh_, torso, Material::kShirt, frameAt(elbow, elbow - shoulder, Vec3::UnitZ()),
          {{-(elbow - shoulder).norm(), 0.062, 0.060}, {0, 0.048, 0.048}}, 0.044);
  addLoft(mesh_, torso, Material::kShirt, frameAt(wrist, wrist - elbow, Vec3::UnitX()),
          {{-(wrist - elbow).norm(), 0.049, 0.049}, {0, 0.036, 0.032}}, 0.02);
}

void Person::addBalls(Bone bone, const Vec3& from, const Vec3& to, double radius_from, double radius_to) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil((to - from).norm() / (1.2 * std::min(radius_from, radius_to)))));
  for (int step = 1; step <= steps; ++step) {
    const double t = static_cast<double>(step) / steps;
    balls_.push_back({bone, from + t * (to - from), radius_from + t * (radius_to - radius_from)});
  }
}

Pose Person::sided(const Pose& room_from_wrist) const {
  if (side_ > 0) return room_from_wrist;
  const Eigen::DiagonalMatrix<double, 3> room_mirror(-1, 1, 1), wrist_mirror(1, -1, 1);
  Pose mirrored = Pose::Identity();
  mirrored.linear() = room_mirror * room_from_wrist.linear() * wrist_mirror;
  mirrored.translation() = room_mirror * room_from_wrist.translation();
  return mirrored;
}

ArmJoints armJoints(const Pose& room_from_wrist, double side) {
  const Vec3 wrist = room_from_wrist.translation();
  const Vec3 upright = kNeck + Vec3(side, 1, 1).cwiseProduct(kShoulderFromNeck);
  const Vec3 ahead = (wrist - upright).normalized();
  const Vec3 lean = softExcess((wrist - upright).norm(), 0.9 * (kUpperArm + kForearm)) * ahead;
  const Vec3 shoulder = upright + lean, to_wrist = wrist - shoulder, axis = to_wrist.normalized();
  const double reach = to_wrist.norm();
  const double along = (kUpperArm * kUpperArm - kForearm * kForearm + reach * reach) / (2 * reach);
  const double radius = std::sqrt(std::max(kUpperArm * kUpperArm - along * along, 1e-6));
  const Vec3 center = shoulder + along * axis;
  // The elbow is on a circle about the axis: outwards and down, and rather behind the hand; that has less
  // weight, so that the elbow never turns over.
  const Vec3 behind = wrist - kForearm * room_from_wrist.linear().col(0) - center;
  Vec3 towards = 0.5 * behind + Vec3(0.20 * side, 0, -0.12);
  towards = (towards - axis * axis.dot(towards)).normalized();
  const double lowest = (kDeskZ + 0.06 - center.z()) / radius;
  return {shoulder, center + radius * aboveDesk(towards, axis, lowest), lean};
}

BonePoses Person::poses(const Pose& room_from_wrist, double time_s) const {
  const Vec3 wrist = room_from_wrist.translation();
  const auto [shoulder, elbow, lean] = armJoints(room_from_wrist, side_);
  BonePoses poses;
  const auto at = [&](Bone bone) -> Pose& { return poses[static_cast<std::size_t>(bone)]; };
  at(Bone::kHand) = room_from_wrist * hand_from_wrist_.inverse();
  at(Bone::kForearm) = frameAt(wrist, wrist - elbow, room_from_wrist.linear().col(2));
  at(Bone::kUpperArm) = frameAt(elbow, elbow - shoulder, (elbow - shoulder).cross(wrist - elbow));
  const Vec3 neck = kNeck + lean;
  at(Bone::kTorso) = frameAt(kHip, neck - kHip, Vec3::UnitY());
  const Vec3 up = Vec3(0, 0.25, 1) + 0.5 * (neck - kHip).normalized();
  at(Bone::kHead) = frameAt(neck, up, Vec3::UnitY());
  // The second person walks back and forth next to the desk and looks at it.
  const Vec3 hip(-1.2, 0.1 + 0.25 * std::sin(1.7 * time_s), -0.35), ahead = Vec3::UnitX();
  const Vec3 spine = Vec3(0.15, 0.05 * std::sin(3.4 * time_s), 1).normalized();
  at(Bone::kSecondTorso) = frameAt(hip, spine, ahead);
  at(Bone::kSecondHead) = frameAt(hip + (kNeck - kHip).norm() * spine, Vec3::UnitZ() + spine, ahead);
  return poses;
}

}  // namespace airclay
