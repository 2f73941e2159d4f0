// SPDX-License-Identifier: MIT
// Projection and its inverse for OpenCV's two lens models (calib3d manual: "Camera Calibration and 3D
// Reconstruction" for the perspective model, "Fisheye camera model" for the other, which is Kannala and
// Brandt 2006).
//
// Both change a radius and keep its direction: perspective r -> r N(r²) / D(r²) with
//   N(s) = 1 + k1 s + k2 s² + k3 s³,  D(s) = 1 + k4 s + k5 s² + k6 s³,  r = |(x/z, y/z)|,
// plus tangential terms; fisheye θ -> θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸). Beyond the first maximum of that
// curve two directions map to one pixel, and the model no longer describes the lens.
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/camera/rig.h"

namespace airclay {
namespace {

// tan(89.994°): a perspective lens that is monotonic up to here is treated as monotonic everywhere.
constexpr double kFarRadius = 1e4;

using Coefficients = std::vector<double>;  // of a polynomial, constant term first

double valueAt(const Coefficients& polynomial, double s) {
  double value = 0;
  for (size_t i = polynomial.size(); i-- > 0;) value = value * s + polynomial[i];
  return value;
}

double bisect(const Coefficients& polynomial, double low, double high) {
  const bool low_is_positive = valueAt(polynomial, low) > 0;
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) return low;  // neighbours in double precision
    ((valueAt(polynomial, middle) > 0) == low_is_positive ? low : high) = middle;
  }
}

/// The sign changes of the polynomial in (0, end), ascending. Between two adjacent roots of its derivative a
/// polynomial is monotonic, so each such interval contains at most one root. This stays reliable for a nearly
/// vanishing leading coefficient, where closed forms and companion matrices lose a root.
std::vector<double> signChanges(const Coefficients& polynomial, double end) {
  if (polynomial.size() < 2) return {};
  Coefficients derivative(polynomial.size() - 1);
  for (size_t i = 0; i < derivative.size(); ++i)
    derivative[i] = static_cast<double>(i + 1) * polynomial[i + 1];
  std::vector<double> bounds = signChanges(derivative, end);
  bounds.push_back(end);
  std::vector<double> roots;
  double low = 0;
  for (const double high : bounds) {
    if ((valueAt(polynomial, low) > 0) != (valueAt(polynomial, high) > 0))
      roots.push_back(bisect(polynomial, low, high));
    low = high;
  }
  return roots;
}

Coefficients product(const Coefficients& a, const Coefficients& b) {
  Coefficients result(a.size() + b.size() - 1, 0.0);
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t j = 0; j < b.size(); ++j) result[i + j] += a[i] * b[j];
  return result;
}

/// The curve's slope is ((N + 2sN')D - 2sND') / D²: the range ends at the numerator's first root or at the
/// pole.
double perspectiveLimit(const std::array<double, 8>& k) {
  const Coefficients numerator{1, k[0], k[1], k[4]}, denominator{1, k[5], k[6], k[7]};
  const Coefficients numerator_term{1, 3 * k[0], 5 * k[1], 7 * k[4]};    // N + 2sN'
  const Coefficients denominator_term{0, 2 * k[5], 4 * k[6], 6 * k[7]};  // 2sD'
  Coefficients slope = product(numerator_term, denominator);
  const Coefficients subtrahend = product(numerator, denominator_term);
  for (size_t i = 0; i < slope.size(); ++i) slope[i] -= subtrahend[i];

  double limit = std::numeric_limits<double>::infinity();
  for (const Coefficients& ends : {slope, denominator}) {
    const std::vector<double> roots = signChanges(ends, kFarRadius * kFarRadius);
    if (!roots.empty()) limit = std::min(limit, std::sqrt(roots.front()));
  }
  return limit;
}

double fisheyeLimit(const std::array<double, 8>& k) {
  const double right_angle = std::numbers::pi / 2;
  const std::vector<double> roots =
      signChanges({1, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3]}, right_angle * right_angle);
  return roots.empty() ? right_angle : std::sqrt(roots.front());
}

struct ValueAndSlope {
  double value, slope;
};

/// The distorted radius for r (perspective) or θ (fisheye), and its derivative.
ValueAndSlope distortedRadius(const Lens& lens, double radius) {
  const std::array<double, 8>& k = lens.distortion;
  const double s = radius * radius;
  if (lens.model == LensModel::kFisheye)
    return {radius * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))),
            1 + s * (3 * k[0] + s * (5 * k[1] + s * (7 * k[2] + s * 9 * k[3])))};
  const double n = 1 + s * (k[0] + s * (k[1] + s * k[4])), d = 1 + s * (k[5] + s * (k[6] + s * k[7]));
  const double n_slope = k[0] + s * (2 * k[1] + s * 3 * k[4]);  // dN/ds
  const double d_slope = k[5] + s * (2 * k[6] + s * 3 * k[7]);
  return {radius * n / d, n / d + 2 * s * (n_slope * d - n * d_slope) / (d * d)};
}

