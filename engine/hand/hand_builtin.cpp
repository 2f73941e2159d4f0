// SPDX-License-Identifier: MIT
// The built-in hand: a skeleton with published dimensions and a smooth implicit skin.
//
// Lengths: Buryanov and Kotiuk 2010, "Proportions of Hand Segments", Int. J. Morphol. 28(3):755-758,
// https://doi.org/10.4067/S0717-95022010000300015. Breadths and depths are our own round values for an adult:
// wrist 60 x 39, hand breadth about 90, middle joints 20, end joints 17, thumb 22 mm (for tables of such
// dimensions see Vergara, Agost and Gracia-Ibanez 2018, "Dorsal and palmar aspect dimensions of hand
// anthropometry").
//
// The skin is a smooth union, by the polynomial minimum (Quilez, "Smooth minimum"), of lofts: bodies with an
// elliptic section that varies along an axis and is flatter on the back than on the palm. This file uses
// millimetres, like the sources.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/hand/hand_model.h"
#include "engine/mesh/surface_nets.h"

namespace airclay {
namespace {

constexpr double kMetresPerMm = 1e-3;
constexpr double kCutX = -13;  // the skin ends behind the crease of the wrist; the wrist joint is at 0

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// The direction at `azimuth` from x towards y and `elevation` from there towards z, in degrees.
Vec3 direction(double azimuth, double elevation) {
  const double a = radians(azimuth), e = radians(elevation);
  return {std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)};
}

/// min(a, b), rounded where they differ by less than `radius`.
double smoothMin(double a, double b, double radius) {
  const double h = std::max(radius - std::abs(a - b), 0.) / radius;
  return std::min(a, b) - h * h * radius / 4;
}

double smoothStep(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0., 1.);
  return t * t * (3 - 2 * t);
}

// ---------------------------------------------------------------------------------------------------------------------
// Lofts

/// A section at `u` along a loft's axis: its centre's offset from the axis (v to the thumb side, w to the
/// back), and its semi-axes to the sides, the back and the palm.
struct Section {
  double u, v, w, side, back, palm;
};

/// A frame in the hand: x along `along`, z towards `back`.
Pose frameAlong(const Vec3& origin, const Vec3& along, const Vec3& back) {
  Pose frame = Pose::Identity();
  const Vec3 x = along.normalized(), z = (back - x * x.dot(back)).normalized();
  frame.linear() << x, z.cross(x), z;
  frame.translation() = origin;
  return frame;
}

class Loft {
 public:
  /// Sections in ascending order; the body ends in half ellipsoids of the given lengths. `arch` (1/mm) bends
  /// the section's edges towards the palm.
  Loft(const Pose& hand_from_loft, const std::vector<Section>& sections, double start_cap, double end_cap,
       double arch = 0)
      : loft_from_hand_(hand_from_loft.inverse()),
        start_(sections.front().u),
        end_(sections.back().u),
        start_cap_(start_cap),
        end_cap_(end_cap),
        arch_(arch) {
    const int steps = int(std::ceil(end_ - start_)) + 1;
    for (int i = 0; i <= steps; ++i) table_.push_back(interpolate(sections, start_ + i));
  }

  /// Approximately the distance near the surface; farther away, only sign and order are correct.
  double distance(const Vec3& point_in_hand) const {
    const Vec3 q = loft_from_hand_ * point_in_hand;
    const double u = std::clamp(q.x(), start_, end_);
    const double place = u - start_;
    const size_t i = size_t(place);
    const double t = place - double(i);
    const auto mix = [t](double a, double b) { return a + t * (b - a); };
    const Section &a = table_[i], &b = table_[i + 1];
    const double v = q.y() - mix(a.v, b.v);
    const double w = q.z() - mix(a.w, b.w) + arch_ * v * v;
    const double side = mix(a.side, b.side);
    const double depth = w > 0 ? mix(a.back, b.back) : mix(a.palm, b.palm);
    const double cap = q.x() < start_ ? start_cap_ : end_cap_;
    // First-order approximation for an ellipsoid: k0 = |x / r|, k1 = |x / r²|.
    const Vec3 scaled((q.x() - u) / cap, v / side, w / depth);
    const double k0 = scaled.norm();
    const double k1 = Vec3(scaled.x() / cap, scaled.y() / side, scaled.z() / depth).norm();
    return k0 < 0.1 ? -0.9 * std::min(side, depth) : k0 * (k0 - 1) / k1;
  }

