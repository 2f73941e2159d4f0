// SPDX-License-Identifier: MIT
// The reference implementation of the outline's fit: serial, in double precision.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/hand/outline.h"

namespace airclay {
namespace {

using Vec7 = Eigen::Matrix<double, 7, 1>;
using Mat7 = Eigen::Matrix<double, 7, 7>;

constexpr int kSideMargin = 3;       // pixels: lines start this far inside the image,
constexpr int kBorder = 2;           // and end this far inside
constexpr double kForearmAhead = 4;  // pixels outside an edge that are not the forearm

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double distanceToSegment(const Vec2& point, const Vec2& from, const Vec2& to) {
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  const double place = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0;
  return (point - from - place * along).norm();
}

/// A point of the hand in the camera's frame.
Vec3 inCamera(const Camera& camera, const Workspace& workspace, const GpuOutlinePose& pose,
              const Vec3& in_hand) {
  const Vec3 in_workspace = pose.position.cast<double>() + double(pose.scale) * (rotationOf(pose) * in_hand);
  return camera.camera_from_world * (workspace.center + in_workspace);
}

/// A line across a projected edge.
struct Line {
  Vec2 point, normal;           // the edge's middle; unit, outwards
  int inside = 0, outside = 0;  // pixels
  double length = 0;
};

/// The questions that the search of a line asks about the image.
struct LineImage {
  explicit LineImage(const OutlineView& v) : view(v) {}
  bool isHand(const Vec2& point) const {
    const int x = int(std::floor(point.x() + 0.5)), y = int(std::floor(point.y() + 0.5));
    return x >= 0 && y >= 0 && x < view.mask.width && y < view.mask.height && view.mask.contains(x, y);
  }
  bool isWithin(const Vec2& point, int margin) const {
    return point.minCoeff() >= margin && point.x() < view.mask.width - 1 - margin &&
           point.y() < view.mask.height - 1 - margin;
  }
  bool isForearm(const Vec2& point) const {
    return distanceToSegment(point, view.arm_from.cast<double>().head<2>(),
                             view.arm_to.cast<double>().head<2>()) < view.arm_from[2];
  }
  const OutlineView& view;
};

/// The line of an edge, searched up to `reach` pixels; empty where the edge is not part of the outline.
std::optional<Line> lineOf(const OutlineView& view, const GpuOutlineEdge& edge, int reach) {
  const LineImage image(view);
  const Vec2 from = *view.pixels[edge.from], to = *view.pixels[edge.to];
  Line line;
  line.length = (to - from).norm();
  line.point = 0.5 * (from + to);
  line.normal = Vec2(from.y() - to.y(), to.x() - from.x()) / line.length;
  const bool hand_ahead = image.isHand(line.point + kBesideEdge * line.normal);
  const bool hand_behind = image.isHand(line.point - kBesideEdge * line.normal);
  if (hand_ahead == hand_behind) return std::nullopt;
  if (hand_ahead) line.normal = -line.normal;
  const auto at = [&](double pixels) { return Vec2(line.point + pixels * line.normal); };
  if (image.isHand(at(kClearOfEdge)) || !image.isWithin(line.point, kSideMargin) ||
      image.isForearm(line.point) || image.isForearm(at(kForearmAhead)))
    return std::nullopt;

  // outside up to the middle of the gap to the next part of the hand, inside up to the middle of this one
  int next = 3, last = 2;
  while (next <= reach && !image.isHand(at(next))) ++next;
  while (last <= reach && image.isHand(at(-last))) ++last;
  line.outside = next <= reach ? next / 2 : reach;
  line.inside = last <= reach ? std::max(1, last / 2) : reach;
  while (line.outside > 1 && !image.isWithin(at(line.outside), kBorder)) --line.outside;
  while (line.inside > 1 && !image.isWithin(at(-line.inside), kBorder)) --line.inside;
  int arm = 1;
  while (arm < line.outside && !image.isForearm(at(arm))) ++arm;
  line.outside = std::min(line.outside, arm);
  return line;
}

/// Where the middle of an edge projects to after a change of the pose.
Vec2 movedMiddle(const OutlineView& view, const GpuOutlineEdge& edge, const Vec7& change) {
  const OutlineModel& model = *view.model;
  const Vec3 middle =
      0.5 * (model.vertices[edge.from].cast<double>() + model.vertices[edge.to].cast<double>());
  const Mat3 turn = rotationFromVector(change.segment<3>(3)) * rotationOf(view.pose);
  const Vec3 point = view.workspace->center + view.pose.position.cast<double>() + change.head<3>() +
                     double(view.pose.scale) * std::exp(change[6]) * (turn * middle);
  return projectThroughLens(view.camera->lens, view.camera->camera_from_world * point)
      .value_or(Vec2(NAN, NAN));
}

/// How the projected edge moves along the line with each of the pose's parameters.
Vec7 derivativeOf(const OutlineView& view, const GpuOutlineEdge& edge, const Line& line) {
  constexpr double kStep = 1e-6;  // metres and radians
  Vec7 row;
  for (int k = 0; k < 7; ++k) {
    const Vec7 change = kStep * Vec7::Unit(k);
    row[k] =
        line.normal.dot(movedMiddle(view, edge, change) - movedMiddle(view, edge, -change)) / (2 * kStep);
  }
  return row;
}

double blurOf(const OutlineView& view, const Vec7& row) {
  const double speed = row.head<3>().dot(view.velocity) + row.segment<3>(3).dot(view.spin);  // pixels/s
  return std::min(double(kMostBlur), kExposure * std::abs(speed));
}

/// The weight of a line of the given length, without that of its offset.
double lengthWeight(double length) {
  return std::min(length, double(kLongestLine)) / kLinePixels;
}

double evidenceAt(const OutlineView& view, const Vec2& point) {
  const int x = int(std::floor(point.x() + 0.5)), y = int(std::floor(point.y() + 0.5));
  const int tile = kEvidenceTile;
  if (x / tile < int(view.region.low[0]) || x / tile >= int(view.region.high[0]) ||
      y / tile < int(view.region.low[1]) || y / tile >= int(view.region.high[1]))
    return 0;
  const int columns = int(kTileCells) * (view.camera->width / tile);
  return evidenceOf(view.evidence[std::size_t(y / 2 * columns + x / 2)]);
}

/// An image and its background between the pixels, at the background's exposure.
struct Sample {
  Vec3 seen = Vec3::Zero(), background = Vec3::Zero();
};

Sample sampleAt(const OutlineView& view, const Vec2& point) {
  Sample sample;
  const Vec2 low(std::floor(point.x()), std::floor(point.y()));
  for (int corner = 0; corner < 4; ++corner) {
    const Vec2 pixel = low + Vec2(corner % 2, corner / 2);
    const double weight = (1 - std::abs(point.x() - pixel.x())) * (1 - std::abs(point.y() - pixel.y()));
    const auto index = std::size_t(int(pixel.y()) * view.camera->width + int(pixel.x()));
    for (int k = 0; k < 3; ++k) {
      sample.seen[k] += weight * view.image[3 * index + std::size_t(k)] / view.gain[k];
      sample.background[k] += weight * (view.background[index] >> (8 * k) & 255);
    }
  }
  return sample;
}

/// A pixel of a fine line: its distance from the middle of the line, outwards.
struct LinePixel {
  double x = 0;
  Vec3 seen, background;
};

/// The pixels of a line, with what is behind the hand as their background.
std::vector<LinePixel> linePixels(const OutlineView& view, const Line& line, int inside, int outside,
                                  int far) {
  std::vector<LinePixel> pixels;
  Vec3 seen = Vec3::Zero(), background = Vec3::Zero();
  for (int k = -inside; k <= outside; ++k) {
    const Sample at = sampleAt(view, line.point + k * line.normal);
    pixels.push_back({double(k), at.seen, at.background});
  }
  for (int k = kFineNear; k <= far; ++k) {
    const Sample at = sampleAt(view, line.point + k * line.normal);
    seen += at.seen / (far - kFineNear + 1);
    background += at.background / (far - kFineNear + 1);
  }
  const double count = far - kFineNear + 1;
  const double square = std::max(background.squaredNorm(), 1 / (count * count));
  const double light = std::clamp(seen.dot(background) / square, double(kFullShadow), double(kMostLight));
  const bool is_other = (seen - light * background).norm() > kFineOther;
  for (LinePixel& pixel : pixels) pixel.background = is_other ? seen : Vec3(light * pixel.background);
  return pixels;
}

/// The cost of an edge at e: ½ Σ residual² / noise², for the best linear colour inside.
double costOf(const std::vector<LinePixel>& pixels, double e) {
  // the slope has a Gaussian prior of deviation kFineSlope
  const double slope_weight = std::pow(kFineNoise / kFineSlope, 2);
  Eigen::Matrix2d normal = Eigen::Vector2d(1e-6, slope_weight).asDiagonal();
  Eigen::Matrix<double, 2, 3> right = Eigen::Matrix<double, 2, 3>::Zero();
  const auto hand = [&](const LinePixel& pixel) {  // the fraction of the pixel
    return std::clamp(0.5 - (pixel.x - e) / kFineRamp, 0.0, 1.0);
  };
  for (const LinePixel& pixel : pixels) {
    const double s = hand(pixel);
    const Eigen::Vector2d basis(s, s * (pixel.x - e));
    normal += basis * basis.transpose();
    right += basis * (pixel.seen - (1 - s) * pixel.background).transpose();
  }
  const Eigen::Matrix<double, 2, 3> colour = normal.ldlt().solve(right);
  double sum = slope_weight * colour.row(1).squaredNorm() + 1e-6 * colour.row(0).squaredNorm();
  for (const LinePixel& pixel : pixels) {
    const double s = hand(pixel);
    const Vec3 inside = (colour.row(0) + (pixel.x - e) * colour.row(1)).transpose();
    sum += (s * inside + (1 - s) * pixel.background - pixel.seen).squaredNorm();
  }
  return sum / (2 * kFineNoise * kFineNoise);
}

}  // namespace

std::vector<std::optional<Vec2>> projectReference(const Camera& camera, const Workspace& workspace,
                                                  const OutlineModel& model, const GpuOutlinePose& pose) {
  std::vector<std::optional<Vec2>> pixels;
  for (const vec3& vertex : model.vertices)
    pixels.push_back(
        projectThroughLens(camera.lens, inCamera(camera, workspace, pose, vertex.cast<double>())));
  return pixels;
}

std::array<vec4, 2> forearmReference(const Camera& camera, const Workspace& workspace,
                                     const GpuOutlineFrame& frame, const GpuOutlinePose& pose) {
  const Vec3 from = inCamera(camera, workspace, pose, frame.arm_from.cast<double>());
  Vec3 to = inCamera(camera, workspace, pose, frame.arm_to.cast<double>());
  if (to.z() < kNearest) to = from + std::max(0.0, (kNearest - from.z()) / (to.z() - from.z())) * (to - from);
  const Vec2 start = projectThroughLens(camera.lens, from).value_or(Vec2::Constant(kNotProjected));
  const Vec2 end = projectThroughLens(camera.lens, to).value_or(start);
  const double radius = camera.lens.fx * pose.scale * frame.arm_radius / std::max(double(kNearest), from.z());
  return {vec4(float(start.x()), float(start.y()), float(radius), 0),
          vec4(float(end.x()), float(end.y()), 0, 0)};
}

Silhouette maskReference(const Camera& camera, const OutlineModel& model,
                         const std::vector<std::optional<Vec2>>& pixels) {
  Silhouette mask = emptySilhouette(camera);
  for (const GpuTriangle& triangle : model.triangles) {
    std::array<Vec2, 3> corners;
    bool is_projected = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<Vec2>& pixel = pixels[triangle.corners[k]];
      is_projected = is_projected && pixel.has_value();
      corners[k] = pixel.value_or(Vec2::Zero());
    }
    if (!is_projected || cross(corners[1] - corners[0], corners[2] - corners[0]) >= 0) continue;
    const Vec2 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Vec2 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    const int last_x = int(std::min(std::floor(high.x()), camera.width - 1.0));
    const int last_y = int(std::min(std::floor(high.y()), camera.height - 1.0));
    for (int y = int(std::max(std::ceil(low.y()), 0.0)); y <= last_y; ++y)
      for (int x = int(std::max(std::ceil(low.x()), 0.0)); x <= last_x; ++x) {
        bool is_inside = true;
        for (std::size_t k = 0; k < 3; ++k)
          is_inside = is_inside && cross(corners[(k + 1) % 3] - corners[k], Vec2(x, y) - corners[k]) <= 0;
        if (is_inside) mask.pixels[std::size_t(y * camera.width + x)] = 255;
      }
  }
  return mask;
}

