// SPDX-License-Identifier: MIT
// The quality of a calibration, and warnings about it.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "capture/calibration/board_coverage.h"
#include "capture/calibration/calibration_parts.h"

namespace airclay {
namespace {

// Half a per cent of the focal length moves a point 1 m away by 5 mm along the ray.
constexpr double kPoorFocal = 0.005;

std::string percent(double fraction) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f %%", fraction < 0.1 ? 1 : 0, 100 * fraction);
  return text;
}

std::string twoDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

/// The point with the smallest sum of squared angles to the rays through pixels of several cameras.
std::optional<Vec3> triangulate(const Rig& rig, const std::vector<std::pair<int, Vec2>>& sights) {
  std::optional<Vec3> point;
  for (int round = 0; round < 3; ++round) {
    Mat3 sum = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const auto& [index, pixel] : sights) {
      const Camera& camera = rig.cameras[static_cast<std::size_t>(index)];
      const std::optional<Vec3> ray = rayThroughPixel(camera.lens, pixel);
      if (!ray) return std::nullopt;
      const Pose world_from_camera = camera.camera_from_world.inverse();
      const Vec3 along = world_from_camera.linear() * *ray, eye = world_from_camera.translation();
      const double weight = point ? 1 / (*point - eye).squaredNorm() : 1;
      const Mat3 across = weight * (Mat3::Identity() - along * along.transpose());
      sum += across;
      right += across * eye;
    }
    point = sum.inverse() * right;
  }
  if (!point->allFinite()) return std::nullopt;
  return point;
}

/// RMS error of all distances between the triangulated corners of a board.
std::optional<double> scaleErrorMm(const Bundle& bundle, const Rig& rig) {
  std::map<std::pair<int, int>, std::vector<std::pair<int, Vec2>>> sights;  // by stand and corner
  std::map<int, Vec3> corners;
  for (const BundleView& view : bundle.views)
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      if (!view.trusted[i]) continue;
      sights[{view.stand, view.ids[i]}].emplace_back(view.camera, view.pixels[i]);
      corners[view.ids[i]] = view.corners[i];
    }
  std::map<int, std::vector<std::pair<int, Vec3>>> points;  // by stand
  for (const auto& [key, of_corner] : sights)
    if (of_corner.size() >= 2)
      if (const std::optional<Vec3> point = triangulate(rig, of_corner))
        points[key.first].emplace_back(key.second, *point);
  double sum = 0, count = 0;
  for (const auto& [stand, of_stand] : points)
    for (std::size_t i = 0; i < of_stand.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double known = (corners[of_stand[i].first] - corners[of_stand[j].first]).norm();
        const double measured = (of_stand[i].second - of_stand[j].second).norm();
        sum += (measured - known) * (measured - known);
        ++count;
      }
  if (count == 0) return std::nullopt;
  return 1000 * std::sqrt(sum / count);
}

CameraQuality qualityOf(const Bundle& bundle, int camera, Calibration& calibration) {
  CameraQuality quality;
  const Camera& of_rig = calibration.rig.cameras[static_cast<std::size_t>(camera)];
  BoardCoverage coverage({of_rig.width, of_rig.height});
  const std::vector<int> sharers = sharersOfStands(bundle);
  double sum = 0;
  for (const BundleView& view : bundle.views) {
    if (view.camera != camera) continue;
    const int trusted = view.trustedCount();
    quality.views += trusted > 0;
    quality.shared_views += trusted > 0 && sharers[static_cast<std::size_t>(view.stand)] > 1;
    quality.corners += trusted;
    quality.dropped += static_cast<int>(view.corners.size()) - trusted;
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (!view.trusted[i]) continue;
      const Vec2 error_px = residualOf(bundle, view, i);
      sum += error_px.squaredNorm();
      coverage.add(view.pixels[i]);
      calibration.residuals.push_back({camera, view.frame, view.pixels[i], error_px});
    }
  }
  if (quality.corners > 0) quality.rms_px = std::sqrt(sum / quality.corners);
  quality.coverage = coverage.fraction();
  quality.bare_sides = coverage.emptySides();
  return quality;
}

