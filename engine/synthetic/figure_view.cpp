// SPDX-License-Identifier: MIT
#include "engine/synthetic/figure_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airclay {
namespace {

/// Triangles of more columns find the columns inside them row by row.
constexpr int kWide = 8;

}  // namespace

FigureColors::FigureColors(const RoomOptions& options)
    : noise_(options.seed + 300), skin_(linearFromSrgb(options.skin)) {
  Random random(options.seed + 400);
  const Vec3 shirt(random.uniform(0.2, 0.85), random.uniform(0.25, 0.8), random.uniform(0.25, 0.85));
  shirt_ = linearFromSrgb(shirt);
  shirt_stripe_ = linearFromSrgb(random.uniform(0.45, 0.7) * shirt + Vec3::Constant(random.uniform(0, 0.2)));
  hair_ = linearFromSrgb(random.uniform(0.6, 1.4) * Vec3(0.22, 0.16, 0.12));
  pattern_ = static_cast<int>(random.uniform(0, 3));
  stripe_m_ = static_cast<float>(random.uniform(0.012, 0.025));
}

Vec3f FigureColors::albedo(Material material, const Vec3f& texture) const {
  switch (material) {
    case Material::kShirt: {
      const auto odd = [&](float place) { return floorOf(place / stripe_m_) & 1; };
      const bool along = odd(texture.x()), around = odd(texture.y());
      const float stripe = pattern_ == 0   ? along
                           : pattern_ == 1 ? around
                                           : 0.5f * static_cast<float>(along + around);
      return (0.88f + 0.24f * noise_.nearest(texture * 700)) * (shirt_ + stripe * (shirt_stripe_ - shirt_));
    }
    case Material::kHair:
      return (0.5f + noise_.nearest({texture.x() * 150, texture.y() * 900, texture.z() * 900})) * hair_;
    default: {
      // pores and creases, and blotches of blood that take away more green and blue
      const float fine = noise_.nearest(texture * 1500) - 0.5f, blotch = noise_.nearest(texture * 300) - 0.5f;
      return (skin_.array() * (1 + 0.16f * fine) * (1 - Eigen::Array3f(0.06f, 0.26f, 0.26f) * blotch))
          .matrix();
    }
  }
}

FigureView::FigureView(const Camera& camera, const FigureMesh& mesh, const FigureColors& colors)
    : camera_(camera), mesh_(mesh), colors_(colors), screen_(mesh.positions.size()) {
  const std::size_t count = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  depth_m_.assign(count, std::numeric_limits<float>::infinity());
  triangle_.assign(count, 0);
  light_.assign(count, Vec3f::Zero());
  shaded_ = light_;
  shaded_material_.assign(count, Material::kHandSkin);
  figure_samples_.assign(count, 0);
  hand_samples_.assign(count, 0);
}

void FigureView::begin(const std::vector<Vec3f>& light) {
  for (int y = top_; y < bottom_; ++y) {
    const auto row = static_cast<std::ptrdiff_t>(y) * camera_.width;
    std::fill(light_.begin() + row + left_, light_.begin() + row + right_, Vec3f::Zero());
    std::fill(figure_samples_.begin() + row + left_, figure_samples_.begin() + row + right_, 0);
    std::fill(hand_samples_.begin() + row + left_, hand_samples_.begin() + row + right_, 0);
    std::fill(shaded_material_.begin() + row + left_, shaded_material_.begin() + row + right_,
              Material::kHandSkin);
  }
  left_ = camera_.width;
  top_ = camera_.height;
  right_ = bottom_ = 0;
  vertex_light_ = light;
  facing_.clear();
  sample_ = 0;
}

void FigureView::project(const BonePoses& poses) {
  for (const FigureMesh::Part& part : mesh_.parts) {
    const auto bone = static_cast<std::size_t>(part.bone);
    if (projected_[bone] && projected_[bone]->matrix() == poses[bone].matrix()) continue;
    const Pose camera_from_bone = camera_.camera_from_world * poses[bone];
    for (std::uint32_t i = part.first; i < part.first + part.count; ++i) {
      const Vec3 point = camera_from_bone * mesh_.positions[i].cast<double>();
      const std::optional<Vec2> pixel =
          point.z() > 0.05 ? projectThroughLens(camera_.lens, point) : std::nullopt;
      screen_[i] = pixel ? ScreenVertex{static_cast<float>(pixel->x()), static_cast<float>(pixel->y()),
                                        static_cast<float>(point.z())}
                         : ScreenVertex{0, 0, std::numeric_limits<float>::quiet_NaN()};
    }
  }
  for (std::size_t bone = 0; bone < kBones; ++bone) projected_[bone] = poses[bone];
}

void FigureView::chooseFacing() {
  facing_.clear();
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
    const auto& corners = mesh_.triangles[i];
    const ScreenVertex &a = screen_[corners[0]], &b = screen_[corners[1]], &c = screen_[corners[2]];
    if (std::isnan(a.z + b.z + c.z)) continue;
    const float abx = b.x - a.x, aby = b.y - a.y, acx = c.x - a.x, acy = c.y - a.y;
    const float sides = abx * abx + aby * aby + acx * acx + acy * acy;
    if (abx * acy - aby * acx < 0.1f * sides) facing_.push_back(i);
  }
}