 private:
  /// Monotone piecewise cubic interpolation (Fritsch and Carlson 1980, harmonic means of the slopes).
  static Section interpolate(const std::vector<Section>& sections, double u) {
    size_t i = 0;
    while (i + 2 < sections.size() && sections[i + 1].u < u) ++i;
    const auto column = [&](double Section::*value) {
      const auto slope = [&](size_t k) {
        return (sections[k + 1].*value - sections[k].*value) / (sections[k + 1].u - sections[k].u);
      };
      const auto tangent = [&](size_t k) {
        if (k == 0 || k + 1 == sections.size()) return 0.;  // zero slope at the caps
        const double before = slope(k - 1), after = slope(k);
        return before * after > 0 ? 2 * before * after / (before + after) : 0.;
      };
      const double width = sections[i + 1].u - sections[i].u;
      const double t = std::clamp((u - sections[i].u) / width, 0., 1.), s = 1 - t;
      return s * s * (1 + 2 * t) * sections[i].*value + t * t * (1 + 2 * s) * sections[i + 1].*value +
             s * t * width * (s * tangent(i) - t * tangent(i + 1));
    };
    return {u,
            column(&Section::v),
            column(&Section::w),
            column(&Section::side),
            column(&Section::back),
            column(&Section::palm)};
  }

  Pose loft_from_hand_;
  double start_, end_, start_cap_, end_cap_, arch_;
  std::vector<Section> table_;  // 1 mm apart
};

// ---------------------------------------------------------------------------------------------------------------------
// The skeleton

/// A finger's base, bone lengths and directions. Angles in degrees, see direction().
struct Ray {
  Vec3 base;  // of the metacarpal
  std::array<double, 5>
      lengths;  // metacarpal, proximal, middle, distal, soft tip; the thumb has no middle phalanx
  double metacarpal_azimuth, metacarpal_elevation;
  double finger_azimuth, finger_elevation;
  double curl;                         // flexion at each joint after the knuckle, as of a hand at rest
  double middle_breadth, end_breadth;  // at the joints
};

// Bases and angles of a flat hand: the knuckles form an arch that descends towards the little finger, 90 mm
// wide; the middle finger is along x, with its tip 190 mm from the wrist.
const std::array<Ray, 4> kFingers = {{
    {{28, 14, -1.5}, {68.12, 39.78, 22.38, 15.82, 3.84}, 9.7, -0.5, 6.5, -3, 2.5, 20, 17},
    {{33, 3.5, 0}, {64.60, 44.63, 26.33, 17.40, 3.95}, 0.3, 0, -2.2, -2.5, 2.5, 20, 17},
    {{30.5, -6.5, -1}, {58.00, 41.37, 25.65, 17.30, 3.95}, -10.5, -1.5, -9, -3, 2.5, 19, 16.5},
    {{26, -15, -3}, {53.69, 32.74, 18.11, 15.96, 3.73}, -24, -4, -20, -3, 2.5, 17, 14.5},
}};
const Ray kThumb = {{17, 20, -8}, {46.22, 31.57, 0, 21.67, 5.67}, 41, -22, 33, -16, 0, 22, 21};

