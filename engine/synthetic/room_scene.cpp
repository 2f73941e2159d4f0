// SPDX-License-Identifier: MIT
#include "engine/synthetic/room_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airclay {
namespace {

constexpr double kDeskLeft = -0.85, kDeskRight = 0.85, kDeskFront = -0.52, kDeskBack = 0.80,
                 kDeskThick = 0.03;
constexpr double kFloorZ = kDeskZ - 0.72, kCeilingZ = 1.8, kWallX = 2.3, kWallFront = -2.4, kWallBack = 2.2;
const Vec3 kBoxHalf(0.12, 0.085, 0.022);
constexpr double kCupRadius = 0.04, kCupHeight = 0.095;
/// The window's half angle as seen from the desk: 60 cm at 2 m.
constexpr double kWindowTan = 0.15;
constexpr double kShadowCell = 0.0125;

enum Surface { kDeskTop, kDeskSide, kFloorSurface, kWallSurface, kBoxSurface, kCupSurface };

/// The distance at which a ray enters a box about the origin; its face's normal. Infinite: not at all.
double enterBox(const Vec3& eye, const Vec3& direction, const Vec3& half, Vec3& normal) {
  double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
  int axis = 0;
  for (int k = 0; k < 3; ++k) {
    const double a = (-half[k] - eye[k]) / direction[k], b = (half[k] - eye[k]) / direction[k];
    if (std::min(a, b) > enter) enter = std::min(a, b), axis = k;
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter < leave) || enter <= 0) return std::numeric_limits<double>::infinity();
  normal = Vec3::Zero();
  normal[axis] = direction[axis] > 0 ? -1 : 1;
  return enter;
}

/// The rays through every eighth pixel; interpolated between them, since the lens is smooth.
class RayGrid {
 public:
  explicit RayGrid(const Camera& camera) : columns_((camera.width + 2 * kStep - 1) / kStep + 1) {
    for (int y = 0; y <= (camera.height + 2 * kStep - 1) / kStep; ++y)
      for (int x = 0; x < columns_; ++x)
        rays_.push_back(rayThroughPixel(camera.lens, Vec2(x * kStep - 1, y * kStep - 1)));
  }
  /// A unit vector in the camera's frame. \pre in the image
  std::optional<Vec3> through(const Vec2& pixel) const {
    const double x = (pixel.x() + 1) / kStep, y = (pixel.y() + 1) / kStep;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const double s = x - column, t = y - row;
    const auto* at = &rays_[static_cast<std::size_t>(row * columns_ + column)];
    if (!at[0] || !at[1] || !at[columns_] || !at[columns_ + 1]) return std::nullopt;
    const Vec3 ray =
        (1 - t) * ((1 - s) * *at[0] + s * *at[1]) + t * ((1 - s) * *at[columns_] + s * *at[columns_ + 1]);
    return ray.normalized();
  }

 private:
  static constexpr int kStep = 8;
  int columns_;
  std::vector<std::optional<Vec3>> rays_;
};

/// The fraction of a disc of radius `a` that a disc of radius `b` covers at a distance of their centres;
/// smooth.
double covered(double a, double b, double distance) {
  const double full = std::min(1.0, b * b / (a * a));
  const double t = std::clamp((a + b - distance) / (a + b - std::abs(a - b) + 1e-9), 0., 1.);
  return full * t * t * (3 - 2 * t);
}

/// How much of the ambient light and of the window's a ball takes from a surface that faces up.
Eigen::Vector2d blocked(const Vec3& point, const Vec3& center, double radius, const Vec3& to_window) {
  const Vec3 away = center - point;
  const double square = std::max(away.squaredNorm(), radius * radius), along = away.dot(to_window);
  const double ambient = std::max(0., away.z()) / std::sqrt(square) * radius * radius / square;
  double window = 0;
  if (along > 0)
    window = covered(along * kWindowTan, radius, std::sqrt(std::max(0., away.squaredNorm() - along * along)));
  return {std::min(0.9 * ambient, 0.9), window};
}

}  // namespace

DeskShadow::DeskShadow()
    : columns_(static_cast<int>((kDeskRight - kDeskLeft) / kShadowCell) + 1),
      rows_(static_cast<int>((kDeskBack - kDeskFront) / kShadowCell) + 1),
      cells_(static_cast<std::size_t>(columns_ * rows_), Eigen::Vector2f::Ones()) {}