void FigureView::drawTriangle(std::uint32_t index, const Vec2& offset, const std::vector<float>& limit_m) {
  const auto& corners = mesh_.triangles[index];
  const ScreenVertex &a = screen_[corners[0]], &b = screen_[corners[1]], &c = screen_[corners[2]];
  const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  // the image's y points down: counterclockwise triangles have a negative area
  if (!(area < 0) || std::isnan(a.z + b.z + c.z)) return;
  const auto ox = static_cast<float>(offset.x()), oy = static_cast<float>(offset.y());
  const auto lowest = [](float p, float q, float r, float o) {
    return -floorOf(std::min(o - std::min(std::min(p, q), r), 0.f));
  };
  const auto past = [](float p, float q, float r, float o, int end) {
    return floorOf(std::clamp(std::max(std::max(p, q), r) - o, -1.f, static_cast<float>(end - 1))) + 1;
  };
  const int x0 = lowest(a.x, b.x, c.x, ox), x1 = past(a.x, b.x, c.x, ox, camera_.width);
  const int y0 = lowest(a.y, b.y, c.y, oy), y1 = past(a.y, b.y, c.y, oy, camera_.height);
  if (x0 >= x1 || y0 >= y1) return;
  left_ = std::min(left_, x0), right_ = std::max(right_, x1);
  top_ = std::min(top_, y0), bottom_ = std::max(bottom_, y1);
  // a sample is a + u (b - a) + v (c - a)
  const float inverse = 1 / area;
  const float u_x = (c.y - a.y) * inverse, u_y = (a.x - c.x) * inverse;
  const float v_x = (a.y - b.y) * inverse, v_y = (b.x - a.x) * inverse;
  for (int y = y0; y < y1; ++y) {
    const float py = static_cast<float>(y) + oy - a.y;
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width);
    int from = x0, to = x1;
    if (x1 - x0 > kWide) {
      // where u, v and 1 - u - v are positive; one pixel more, against rounding
      float low = static_cast<float>(x0), high = static_cast<float>(x1 - 1);
      const auto limit = [&, to_x = a.x - ox](float at_zero, float slope) {
        if (slope > 0) low = std::max(low, to_x - at_zero / slope - 1);
        if (slope < 0) high = std::min(high, to_x - at_zero / slope + 1);
      };
      limit(py * u_y, u_x);
      limit(py * v_y, v_x);
      limit(1 - py * (u_y + v_y), -u_x - v_x);
      if (low > high) continue;
      from = static_cast<int>(low);
      to = static_cast<int>(high) + 1;
    }
    for (int x = from; x < to; ++x) {
      const float px = static_cast<float>(x) + ox - a.x;
      const float u = px * u_x + py * u_y, v = px * v_x + py * v_y;
      if (u < 0 || v < 0 || u + v > 1) continue;
      const float z = a.z + u * (b.z - a.z) + v * (c.z - a.z);
      const std::size_t i = row + static_cast<std::size_t>(x);
      if (z >= depth_m_[i] || z >= limit_m[i]) continue;
      depth_m_[i] = z;
      triangle_[i] = index + 1;
    }
  }
}

void FigureView::shade(const Vec2& offset) {
  // The hand needs every sample; elsewhere, samples within a pixel look alike.
  const bool shades_all = sample_++ % 4 == 0;
  for (int y = top_; y < bottom_; ++y)
    for (int x = left_; x < right_; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(x);
      if (triangle_[i] == 0) continue;
      const std::uint32_t index = triangle_[i] - 1;
      const Material material = mesh_.materials[index];
      const bool is_hand = material == Material::kHandSkin;
      if (shades_all || is_hand || material != shaded_material_[i]) {
        shaded_[i] = lightAt(index, static_cast<float>(x + offset.x()), static_cast<float>(y + offset.y()));
        shaded_material_[i] = material;
      }
      light_[i] += shaded_[i];
      ++figure_samples_[i];
      hand_samples_[i] = static_cast<std::uint8_t>(hand_samples_[i] + is_hand);
      triangle_[i] = 0;
      depth_m_[i] = std::numeric_limits<float>::infinity();
    }
}

Vec3f FigureView::lightAt(std::uint32_t index, float x, float y) const {
  const auto& corners = mesh_.triangles[index];
  const ScreenVertex &a = screen_[corners[0]], &b = screen_[corners[1]], &c = screen_[corners[2]];
  const float inverse = 1 / ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  const float u = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) * inverse;
  const float v = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) * inverse;
  const auto blend = [&](const std::vector<Vec3f>& of) -> Vec3f {
    return (1 - u - v) * of[corners[0]] + u * of[corners[1]] + v * of[corners[2]];
  };
  return blend(vertex_light_).cwiseProduct(colors_.albedo(mesh_.materials[index], blend(mesh_.texture)));
}

void FigureView::addSample(const BonePoses& poses, const Vec2& offset, const std::vector<float>& depth_m) {
  project(poses);
  if (facing_.empty()) chooseFacing();
  for (const std::uint32_t i : facing_) drawTriangle(i, offset, depth_m);
  shade(offset);
}

}  // namespace airclay
