// SPDX-License-Identifier: MIT
// Fits a model of a chessboard corner, two blurred straight edges that cross,
//
//   I(p) = base + slope . (p - c0) - polarity * swing * E1(n1 . (p - c)) E2(n2 . (p - c)),
//
// to the surrounding pixels by the Levenberg-Marquardt method. E is an edge from -1 to 1, blurred by a
// Gaussian and integrated over a pixel. Along the edge's normal, the pixel's area is approximately a box as
// wide as the normal's larger component a; the smaller component b widens the Gaussian,
//
//   E(d) = (G(d + a/2) - G(d - a/2)) / a,   G' = erf(. / (s sqrt 2)),   s^2 = sigma^2 + b^2 / 12.
//
// Without the box, the error for a vertical edge between two pixels of a sharp image is up to 0.2 px.
// cv::cornerSubPix only requires gradients to be orthogonal to the direction to the corner. In contrast, this
// fit uses the full length of the edges, excludes pixels that a marker affects, and detects that there is no
// corner. In synthetic images its error is 0.012 px; that of cv::cornerSubPix with its best window is 0.05
// px.
#include "capture/calibration/saddle_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace airclay {
namespace {

// The radius of the fit. A larger radius reduces the effect of noise; but lenses bend edges: near the border
// of a wide-angle image, a line of 20 pixels by some hundredths of a pixel.
constexpr double kMaxRadiusPx = 9;
// Less than half a square: beyond, the edges of the next corner affect the pixels.
constexpr double kMaxRadiusInSquares = 0.42;
// The initial value: the blur of a good lens.
constexpr double kInitialBlurPx = 0.6;
constexpr double kMinBlurPx = 0.1;
constexpr double kMaxBlurInSquares = 1 / 7.0;
// With a blur above this fraction of the white margin, the marker affects the edges.
constexpr double kMaxBlurInMargin = 0.6;
// Below this contrast, compression artefacts and noise dominate.
constexpr double kMinContrast = 12;
// The RMS residual as a fraction of the contrast: noise of 4 grey values at a contrast of 50 gives 0.08; a
// hand or a marker in front of the squares gives more than this.
constexpr double kMaxResidual = 0.13;
constexpr int kMinPixels = 24, kMinPixelsPerQuadrant = 4;
constexpr int kMaxIterations = 30;
// Converged after a step this short; after one ten times as long if kMaxIterations is reached, which occurs
// when the blur is at its bound.
constexpr double kConvergedStepPx = 1e-3;

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

/// E(d) of one edge, for the distance d from it.
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
      : image_(image), guess_(guess), square_px_(squareHeight(guess.pixels_from_squares)) {
    const Mat2& axes = guess.pixels_from_squares;
    // Edge 1 is the board's y axis, and its normal points towards +x. Edge 2 is the x axis.
    const double side = axes.determinant() > 0 ? 1 : -1;
    const Vec2 normal1 = side * Vec2(axes(1, 1), -axes(0, 1)), normal2 = side * Vec2(-axes(1, 0), axes(0, 0));
    unknowns_ << 0, 0, std::atan2(normal1.y(), normal1.x()), std::atan2(normal2.y(), normal2.x()),
        kInitialBlurPx, 0, 0, 0, 0;
  }

  std::optional<SaddlePoint> run() {
    // The second pass selects the pixels by the position and blur that the first pass found.
    for (int pass = 0; pass < 2; ++pass)
      if (!selectSamples() || (pass == 0 && !initializeGreys()) || !iterate()) return std::nullopt;
    const double contrast = 2 * unknowns_[kSwing], blur = unknowns_[kBlur];
    const double max_blur = std::min(kMaxBlurInSquares, kMaxBlurInMargin * guess_.white_margin);
    const bool is_corner = std::abs(contrast) >= kMinContrast &&
                           std::sqrt(cost_ / double(samples_.size())) <= kMaxResidual * std::abs(contrast) &&
                           blur <= max_blur * square_px_ && edgesCross();
    if (!is_corner) return std::nullopt;
    return SaddlePoint{guess_.pixel + unknowns_.head<2>(), blur, unknowns_[kBase], contrast};
  }

