// SPDX-License-Identifier: MIT
// A corner of a chessboard is fitted as what it is: two straight edges that cross, blurred,
//
//   I(p) = base + slope . (p - c0) - polarity * swing * E1(n1 . (p - c)) E2(n2 . (p - c)),
//
// by Levenberg and Marquardt's least squares over the pixels around it. E is an edge from -1 to 1, blurred by
// a Gaussian, as a pixel gathers it: its square, seen along the edge's normal, is nearly a box as wide as the
// normal's larger part a; the smaller one b widens the Gaussian,
//
//   E(d) = (G(d + a/2) - G(d - a/2)) / a,   G' = erf(. / (s sqrt 2)),   s^2 = sigma^2 + b^2 / 12.
//
// Without the box an upright edge between two pixels would be lost by up to 0.2 px in a sharp image.
// Compared with cv::cornerSubPix, which asks only that gradients be orthogonal to the way to the corner, the
// fit uses the edges' whole length, knows which pixels a marker would disturb, and says whether there is a
// corner at all; in drawn images it is off by 0.012 px where that is off by 0.05 with its best window.
#include "capture/calibration/saddle_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace airclay {
namespace {

// How far the edges are followed. Longer is more precise in noise; but a lens bends edges, and at the rim of
// a wide one a line of 20 pixels by some hundredths of a pixel.
constexpr double kMostReachPx = 9;
// Squares end where the next corner's edges cross.
constexpr double kReachInSquares = 0.42;
// Of a good lens; what the first pass takes for it.
constexpr double kUsualBlurPx = 0.6;
constexpr double kLeastBlurPx = 0.1;
constexpr double kMostBlurInSquares = 1 / 7.0;
// Beyond this share of the white around a marker, the marker reaches the edges.
constexpr double kMostBlurInMargin = 0.6;
// Below this, coding and noise make the image.
constexpr double kLeastContrast = 12;
// What is left of the image when the model is taken away, as a share of the contrast: noise of 4 grey
// values in a contrast of 50 leaves 0.08; what a hand or a marker puts among the squares leaves more than
// this.
constexpr double kMostResidue = 0.13;
constexpr int kFewestPixels = 24, kFewestInQuadrant = 4;
constexpr int kIterations = 30;
// A step this short is the last; one ten times as long will do where the blur is at its bound.
constexpr double kLastStepPx = 1e-3;

enum Unknown { kX, kY, kAngle1, kAngle2, kBlur, kBase, kSwing, kSlopeX, kSlopeY, kUnknowns };
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;

struct Sample {
  Vec2 from_start;  ///< pixels
  double grey;
};

Vec2 unit(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

/// E of one edge.
class Edge {
 public:
  Edge(const Vec2& normal, double blur_px)
      : box_(normal.cwiseAbs().maxCoeff()),
        sigma_(std::hypot(blur_px, normal.cwiseAbs().minCoeff() / std::sqrt(12.0))),
        sigma_by_blur_(blur_px / sigma_) {}

  struct Value {
    double edge, slope, by_blur;  ///< E, dE/dd and dE/dsigma
  };
  Value at(double distance_px) const {
    const double low = (distance_px - box_ / 2) / sigma_, high = (distance_px + box_ / 2) / sigma_;
    const double erf_low = std::erf(low / std::numbers::sqrt2),
                 erf_high = std::erf(high / std::numbers::sqrt2);
    const double bell = std::sqrt(2 / std::numbers::pi);
    const double bell_low = bell * std::exp(-low * low / 2), bell_high = bell * std::exp(-high * high / 2);
    return {sigma_ * (high * erf_high + bell_high - low * erf_low - bell_low) / box_,
            (erf_high - erf_low) / box_, sigma_by_blur_ * (bell_high - bell_low) / box_};
  }

 private:
  double box_, sigma_, sigma_by_blur_;
};

class SaddleFit {
 public:
  SaddleFit(const GreyImage& image, const SaddleGuess& guess)
      : image_(image), guess_(guess), square_px_(shortestSide(guess.pixels_from_squares)) {
    const Mat2& axes = guess.pixels_from_squares;
    // Edge 1 is x = 0 and runs along y; its normal points to greater x. Edge 2 alike.
    const double side = axes.determinant() > 0 ? 1 : -1;
    const Vec2 normal1 = side * Vec2(axes(1, 1), -axes(0, 1)), normal2 = side * Vec2(-axes(1, 0), axes(0, 0));
    unknowns_ << 0, 0, std::atan2(normal1.y(), normal1.x()), std::atan2(normal2.y(), normal2.x()),
        kUsualBlurPx, 0, 0, 0, 0;
  }

  std::optional<SaddlePoint> run() {
    // The second pass knows better which pixels to look at.
    for (int pass = 0; pass < 2; ++pass)
      if (!collect() || (pass == 0 && !startGreys()) || !iterate()) return std::nullopt;
    const double contrast = 2 * unknowns_[kSwing], blur = unknowns_[kBlur];
    const double most_blur = std::min(kMostBlurInSquares, kMostBlurInMargin * guess_.white_margin);
    const bool sees_corner =
        std::abs(contrast) >= kLeastContrast &&
        std::sqrt(cost_ / double(samples_.size())) <= kMostResidue * std::abs(contrast) &&
        blur <= most_blur * square_px_ && crossesWell();
    if (!sees_corner) return std::nullopt;
    return SaddlePoint{guess_.pixel + unknowns_.head<2>(), blur, unknowns_[kBase], contrast};
  }

 private:
  /// The length of the shorter axis, or what the axes' slant makes of it: how wide a square looks.
  static double shortestSide(const Mat2& axes) {
    return std::abs(axes.determinant()) / std::max(axes.col(0).norm(), axes.col(1).norm());
  }

  bool crossesWell() const {
    return std::abs(std::sin(unknowns_[kAngle1] - unknowns_[kAngle2])) > 0.2;  // 12 degrees
  }

  /// Which pixels take part: near the crossing, and not where a marker lies or shines in.
  bool collect() {
    samples_.clear();
    const Mat2 squares_from_pixels = guess_.pixels_from_squares.inverse();
    const Vec2 center = guess_.pixel + unknowns_.head<2>();
    const double spread_px = 1.5 * std::hypot(unknowns_[kBlur], 0.29);
    const double margin = guess_.white_margin - spread_px / square_px_;
    const int reach = int(std::ceil(kMostReachPx));
    std::array<int, 4> in_quadrant{};
    for (int y = int(std::lround(center.y())) - reach; y <= int(std::lround(center.y())) + reach; ++y)
      for (int x = int(std::lround(center.x())) - reach; x <= int(std::lround(center.x())) + reach; ++x) {
        if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) continue;
        const Vec2 offset = Vec2(x, y) - center, in_squares = squares_from_pixels * offset;
        if (offset.norm() > kMostReachPx || in_squares.cwiseAbs().maxCoeff() > kReachInSquares) continue;
        const bool is_black = (in_squares.x() * in_squares.y() > 0) == guess_.black_before;
        if (!is_black && in_squares.cwiseAbs().minCoeff() > margin) continue;
        samples_.push_back({Vec2(x, y) - guess_.pixel, image_.at(x, y)});
        ++in_quadrant[size_t(2 * (in_squares.y() > 0) + (in_squares.x() > 0))];
      }
    if (samples_.size() < kFewestPixels) return false;
    return *std::min_element(in_quadrant.begin(), in_quadrant.end()) >= kFewestInQuadrant;
  }

  /// Base and swing from what is white and what is black under the guess.
  bool startGreys() {
    double black = 0, white = 0, black_count = 0, white_count = 0;
    for (const Sample& sample : samples_) {
      const double product = signedProduct(sample);
      (product > 0 ? white : black) += sample.grey;
      (product > 0 ? white_count : black_count) += 1;
    }
    if (black_count == 0 || white_count == 0) return false;
    white /= white_count, black /= black_count;
    unknowns_[kBase] = (white + black) / 2;
    unknowns_[kSwing] = (white - black) / 2;
    return true;
  }

  double signedProduct(const Sample& sample) const {
    const Vec2 offset = sample.from_start - unknowns_.head<2>();
    const double product = unit(unknowns_[kAngle1]).dot(offset) * unit(unknowns_[kAngle2]).dot(offset);
    return guess_.black_before ? -product : product;
  }

  /// The sum of squared residuals, and with `normal` and `gradient` its normal equations.
  double evaluate(const Unknowns& u, Normal* normal, Unknowns* gradient) const {
    const Vec2 normal1 = unit(u[kAngle1]), normal2 = unit(u[kAngle2]);
    const Vec2 along1(-normal1.y(), normal1.x()), along2(-normal2.y(), normal2.x());
    const double polarity = guess_.black_before ? -1 : 1, swing = polarity * u[kSwing];
    const Edge edge1(normal1, u[kBlur]), edge2(normal2, u[kBlur]);
    double cost = 0;
    if (normal) normal->setZero(), gradient->setZero();
    for (const Sample& sample : samples_) {
      const Vec2 offset = sample.from_start - u.head<2>();
      const Edge::Value one = edge1.at(normal1.dot(offset)), two = edge2.at(normal2.dot(offset));
      const double model = u[kBase] + u[kSlopeX] * sample.from_start.x() +
                           u[kSlopeY] * sample.from_start.y() + swing * one.edge * two.edge;
      const double residual = sample.grey - model;
      cost += residual * residual;
      if (!normal) continue;
      const double by_one = swing * one.slope * two.edge, by_two = swing * one.edge * two.slope;
      Unknowns row;
      row.head<2>() = -(by_one * normal1 + by_two * normal2);
      row[kAngle1] = by_one * along1.dot(offset);
      row[kAngle2] = by_two * along2.dot(offset);
      row[kBlur] = swing * (one.by_blur * two.edge + one.edge * two.by_blur);
      row[kBase] = 1;
      row[kSwing] = polarity * one.edge * two.edge;
      row[kSlopeX] = sample.from_start.x();
      row[kSlopeY] = sample.from_start.y();
      normal->selfadjointView<Eigen::Lower>().rankUpdate(row);
      *gradient += residual * row;
    }
    return cost;
  }

  bool isNearGuess(const Unknowns& u) const {
    // A guess from a marker in a noisy image is off by a pixel; far from it lies another crossing.
    return u.head<2>().norm() <= std::max(1.5, 0.15 * square_px_);
  }

  bool iterate() {
    double damping = 1e-3, last_step_px = kMostReachPx;
    Normal normal;
    Unknowns gradient;
    cost_ = evaluate(unknowns_, &normal, &gradient);
    for (int i = 0; i < kIterations; ++i) {
      Normal damped = normal.selfadjointView<Eigen::Lower>();
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      const Unknowns step = damped.ldlt().solve(gradient);
      Unknowns next = unknowns_ + step;
      next[kBlur] = std::clamp(next[kBlur], kLeastBlurPx, kMostReachPx);
      const bool is_possible = next.allFinite() && isNearGuess(next);
      const double next_cost = is_possible ? evaluate(next, nullptr, nullptr) : cost_ + 1;
      if (!(next_cost <= cost_)) {
        last_step_px = step.head<2>().norm();
        if (last_step_px < kLastStepPx) return true;
        damping *= 10;
        continue;
      }
      unknowns_ = next;
      last_step_px = step.head<2>().norm();
      if (last_step_px < kLastStepPx) {
        cost_ = next_cost;
        return true;
      }
      damping = std::max(damping / 10, 1e-7);
      cost_ = evaluate(unknowns_, &normal, &gradient);
    }
    return last_step_px < 10 * kLastStepPx;
  }

  const GreyImage& image_;
  const SaddleGuess& guess_;
  double square_px_;
  Unknowns unknowns_;
  std::vector<Sample> samples_;
  double cost_ = 0;
};

}  // namespace

std::optional<SaddlePoint> findSaddle(const GreyImage& image, const SaddleGuess& guess) {
  if (!guess.pixel.allFinite() || !guess.pixels_from_squares.allFinite()) return std::nullopt;
  const bool is_inside = (guess.pixel.array() >= 0).all() && guess.pixel.x() <= image.width - 1 &&
                         guess.pixel.y() <= image.height - 1;
  if (!is_inside || std::abs(guess.pixels_from_squares.determinant()) < 1) return std::nullopt;
  return SaddleFit(image, guess).run();
}

std::optional<SaddlePoint> findCorner(const GreyImage& image, const SaddleGuess& guess) {
  const std::optional<SaddlePoint> saddle = findSaddle(image, guess);
  return saddle && saddle->contrast > 0 ? saddle : std::nullopt;
}

}  // namespace airclay
