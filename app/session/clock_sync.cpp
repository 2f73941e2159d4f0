// SPDX-License-Identifier: MIT
#include "app/session/clock_sync.h"

#include "app/cli/progress.h"
#include "capture/takes/player.h"

namespace airclay {
namespace {

// Ignore smaller silhouettes: a finger at the image's edge, or noise.
constexpr std::size_t kLeastPixels = 100;

/// The centroid of a silhouette; nullopt if it is too small.
std::optional<Vec2> centroidOf(const Silhouette& mask) {
  Vec2 sum = Vec2::Zero();
  std::size_t count = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask.contains(x, y)) {
        sum += Vec2(x, y);
        ++count;
      }
  if (count < kLeastPixels) return std::nullopt;
  return sum / static_cast<double>(count);
}

/// The motion that each camera saw, on its own clock.
std::vector<MotionSeries> motionIn(Gpu& gpu, Take& take, int voxels, bool shows_progress) {
  Pipeline pipeline(gpu, take.rig(), builtInHand(false),
                    {voxels, SilhouetteMethod::kPaper, FitMethod::kPaper});
  Player player(take, pipeline);
  std::vector<MotionSeries> series(take.rig().cameras.size());
  Progress progress("tracking the hand", take.frameCount(), shows_progress);
  for (int frame = 0; const std::optional<PlayedFrame> played = player.next(); ++frame) {
    progress.advance();
    if (played->background) continue;
    std::vector<double> times_s = take.cameraTimesOf(played->frame);
    if (times_s.empty()) times_s.assign(series.size(), take.timeOf(played->frame));
    const std::vector<Silhouette> masks = pipeline.gpuRig().unpack(pipeline.silhouettes().masks().host());
    for (std::size_t c = 0; c < series.size(); ++c) {
      if (take.missingCameras() >> c & 1) continue;
      const std::optional<Vec2> centroid = centroidOf(masks[c]);
      if (!centroid || (!series[c].times_s.empty() && times_s[c] <= series[c].times_s.back())) continue;
      series[c].times_s.push_back(times_s[c]);
      series[c].centroid_px.push_back(*centroid);
    }
  }
  return series;
}

}  // namespace

ClockOffsets offsetsFromMotion(Gpu& gpu, Take& take, int voxels, bool shows_progress) {
  return estimateClockOffsets(take.rig(), motionIn(gpu, take, voxels, shows_progress));
}

}  // namespace airclay