/// Metacarpal base, knuckle, middle joint, end joint, tip; the thumb has no middle joint.
std::vector<Vec3> jointsOf(const Ray& ray) {
  std::vector<Vec3> joints{ray.base};
  joints.push_back(joints.back() +
                   ray.lengths[0] * direction(ray.metacarpal_azimuth, ray.metacarpal_elevation));
  double elevation = ray.finger_elevation, azimuth = ray.finger_azimuth;
  for (size_t bone = 1; bone <= 3; ++bone) {
    if (ray.lengths[bone] == 0) {
      azimuth -= 7;  // the end of the thumb points inwards
      continue;
    }
    const double length = ray.lengths[bone] + (bone == 3 ? ray.lengths[4] : 0);
    joints.push_back(joints.back() + length * direction(azimuth, elevation));
    elevation -= ray.curl;
  }
  return joints;
}

const Vec3 kBack(0, 0, 1);
const Vec3 kThumbBack = Vec3(-0.25, 0.70, 0.66);  // direction of the thumbnail, halfway to the side

// ---------------------------------------------------------------------------------------------------------------------
// The skin

/// A joint's position along a loft's axis and its offset from it.
Section sectionAt(const Pose& hand_from_loft, const Vec3& joint, double side, double back, double palm) {
  const Vec3 place = hand_from_loft.inverse() * joint;
  return {place.x(), place.y(), place.z(), side, back, palm};
}

/// A finger from its knuckle to its tip.
Loft fingerLoft(const Ray& ray) {
  const std::vector<Vec3> joints = jointsOf(ray);
  const Pose frame = frameAlong(joints[1], joints[4] - joints[1], kBack);
  const double p = ray.middle_breadth / 2, d = ray.end_breadth / 2;
  const auto between = [&](int bone, double fraction) {
    return Vec3(joints[bone] + fraction * (joints[bone + 1] - joints[bone]));
  };
  const double tip_cap = 1.08 * d;
  const double tip_share = 1 - tip_cap / (joints[4] - joints[3]).norm();
  return Loft(frame,
              {sectionAt(frame, between(1, 0), 1.06 * p, 0.98 * p, 1.10 * p),
               sectionAt(frame, between(1, 0.35), 1.01 * p, 0.90 * p, 1.02 * p),
               sectionAt(frame, between(1, 0.7), 0.96 * p, 0.82 * p, 0.93 * p),
               sectionAt(frame, between(2, 0), 1.00 * p, 0.87 * p, 0.84 * p),
               sectionAt(frame, between(2, 0.5), 0.47 * (p + d), 0.76 * p, 0.86 * p),
               sectionAt(frame, between(3, 0), d, 0.82 * d, 0.84 * d),
               sectionAt(frame, between(3, tip_share), 0.93 * d, 0.66 * d, 0.84 * d)},
              10, tip_cap);
}

Loft metacarpalLoft(const Ray& ray) {
  const std::vector<Vec3> joints = jointsOf(ray);
  const Pose frame = frameAlong(joints[0], joints[1] - joints[0], kBack);
  const double p = ray.middle_breadth / 2, length = ray.lengths[0];
  return Loft(frame,
              {{0, 0, -2, 0.8 * p, 1.0 * p, 1.0 * p},
               {0.5 * length, 0, -2, 0.9 * p, 0.95 * p, 1.0 * p},
               {length, 0, 0, 1.06 * p, 1.02 * p, 1.15 * p}},
              8, 9);
}

Loft thumbLoft() {
  const std::vector<Vec3> joints = jointsOf(kThumb);
  const Pose frame = frameAlong(joints[1], joints[3] - joints[1], kThumbBack);
  const auto between = [&](int bone, double fraction) {
    return Vec3(joints[bone] + fraction * (joints[bone + 1] - joints[bone]));
  };
  const double tip_cap = 11, tip_share = 1 - tip_cap / (joints[3] - joints[2]).norm();
  return Loft(
      frame,
      {sectionAt(frame, between(1, 0), 11.5, 10.5, 12), sectionAt(frame, between(1, 0.55), 10.2, 9.2, 10.4),
       sectionAt(frame, between(2, 0), 11, 9.3, 9.3), sectionAt(frame, between(2, 0.35), 11.2, 8, 9.8),
       sectionAt(frame, between(2, tip_share), 10.4, 6.2, 9)},
      10, tip_cap);
}