std::vector<std::uint32_t> listReference(const OutlineModel& model,
                                         const std::vector<std::optional<Vec2>>& pixels) {
  std::vector<std::uint32_t> list;
  for (std::size_t i = 0; i < model.edges.size() && list.size() < kOutlineLines; ++i) {
    const GpuOutlineEdge& edge = model.edges[i];
    const std::optional<Vec2>&from = pixels[edge.from], &to = pixels[edge.to];
    const std::optional<Vec2>&left = pixels[edge.left], &right = pixels[edge.right];
    if (!from || !to || !left || !right || (*to - *from).norm() < kShortestEdge) continue;
    const bool left_front = cross(*to - *from, *left - *from) < 0;
    const bool right_front = cross(*from - *to, *right - *to) < 0;
    if (left_front != right_front) list.push_back(static_cast<std::uint32_t>(i));
  }
  return list;
}

OutlineLine coarseReference(const OutlineView& view, std::uint32_t edge, int reach, double spread) {
  OutlineLine result;
  const std::optional<Line> line = lineOf(view, view.model->edges[edge], reach);
  if (!line) return result;
  result.length = line->length;
  // the edge is between two pixels of the line; all pixels up to it are the hand
  std::vector<std::array<double, 2>> places;  // distance, logarithm of the probability
  double evidence = 0;
  for (int last = -line->inside - 1; last <= line->outside; ++last) {
    if (last >= -line->inside) evidence += evidenceAt(view, line->point + last * line->normal);
    const double d = last + 0.5;
    places.push_back({d, kEvidenceTrust * evidence - d * d / (2 * spread * spread)});
  }
  double highest = places.front()[1];
  for (const auto& [d, exponent] : places) highest = std::max(highest, exponent);
  double mass = 0, mean = 0, variance = 0;
  for (const auto& [d, exponent] : places) mass += std::exp(exponent - highest);
  for (const auto& [d, exponent] : places) mean += d * std::exp(exponent - highest) / mass;
  for (const auto& [d, exponent] : places)
    variance += (d - mean) * (d - mean) * std::exp(exponent - highest) / mass;
  variance += 1.0 / 12;  // of the place between two pixels

  // The prior only limits the search: its information is removed from the product of Gaussians.
  const double information = 1 / variance - 1 / (spread * spread);
  if (information <= 0) return result;
  result.offset = mean / variance / information;
  if (std::abs(result.offset) > 2 * reach) return result;
  result.weight = std::min(information, 1 / std::pow(double(kCoarseDeviation), 2)) /
                  (1 + std::pow(result.offset / (1.5 * spread), 2)) * lengthWeight(line->length);
  result.row = derivativeOf(view, view.model->edges[edge], *line);
  result.blur = blurOf(view, result.row);
  return result;
}