 private:
  /// The smaller height of the parallelogram that a square becomes in the image, pixels.
  static double squareHeight(const Mat2& axes) {
    return std::abs(axes.determinant()) / std::max(axes.col(0).norm(), axes.col(1).norm());
  }

  bool edgesCross() const {
    return std::abs(std::sin(unknowns_[kAngle1] - unknowns_[kAngle2])) > 0.2;  // 12 degrees
  }

  /// Selects the pixels of the fit: near the corner, and not affected by a marker. False if there are too
  /// few.
  bool selectSamples() {
    samples_.clear();
    const Mat2 squares_from_pixels = guess_.pixels_from_squares.inverse();
    const Vec2 center = guess_.pixel + unknowns_.head<2>();
    const double spread_px = 1.5 * std::hypot(unknowns_[kBlur], 0.29);
    const double margin = guess_.white_margin - spread_px / square_px_;
    const int reach = int(std::ceil(kMaxRadiusPx));
    std::array<int, 4> in_quadrant{};
    for (int y = int(std::lround(center.y())) - reach; y <= int(std::lround(center.y())) + reach; ++y)
      for (int x = int(std::lround(center.x())) - reach; x <= int(std::lround(center.x())) + reach; ++x) {
        if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) continue;
        const Vec2 offset = Vec2(x, y) - center, in_squares = squares_from_pixels * offset;
        if (offset.norm() > kMaxRadiusPx || in_squares.cwiseAbs().maxCoeff() > kMaxRadiusInSquares) continue;
        const bool is_black = (in_squares.x() * in_squares.y() > 0) == guess_.black_before;
        if (!is_black && in_squares.cwiseAbs().minCoeff() > margin) continue;
        samples_.push_back({Vec2(x, y) - guess_.pixel, image_.at(x, y)});
        ++in_quadrant[size_t(2 * (in_squares.y() > 0) + (in_squares.x() > 0))];
      }
    if (samples_.size() < kMinPixels) return false;
    return *std::min_element(in_quadrant.begin(), in_quadrant.end()) >= kMinPixelsPerQuadrant;
  }

  /// Initializes base and swing from the mean grey values of the black and white squares of the guess.
  bool initializeGreys() {
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

  /// The sum of squared residuals; also computes the normal equations if `normal` is not null.
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
    // In a noisy image, a guess from a marker has an error of about a pixel. Farther away is another corner.
    return u.head<2>().norm() <= std::max(1.5, 0.15 * square_px_);
  }

  bool iterate() {
    double damping = 1e-3, last_step_px = kMaxRadiusPx;
    Normal normal;
    Unknowns gradient;
    cost_ = evaluate(unknowns_, &normal, &gradient);
    for (int i = 0; i < kMaxIterations; ++i) {
      Normal damped = normal.selfadjointView<Eigen::Lower>();
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      const Unknowns step = damped.ldlt().solve(gradient);
      Unknowns next = unknowns_ + step;
      next[kBlur] = std::clamp(next[kBlur], kMinBlurPx, kMaxRadiusPx);
      const bool is_possible = next.allFinite() && isNearGuess(next);
      const double next_cost = is_possible ? evaluate(next, nullptr, nullptr) : cost_ + 1;
      if (!(next_cost <= cost_)) {
        last_step_px = step.head<2>().norm();
        if (last_step_px < kConvergedStepPx) return true;
        damping *= 10;
        continue;
      }
      unknowns_ = next;
      last_step_px = step.head<2>().norm();
      if (last_step_px < kConvergedStepPx) {
        cost_ = next_cost;
        return true;
      }
      damping = std::max(damping / 10, 1e-7);
      cost_ = evaluate(unknowns_, &normal, &gradient);
    }
    return last_step_px < 10 * kConvergedStepPx;
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