Loft thumbMetacarpalLoft() {
  const std::vector<Vec3> joints = jointsOf(kThumb);
  const Pose frame = frameAlong(joints[0], joints[1] - joints[0], kThumbBack);
  return Loft(frame, {{0, 0, 0, 12, 11, 14}, {24, 0, 0, 12.5, 10.5, 15}, {46, 0, 0, 11.8, 10.5, 12.5}}, 12,
              9);
}

/// Wrist and palm, from behind the cut to the knuckles; the forearm continues the first section.
Loft palmLoft() {
  return Loft(Pose::Identity(),
              {{-40, -1, -1, 30, 19, 20},
               {-10, -1, -1, 29.5, 19, 20},
               {10, -1, -1, 31, 18, 19},
               {35, -3, -1, 36, 15, 17},
               {60, -5, -1, 38, 12.5, 14},
               {78, -4.5, -1, 38, 11, 12}},
              10, 14, 0.002);
}

/// The muscles at the base of the thumb and along the little finger's edge, and the skin between thumb and
/// index finger.
std::vector<Loft> palmMuscles() {
  const std::vector<Vec3> thumb = jointsOf(kThumb);
  const Pose ball = frameAlong({24, 15, -17}, thumb[1] - thumb[0], kThumbBack);
  const Pose edge = frameAlong({18, -21, -9}, direction(-14, 0), kBack);
  const Pose web = frameAlong({34, 30, -9}, direction(24, -7), Vec3(0, 0.35, 1));
  return {Loft(ball, {{0, 0, 0, 12, 12, 13}, {14, 0, 0, 15, 12, 15}, {26, 0, 0, 11, 10, 11}}, 14, 16),
          Loft(edge, {{0, 0, 0, 11, 11, 14}, {18, 0, 0, 13, 11, 14}, {36, 0, 0, 11, 9, 10}}, 14, 18),
          Loft(web, {{0, 0, 0, 12, 8, 9}, {10, 0, 0, 13, 6.5, 8}, {20, 1, 0, 9, 4.5, 6}}, 14, 10)};
}

/// The pad across the palm below the knuckles.
Loft cushion() {
  std::vector<Vec3> places;
  for (const Ray& ray : kFingers) {
    const std::vector<Vec3> joints = jointsOf(ray);
    places.push_back(joints[1] + 0.1 * (joints[2] - joints[1]));
  }
  const Pose frame = frameAlong(places.front(), places.back() - places.front(), kBack);
  std::vector<Section> sections;
  for (const Vec3& place : places) sections.push_back(sectionAt(frame, place - 4 * kBack, 12, 5, 8));
  return Loft(frame, sections, 6, 6);
}

/// The webs between adjacent fingers: short bodies from one to the next, at a third of the first phalanx.
std::vector<Loft> fingerWebs() {
  std::vector<Loft> webs;
  for (size_t f = 0; f + 1 < kFingers.size(); ++f) {
    const auto at = [&](const Ray& ray) {
      const std::vector<Vec3> joints = jointsOf(ray);
      return Vec3(joints[1] + 0.31 * (joints[2] - joints[1]));
    };
    const Vec3 a = at(kFingers[f]), b = at(kFingers[f + 1]);
    const Pose frame = frameAlong(a, b - a, kBack);
    const double length = (b - a).norm();
    webs.push_back(
        Loft(frame, {{0, 0, -1, 8, 5.5, 9.5}, {length / 2, 0, -1.5, 7, 5, 9}, {length, 0, -1, 8, 5.5, 9.5}},
             4, 4));
  }
  return webs;
}