void DeskShadow::add(const Vec3& center, double radius, const Vec3& to_window) {
  const double height = center.z() - kDeskZ;
  if (height < 0) return;
  // Where the window's shadow is, and where the ambient one is above 0.4 %.
  const Vec2 window = (center - height / to_window.z() * to_window).head<2>();
  const double window_reach = (radius + height / to_window.z() * kWindowTan) / to_window.z(),
               ambient_reach = 12 * radius;
  const Vec2 low =
      (window - Vec2::Constant(window_reach)).cwiseMin(center.head<2>() - Vec2::Constant(ambient_reach));
  const Vec2 high =
      (window + Vec2::Constant(window_reach)).cwiseMax(center.head<2>() + Vec2::Constant(ambient_reach));
  const auto cell = [](double place, double start, int count) {
    return static_cast<int>(std::clamp((place - start) / kShadowCell, 0., count - 1.));
  };
  for (int row = cell(low.y(), kDeskFront, rows_); row <= cell(high.y(), kDeskFront, rows_); ++row)
    for (int column = cell(low.x(), kDeskLeft, columns_); column <= cell(high.x(), kDeskLeft, columns_);
         ++column) {
      const Vec3 point(kDeskLeft + column * kShadowCell, kDeskFront + row * kShadowCell, kDeskZ);
      const Eigen::Vector2d dark = blocked(point, center, radius, to_window);
      Eigen::Vector2f& light = cells_[static_cast<std::size_t>(row * columns_ + column)];
      light = light.cwiseProduct((Eigen::Vector2d::Ones() - dark).cast<float>());
    }
}

Eigen::Vector2f DeskShadow::at(const Eigen::Vector2f& on_desk) const {
  const float x = (on_desk.x() - static_cast<float>(kDeskLeft)) / static_cast<float>(kShadowCell);
  const float y = (on_desk.y() - static_cast<float>(kDeskFront)) / static_cast<float>(kShadowCell);
  const int column = std::clamp(static_cast<int>(x), 0, columns_ - 2),
            row = std::clamp(static_cast<int>(y), 0, rows_ - 2);
  const float s = x - static_cast<float>(column), t = y - static_cast<float>(row);
  const auto* cell = &cells_[static_cast<std::size_t>(row * columns_ + column)];
  return (1 - t) * ((1 - s) * cell[0] + s * cell[1]) +
         t * ((1 - s) * cell[columns_] + s * cell[columns_ + 1]);
}

RoomScene::RoomScene(const RoomOptions& options) : desk_(options.desk), noise_(options.seed + 100) {
  Random random(options.seed + 200);
  const double azimuth = random.uniform(0.3, 2.8),
               elevation = random.uniform(0.8, 1.05);  // not from behind the person
  to_window_ = Vec3(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                    std::sin(elevation));
  const double warmth = random.uniform(-0.03, 0.03);
  wood_light_ = linearFromSrgb({0.86 + warmth, 0.68, 0.50 - warmth});
  wood_dark_ = linearFromSrgb({0.70 + warmth, 0.51, 0.35 - warmth});
  if (desk_ == Desk::kCloth)
    wood_light_ = linearFromSrgb({0.30, 0.44, 0.46}), wood_dark_ = linearFromSrgb({0.22, 0.35, 0.37});
  wall_ =
      linearFromSrgb({random.uniform(0.55, 0.75), random.uniform(0.55, 0.72), random.uniform(0.58, 0.76)});
  floor_ = linearFromSrgb(Vec3::Constant(random.uniform(0.3, 0.45)));
  const auto vivid = [&] {
    Vec3 color(random.uniform(0.15, 0.85), random.uniform(0.15, 0.85), random.uniform(0.15, 0.85));
    return linearFromSrgb(color);
  };
  box_ = linearFromSrgb({random.uniform(0.15, 0.4), random.uniform(0.55, 0.8), random.uniform(0.5, 0.75)});
  poster_a_ = vivid();
  poster_b_ = vivid();
  turn_ = random.uniform(-0.3, 0.3);
  room_from_box_.linear() = Eigen::AngleAxisd(random.uniform(-0.6, 0.6), Vec3::UnitZ()).toRotationMatrix();
  room_from_box_.translation() =
      Vec3(random.uniform(0.45, 0.6), random.uniform(0.15, 0.5), kDeskZ + kBoxHalf.z());
  cup_ = Vec3(random.uniform(-0.6, -0.45), random.uniform(0.1, 0.5), kDeskZ);
}