/// The radius in the monotonic range whose distorted radius is `distorted`; the end of the range if there is
/// none. Newton steps, with bisection where a step would leave the bracket.
double undistortedRadius(const Lens& lens, double distorted) {
  double low = 0, high = std::min(lens.monotonic_limit, kFarRadius);
  double radius = std::min(distorted, 0.5 * high);
  for (int i = 0; i < 200 && low < high; ++i) {
    const ValueAndSlope f = distortedRadius(lens, radius);
    (f.value < distorted ? low : high) = radius;
    double next = radius - (f.value - distorted) / f.slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (next == radius || std::abs(next - radius) <= 4e-16 * radius) return next;
    radius = next;
  }
  return radius;
}

/// Perspective distortion of the point (x/z, y/z); writes its 2 x 2 derivative unless `derivative` is null.
Vec2 distort(const Lens& lens, const Vec2& p, Eigen::Matrix2d* derivative) {
  const double p1 = lens.distortion[2], p2 = lens.distortion[3];
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm(), r = std::sqrt(r2);
  const ValueAndSlope f = distortedRadius(lens, r);
  const double scale = r > 0 ? f.value / r : 1;
  if (derivative) {
    const double scale_slope = r > 0 ? (f.slope - scale) / r2 : 0;  // (d scale / dr) / r
    *derivative << scale + scale_slope * x * x + 2 * p1 * y + 6 * p2 * x,
        scale_slope * x * y + 2 * p1 * x + 2 * p2 * y,  //
        scale_slope * x * y + 2 * p1 * x + 2 * p2 * y, scale + scale_slope * y * y + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * scale + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * scale + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

/// The inverse of distort(). Starts from the inverse of the radial part; the tangential terms are small.
std::optional<Vec2> undistort(const Lens& lens, const Vec2& distorted) {
  const double length = distorted.norm();
  Vec2 p = length > 0 ? Vec2(distorted * (undistortedRadius(lens, length) / length)) : Vec2(Vec2::Zero());
  for (int i = 0; i < 50; ++i) {
    Eigen::Matrix2d derivative;
    const Vec2 residual = distort(lens, p, &derivative) - distorted;
    // 1e-13 of a focal length is 1e-10 pixels; below that, only rounding errors remain.
    if (residual.norm() <= 1e-13 * (1 + length)) break;
    p -= derivative.inverse() * residual;
    if (!p.allFinite()) return std::nullopt;
  }
  const bool converged = (distort(lens, p, nullptr) - distorted).norm() <= 1e-11 * (1 + length);
  if (!converged || p.norm() > lens.monotonic_limit) return std::nullopt;
  return p;
}

}  // namespace

Lens withMonotonicRange(Lens lens) {
  lens.monotonic_limit =
      lens.model == LensModel::kFisheye ? fisheyeLimit(lens.distortion) : perspectiveLimit(lens.distortion);
  return lens;
}

std::optional<Vec2> projectThroughLens(const Lens& lens, const Vec3& point_in_camera) {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  const Vec2 p = point_in_camera.head<2>() / point_in_camera.z();
  const double r = p.norm();
  Vec2 distorted;
  if (lens.model == LensModel::kFisheye) {
    const double theta = std::atan(r);
    if (theta > lens.monotonic_limit) return std::nullopt;
    distorted = r > 0 ? Vec2(p * (distortedRadius(lens, theta).value / r)) : p;
  } else {
    if (r > lens.monotonic_limit) return std::nullopt;
    distorted = distort(lens, p, nullptr);
  }
  return Vec2(lens.fx * distorted.x() + lens.cx, lens.fy * distorted.y() + lens.cy);
}

std::optional<Vec2> project(const Camera& camera, const Vec3& point_in_world) {
  const std::optional<Vec2> pixel =
      projectThroughLens(camera.lens, camera.camera_from_world * point_in_world);
  if (!pixel) return std::nullopt;
  const bool inside = pixel->x() >= -0.5 && pixel->x() < camera.width - 0.5 &&  //
                      pixel->y() >= -0.5 && pixel->y() < camera.height - 0.5;
  return inside ? pixel : std::nullopt;
}

std::optional<Vec3> rayThroughPixel(const Lens& lens, const Vec2& pixel) {
  const Vec2 distorted((pixel.x() - lens.cx) / lens.fx, (pixel.y() - lens.cy) / lens.fy);
  if (lens.model == LensModel::kPerspective) {
    const std::optional<Vec2> p = undistort(lens, distorted);
    return p ? std::optional<Vec3>(Vec3(p->x(), p->y(), 1).normalized()) : std::nullopt;
  }
  const double length = distorted.norm();
  if (length > distortedRadius(lens, lens.monotonic_limit).value) return std::nullopt;
  if (length == 0) return Vec3::UnitZ();
  const double theta = undistortedRadius(lens, length);
  const Vec2 sideways = distorted * (std::sin(theta) / length);
  return Vec3(sideways.x(), sideways.y(), std::cos(theta));
}

}  // namespace airclay