/// The whole hand as an implicit surface, and the distances to its parts.
class HandShape {
 public:
  HandShape() : palm_(palmLoft()), thumb_metacarpal_(thumbMetacarpalLoft()), thumb_(thumbLoft()) {
    for (const Ray& ray : kFingers) {
      metacarpals_.push_back(metacarpalLoft(ray));
      fingers_.push_back(fingerLoft(ray));
    }
    muscles_ = palmMuscles();
    muscles_.push_back(cushion());
    webs_ = fingerWebs();
  }

  /// The distance to a finger; 0 is the thumb.
  double finger(int f, const Vec3& point) const {
    return f == 0 ? thumb_.distance(point) : fingers_[f - 1].distance(point);
  }

  double palm(const Vec3& point) const {
    double nearest = palm_.distance(point);
    for (const Loft& metacarpal : metacarpals_) nearest = smoothMin(nearest, metacarpal.distance(point), 12);
    for (const Loft& web : webs_) nearest = smoothMin(nearest, web.distance(point), 8);
    for (const Loft& muscle : muscles_) nearest = smoothMin(nearest, muscle.distance(point), 14);
    return smoothMin(nearest, thumb_metacarpal_.distance(point), 18);
  }

  double distance(const Vec3& point) const {
    double fingers = fingers_[0].distance(point);
    for (size_t f = 1; f < fingers_.size(); ++f) fingers = smoothMin(fingers, fingers_[f].distance(point), 4);
    const double palm_distance = palm(point);
    const double hand = smoothMin(smoothMin(palm_distance, fingers, 8), thumb_.distance(point), 10);
    return -smoothMin(-hand, point.x() - kCutX, 6);
  }

 private:
  Loft palm_;
  Loft thumb_metacarpal_, thumb_;
  std::vector<Loft> metacarpals_, fingers_, muscles_, webs_;
};

// ---------------------------------------------------------------------------------------------------------------------
// The model

std::vector<Joint> skeleton() {
  std::vector<Joint> joints;
  // WebXR: -z along the bone to the tip, y out of the back.
  const auto add = [&](const Vec3& place, const Vec3& along, const Vec3& back) {
    const int index = int(joints.size());
    const Mat3 frame = frameAlong(place, along, back).linear();
    Joint joint{kJointNames[index], standardParent(index), Pose::Identity()};
    joint.hand_from_joint_rest.linear() << -frame.col(1), frame.col(2), -frame.col(0);
    joint.hand_from_joint_rest.translation() = kMetresPerMm * place;
    joints.push_back(joint);
  };
  add(Vec3::Zero(), Vec3::UnitX(), kBack);
  const auto add_ray = [&](const Ray& ray, const Vec3& back) {
    const std::vector<Vec3> places = jointsOf(ray);
    for (size_t i = 0; i < places.size(); ++i) {
      const size_t from = std::min(i, places.size() - 2);  // the tip has the last bone's orientation
      add(places[i], places[from + 1] - places[from], back);
    }
  };
  add_ray(kThumb, kThumbBack);
  for (const Ray& ray : kFingers) add_ray(ray, kBack);
  return joints;
}

double distanceToSegment(const Vec3& point, const Vec3& a, const Vec3& b) {
  const double t = std::clamp((point - a).dot(b - a) / (b - a).squaredNorm(), 0., 1.);
  return (point - a - t * (b - a)).norm();
}