RoomScene::Hit RoomScene::trace(const Vec3& eye, const Vec3& direction) const {
  Hit hit{std::numeric_limits<double>::infinity(), {}, {}, kWallSurface};
  const auto take = [&](double distance, const Vec3& normal, int surface) {
    if (distance > 0 && distance < hit.distance_m)
      hit = {distance, eye + distance * direction, normal, surface};
  };
  const auto plane = [&](int axis, double place, double facing, int surface) {
    if (direction[axis] * facing < 0)
      take((place - eye[axis]) / direction[axis], facing * Vec3::Unit(axis), surface);
  };
  plane(2, kFloorZ, 1, kFloorSurface);
  plane(2, kCeilingZ, -1, kWallSurface);
  plane(0, -kWallX, 1, kWallSurface);
  plane(0, kWallX, -1, kWallSurface);
  plane(1, kWallFront, 1, kWallSurface);
  plane(1, kWallBack, -1, kWallSurface);

  Vec3 normal;
  const Vec3 desk_half(0.5 * (kDeskRight - kDeskLeft), 0.5 * (kDeskBack - kDeskFront), 0.5 * kDeskThick);
  const Vec3 desk_center(0.5 * (kDeskRight + kDeskLeft), 0.5 * (kDeskBack + kDeskFront),
                         kDeskZ - 0.5 * kDeskThick);
  const double desk = enterBox(eye - desk_center, direction, desk_half, normal);
  if (std::isfinite(desk)) take(desk, normal, normal.z() > 0 ? kDeskTop : kDeskSide);
  const Mat3 box_from_room = room_from_box_.linear().transpose();
  const double box = enterBox(box_from_room * (eye - room_from_box_.translation()), box_from_room * direction,
                              kBoxHalf, normal);
  if (std::isfinite(box)) take(box, room_from_box_.linear() * normal, kBoxSurface);

  // the cup: a cylinder with a flat top
  const Vec2 to_eye = (eye - cup_).head<2>(), step = direction.head<2>();
  const double a = step.squaredNorm(), b = to_eye.dot(step),
               c = to_eye.squaredNorm() - kCupRadius * kCupRadius;
  if (const double root = b * b - a * c; root > 0) {
    const double side = (-b - std::sqrt(root)) / a, top = (kDeskZ + kCupHeight - eye.z()) / direction.z();
    const Vec3 at_side = eye + side * direction, at_top = eye + top * direction;
    if (at_side.z() > kDeskZ && at_side.z() < kDeskZ + kCupHeight) {
      const Vec2 out = (at_side - cup_).head<2>() / kCupRadius;
      take(side, {out.x(), out.y(), 0}, kCupSurface);
    }
    if (direction.z() < 0 && (at_top - cup_).head<2>().norm() < kCupRadius)
      take(top, Vec3::UnitZ(), kCupSurface);
  }
  return hit;
}