OutlineLine fineReference(const OutlineView& view, std::uint32_t edge) {
  OutlineLine result;
  const std::optional<Line> line = lineOf(view, view.model->edges[edge], kFineFar);
  if (!line) return result;
  result.length = line->length;
  const int inside = std::min(line->inside, kFineInside), outside = std::min(line->outside, kFineOutside);
  const int far = std::min(line->outside, kFineFar);
  if (inside < 3 || far < kFineNear) return result;
  result.row = derivativeOf(view, view.model->edges[edge], *line);
  result.blur = blurOf(view, result.row);

  const std::vector<LinePixel> pixels = linePixels(view, *line, inside, outside, far);
  const double low = std::max(-double(kFineReach), 1.5 - inside);
  const double high = std::min(double(kFineReach), outside - 0.5);
  std::vector<double> places, costs;
  for (double e = low; e <= high + 1e-9; e += kFineStep) {
    places.push_back(e);
    costs.push_back(costOf(pixels, e));
  }
  if (costs.size() < 3) return result;
  const auto best = std::size_t(std::ranges::min_element(costs) - costs.begin());
  double mass = 0, mean = 0, variance = 0;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const double weight = std::exp(costs[best] - costs[i]);
    mass += weight;
    mean += weight * places[i];
  }
  mean /= mass;
  for (std::size_t i = 0; i < costs.size(); ++i)
    variance += std::exp(costs[best] - costs[i]) / mass * std::pow(places[i] - mean, 2);
  if (variance < 0.1 && best > 0 && best + 1 < costs.size()) {
    // the minimum of the parabola through three costs
    const double curvature = std::max(costs[best - 1] - 2 * costs[best] + costs[best + 1], 1e-9);
    mean = places[best] + 0.5 * kFineStep * (costs[best - 1] - costs[best + 1]) / curvature;
    variance = std::max(variance, kFineStep * kFineStep / curvature);
  }
  if (variance >= kFineFlat * std::pow(high - low, 2) / 12) return result;
  result.offset = mean;
  result.weight = lengthWeight(line->length) / (variance + std::pow(double(kFineDeviation), 2)) /
                  (1 + std::pow(mean / kFineOutlier, 2));
  return result;
}