/// A vertex follows the bones near it, weighted by the inverse sixth power of the distance, so that the
/// transition at a joint is about a finger's breadth wide. Phalanges move only the skin of their own finger.
SkinWeights weightsAt(const Vec3& point, const HandShape& shape, const std::vector<Joint>& joints) {
  const auto place = [&](int j) { return Vec3(joints[j].hand_from_joint_rest.translation() / kMetresPerMm); };
  std::array<double, 6> membership;  // in the five fingers and the palm
  for (int f = 0; f < 5; ++f) membership[f] = 1 - smoothStep(1, 6, shape.finger(f, point));
  membership[5] = std::max(1 - smoothStep(1, 6, shape.palm(point)), 1e-6);
  std::vector<std::pair<double, int>> held;
  for (int j = 0; j < int(joints.size()); ++j) {
    const bool is_wrist = j == 0,
               is_tip = !is_wrist && (j == int(joints.size()) - 1 || joints[j + 1].parent != j);
    if (is_tip) continue;
    const Vec3 from = place(j), to = is_wrist ? Vec3(-40, 0, 0) : place(j + 1);
    const int finger = j < 5 ? 0 : j / 5 - 0;
    const bool is_phalanx = !is_wrist && joints[j].parent != 0;
    const double group = is_phalanx ? membership[j < 5 ? 0 : finger] : membership[5];
    held.emplace_back(group * std::pow(std::max(distanceToSegment(point, from, to), 1.), -6), j);
  }
  std::partial_sort(held.begin(), held.begin() + 4, held.end(), std::greater<>());
  double total = 0;
  for (int i = 0; i < 4; ++i) total += held[i].first;
  SkinWeights weights;
  for (int i = 0; i < 4; ++i) {
    weights.joints[i] = held[i].second;
    weights.weights[i] = held[i].first / total;
  }
  return weights;
}

/// Maps net coordinates so that cells shrink linearly along the hand, from 6 mm at the wrist to 4 mm at the
/// fingertips, which have more curvature.
Vec3 spread(const Vec3& point_in_net) {
  constexpr double kBegin = -19, kLength = 215;
  const double x = point_in_net.x();
  return {kBegin + x * (1.2 - 0.2 * x / kLength), point_in_net.y(), point_in_net.z()};
}

void scaleToMetres(TriangleMesh& mesh) {
  for (Vec3& vertex : mesh.vertices) vertex *= kMetresPerMm;
}

void mirror(TriangleMesh& mesh) {
  for (Vec3& vertex : mesh.vertices) vertex.y() = -vertex.y();
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
}

}  // namespace

HandModel builtInHand(bool left) {
  const HandShape shape;
  HandModel hand;
  hand.name = left ? "left" : "right";
  hand.joints = skeleton();
  const NetGrid grid{{0, -76, -54}, {5, 4.2, 4.2}, {43, 43, 19}};
  hand.skin = surfaceNet([&](const Vec3& point) { return shape.distance(spread(point)); }, grid);
  for (Vec3& vertex : hand.skin.vertices) vertex = spread(vertex);
  for (const Vec3& vertex : hand.skin.vertices) hand.weights.push_back(weightsAt(vertex, shape, hand.joints));
  scaleToMetres(hand.skin);
  if (left) {
    mirror(hand.skin);
    const Eigen::DiagonalMatrix<double, 3> flip(1, -1, 1), turn(-1, 1, 1);
    for (Joint& joint : hand.joints) {  // x is reversed, so that the standard's frame on the mirrored bone
                                        // stays right-handed
      joint.hand_from_joint_rest.linear() = flip * joint.hand_from_joint_rest.linear() * turn;
      joint.hand_from_joint_rest.translation().y() *= -1;
    }
  }
  hand.cut_patches = cutPatches(hand.joints, hand.skin);
  return hand;
}

TriangleMesh builtInForearm(bool left) {
  const Loft forearm(
      Pose::Identity(),
      {{-210, -3, -3, 43, 36, 38},
       {-150, -2, -3, 43, 34, 37},
       {-80, -1, -2, 35, 25, 28},
       {-40, -1, -1, 30.5, 19.5, 21},
       {-14, -1, -1, 29.5, 19, 20},
       {-4, -1, -1, 28.7, 18.3, 19.3}},  // inside the hand, so that there is no visible groove at its edge
      22, 7);
  const NetGrid grid{{-246, -60, -56}, {9, 8, 8}, {29, 15, 14}};
  TriangleMesh mesh = surfaceNet([&](const Vec3& point) { return forearm.distance(point); }, grid);
  scaleToMetres(mesh);
  if (left) mirror(mesh);
  return mesh;
}

}  // namespace airclay