Vec3f RoomScene::albedo(const Hit& hit) const {
  const Vec3f p = hit.point.cast<float>();
  const float fine = noise_.smooth(p * 400), coarse = noise_.smooth(p * 35);
  switch (hit.surface) {
    case kDeskTop:
    case kDeskSide: {
      if (desk_ == Desk::kCloth)
        return (0.85f + 0.3f * fine) * (wood_dark_ + coarse * (wood_light_ - wood_dark_));
      // planks of 14 cm along the grain, each shifted; rings are where a noisy field crosses levels
      const auto c = static_cast<float>(std::cos(turn_)), s = static_cast<float>(std::sin(turn_));
      const float along = c * p.x() + s * p.y(), across = c * p.y() - s * p.x();
      const float plank = static_cast<float>(floorOf(across / 0.14f));
      const float bend = noise_.smooth({along * 9 + plank * 17, across * 40, plank * 5});
      const float ring = 0.5f + 0.5f * std::sin(across * 420 + 16 * bend);
      const float grain = noise_.smooth({along * 60 + plank * 29, across * 900, 3});
      const float dark =
          std::clamp(0.55f * ring * ring + 0.5f * grain + 0.25f * (coarse - 0.5f) - 0.1f, 0.f, 1.f);
      const float gap = std::abs(across / 0.14f - plank - 0.5f) > 0.494f ? 0.6f : 1.f;
      return gap * (0.94f + 0.12f * noise_.nearest({plank, 7, 9})) *
             (wood_light_ + dark * (wood_dark_ - wood_light_));
    }
    case kFloorSurface:
      return (0.6f + 0.5f * coarse + 0.3f * fine) * floor_;
    case kBoxSurface:
      return (0.92f + 0.16f * fine) * box_;
    case kCupSurface: {
      const bool band = hit.normal.z() == 0 && std::abs(hit.point.z() - kDeskZ - 0.05) < 0.012;
      return band ? poster_b_ : Vec3f(Vec3f::Constant(0.72f + 0.06f * fine));
    }
    default: {
      // a poster on every wall
      const double sideways = std::abs(hit.normal.x()) > 0.5 ? hit.point.y() : hit.point.x();
      const double height = hit.point.z();
      if (hit.normal.z() == 0 && std::abs(sideways - 0.5) < 0.45 && std::abs(height - 0.62) < 0.35) {
        const bool odd =
            (static_cast<int>(std::floor(sideways / 0.09)) + static_cast<int>(std::floor(height / 0.09))) & 1;
        return odd ? poster_a_ : poster_b_;
      }
      return (0.86f + 0.2f * noise_.smooth(p * 9) + 0.12f * (noise_.smooth(p * 130) - 0.5f)) * wall_;
    }
  }
}

RoomView RoomScene::view(const Camera& camera) const {
  const std::size_t count = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  RoomView view;
  view.ambient.assign(count, Vec3f::Zero());
  view.window.assign(count, Vec3f::Zero());
  view.desk.assign(count, Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (std::vector<float>& depth : view.depth_m) depth.assign(count, std::numeric_limits<float>::infinity());
  const RayGrid rays(camera);
  const Pose room_from_camera = camera.camera_from_world.inverse();
  const Vec3 eye = room_from_camera.translation();
  const std::array<std::pair<Vec3, double>, 3> objects = {{{cup_ + Vec3(0, 0, 0.04), 0.045},
                                                           {room_from_box_ * Vec3(0.06, 0, 0), 0.06},
                                                           {room_from_box_ * Vec3(-0.06, 0, 0), 0.06}}};
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i % static_cast<std::size_t>(camera.width));
    const double y = static_cast<double>(i / static_cast<std::size_t>(camera.width));
    bool all_desk = true;
    Vec2 desk = Vec2::Zero();
    for (std::size_t quadrant = 0; quadrant < 4; ++quadrant) {
      const Vec2 pixel(x + (quadrant & 1 ? 0.25 : -0.25), y + (quadrant & 2 ? 0.25 : -0.25));
      const std::optional<Vec3> ray = rays.through(pixel);
      if (!ray) {
        all_desk = false;
        continue;
      }
      const Hit hit = trace(eye, room_from_camera.linear() * *ray);
      Vec2 light(kAmbientLight * (0.62 + 0.38 * hit.normal.z()),
                 kWindowLight * std::max(0., hit.normal.dot(to_window_)));
      if (hit.surface == kDeskTop)
        for (const auto& [center, radius] : objects)
          light = light.cwiseProduct(Vec2::Ones() - blocked(hit.point, center, radius, to_window_));
      if (hit.surface == kFloorSurface) light *= 0.7;
      const Vec3f color = 0.25f * albedo(hit);
      view.ambient[i] += static_cast<float>(light.x()) * color;
      view.window[i] += static_cast<float>(light.y()) * color;
      view.depth_m[quadrant][i] = static_cast<float>(hit.distance_m * ray->z());
      all_desk = all_desk && hit.surface == kDeskTop;
      desk += 0.25 * hit.point.head<2>();
    }
    if (all_desk) view.desk[i] = desk.cast<float>();
  }
  return view;
}

}  // namespace airclay