void warnOfCamera(const CameraQuality& quality, const std::string& name, std::vector<std::string>& warnings) {
  const auto printWarning = [&](const std::string& text) {
    warnings.push_back("camera \"" + name + "\": " + text);
  };
  if (quality.views < kFewViews)
    printWarning("only " + std::to_string(quality.views) +
                 " views of the board are usable; wave the board in front of it for longer");
  if (quality.coverage < kPoorCoverage)
    printWarning("the board covered only " + percent(quality.coverage) +
                 " of its image; bring it closer, and to the edges" +
                 (quality.bare_sides.empty() ? "" : ": " + quality.bare_sides));
  if (quality.rms_px > kMaxGoodRms_px)
    printWarning("corners are off by " + twoDigits(quality.rms_px) +
                 " px; use a flat, stiff board, and move it more slowly in more light");
  if (10 * quality.dropped > quality.corners + quality.dropped)
    printWarning(
        percent(static_cast<double>(quality.dropped) / (quality.corners + quality.dropped)) +
        " of its corners were dropped as outliers; is the board flat, in focus, and the one in the options?");
  if (quality.focal_sigma > kPoorFocal)
    printWarning("its focal length is uncertain" +
                 (std::isfinite(quality.focal_sigma) ? " (to " + percent(quality.focal_sigma) + ")" : "") +
                 "; tilt the board by at least 30 degrees to all sides, near and far");
  if (quality.shared_views < kFewShared)
    printWarning("it shares only " + std::to_string(quality.shared_views) +
                 " views of the board with other cameras; hold it where two of them see it at the same time");
}

void warnOfRange(const Rig& rig, std::vector<std::string>& warnings) {
  for (const Camera& camera : rig.cameras)
    if (!reachesCorners(camera.lens, camera.width, camera.height))
      warnings.push_back("camera \"" + camera.name +
                         "\": its lens model ends before the image's corners, which are ignored; show it the "
                         "board there, or try another --lens");
}

void warnOfCube(const Rig& rig, std::vector<std::string>& warnings) {
  for (const Camera& camera : rig.cameras)
    if (!project(camera, rig.workspace.center))
      warnings.push_back(
          "camera \"" + camera.name +
          "\": it does not see the cube's centre; use --center X,Y,Z to move it to where all cameras look");
}

}  // namespace

void warnOfSkew(const Bundle& bundle, std::vector<std::string>& warnings) {
  std::map<int, std::set<int>> stands_of_frame;
  std::map<int, int> views_of_frame;
  for (const BundleView& view : bundle.views)
    if (view.trustedCount() > 0) {
      stands_of_frame[view.frame].insert(view.stand);
      ++views_of_frame[view.frame];
    }
  int shared = 0, torn = 0;
  for (const auto& [frame, count] : views_of_frame) {
    shared += count > 1;
    torn += stands_of_frame[frame].size() > 1;
  }
  if (10 * torn > shared)
    warnings.push_back(
        "in " + std::to_string(torn) + " of " + std::to_string(shared) +
        " frames the cameras disagree on the board's position, so they do not capture at the same time; "
        "these "
        "frames are not used for poses: hold the board still now and then, or record timestamps.csv");
}

void measure(const Bundle& bundle, Calibration& calibration) {
  const Rig& rig = calibration.rig;
  double sum = 0, corners = 0;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const CameraQuality quality = qualityOf(bundle, static_cast<int>(c), calibration);
    sum += quality.corners * quality.rms_px * quality.rms_px;
    corners += quality.corners;
    calibration.cameras.push_back(quality);
    for (std::size_t other = 0; other < c; ++other) {
      const Vec3 here = rig.cameras[c].camera_from_world.inverse().translation();
      const Vec3 there = rig.cameras[other].camera_from_world.inverse().translation();
      calibration.baselines.push_back({static_cast<int>(other), static_cast<int>(c), (here - there).norm()});
    }
  }
  if (corners > 0) calibration.rms_px = std::sqrt(sum / corners);
  calibration.scale_error_mm = scaleErrorMm(bundle, rig);
  const std::vector<int> sharers = sharersOfStands(bundle);
  for (std::size_t i = 0; i < sharers.size(); ++i)
    if (sharers[i] > 1) calibration.world_from_boards.push_back(bundle.world_from_board[i]);
}

void report(const Bundle& bundle, Calibration& calibration) {
  const Rig& rig = calibration.rig;
  measure(bundle, calibration);
  const std::vector<double> sigmas = focalSigmas(bundle);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    calibration.cameras[c].focal_sigma = sigmas[c];
    warnOfCamera(calibration.cameras[c], rig.cameras[c].name, calibration.warnings);
  }
  warnOfSkew(bundle, calibration.warnings);
  warnOfRange(rig, calibration.warnings);
  warnOfCube(rig, calibration.warnings);
}

}  // namespace airclay