GpuOutlineFit solveReference(const GpuOutlinePose& pose,
                             const std::vector<std::vector<GpuOutlineLine>>& lines, const ScalePrior& scale) {
  GpuOutlineFit fit{};
  Mat7 information = Mat7::Zero();
  Vec7 gradient = Vec7::Zero();
  double residual = 0, total = 0;
  for (std::size_t camera = 0; camera < lines.size(); ++camera) {
    double length = 0, good = 0;
    for (const GpuOutlineLine& line : lines[camera]) {
      length += line.length_;
      if (!(line.weight > 0)) continue;
      const Vec7 row = Eigen::Map<const Eigen::Matrix<float, 7, 1>>(line.row).cast<double>();
      information += line.weight * row * row.transpose();
      gradient += double(line.weight) * line.offset * row;
      residual += double(line.weight) * line.offset * line.offset;
      total += line.weight;
      ++fit.lines;
      if (std::abs(line.offset) < kGoodOffset + 0.5 * line.blur) good += line.length_;
    }
    fit.camera_length[camera] = static_cast<float>(length);
    fit.camera_good[camera] = static_cast<float>(good);
  }
  int k = 0;
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column <= row; ++column)
      fit.information[k++] = static_cast<float>(information(row, column));
  fit.residual = static_cast<float>(residual);
  fit.weight = static_cast<float>(total);

  const double per_shift = std::pow(double(kOutlineShift), -2), per_turn = std::pow(double(kOutlineTurn), -2);
  information.diagonal().head<3>().array() += per_shift;
  information.diagonal().segment<3>(3).array() += per_turn;
  information(6, 6) += scale.weight;
  gradient[6] += scale.weight * (scale.log_scale - std::log(double(pose.scale)));
  Vec7 step = Vec7::Zero();
  if (scale.weight > 0)
    step = information.ldlt().solve(gradient);
  else
    step.head<6>() = information.topLeftCorner<6, 6>().ldlt().solve(gradient.head<6>());
  const double shift = step.head<3>().norm(), turn = step.segment<3>(3).norm();
  step *= std::min({1.0, kOutlineMaxShift / std::max(shift, 1e-9), kOutlineMaxTurn / std::max(turn, 1e-9)});
  fit.pose = outlinePose(rotationFromVector(step.segment<3>(3)) * rotationOf(pose),
                         pose.position.cast<double>() + step.head<3>(),
                         pose.scale * std::exp(std::clamp(step[6], -0.05, 0.05)));
  return fit;
}

bool judgeReference(const GpuOutlineFit& fit, std::size_t cameras) {
  double length = 0, good = 0;
  std::uint32_t agreeing = 0;
  for (std::size_t k = 0; k < cameras; ++k) {
    length += fit.camera_length[k];
    good += fit.camera_good[k];
    agreeing += fit.camera_length[k] >= kLeastOutline &&
                fit.camera_good[k] >= double(kCameraAgreement) * fit.camera_length[k];
  }
  const bool is_clear = fit.judged_length >= double(kLeastJudged) * length &&
                        good >= double(kJudgedAgreement) * fit.judged_length;
  return agreeing >= kAgreeingCameras && (good >= double(kTrackedAgreement) * length || is_clear);
}

}  // namespace airclay
