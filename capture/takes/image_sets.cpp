// SPDX-License-Identifier: MIT
#include "capture/takes/image_sets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/images/video_index.h"
#include "capture/takes/frame_matcher.h"

namespace airclay {
namespace {

double shortestInterval(const std::vector<std::vector<double>>& camera_times_s) {
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& times_s : camera_times_s)
    if (times_s.size() > 1) shortest_s = std::min(shortest_s, medianInterval(times_s));
  return std::isfinite(shortest_s) ? shortest_s : 1.0 / 30;
}

}  // namespace

std::vector<ImageSet> matchImages(const std::vector<std::vector<double>>& camera_times_s) {
  const std::size_t cameras = camera_times_s.size();
  FrameMatcher::Options options;
  options.max_skew_s = 0.5 * shortestInterval(camera_times_s);
  options.queue_frames = std::numeric_limits<std::size_t>::max();
  FrameMatcher matcher(cameras, options);
  for (std::size_t c = 0; c < cameras; ++c)
    for (std::size_t i = 0; i < camera_times_s[c].size(); ++i) matcher.add(c, camera_times_s[c][i], i);

  std::vector<ImageSet> sets;
  std::size_t complete = 0;  // number of sets up to the last complete one
  while (const auto found = matcher.next(std::numeric_limits<double>::infinity())) {
    if (sets.empty() && !found->complete) continue;
    double sum_s = 0;
    int count = 0;
    for (std::size_t c = 0; c < cameras; ++c)
      if (found->ids[c]) sum_s += found->times_s[c], ++count;
    ImageSet set;
    for (std::size_t c = 0; c < cameras; ++c) {
      if (!found->ids[c]) set.missing_cameras |= 1u << c;
      set.times_s.push_back(found->ids[c] ? found->times_s[c] : sum_s / count);
      set.images.push_back(found->ids[c] ? static_cast<int>(*found->ids[c]) : sets.back().images[c]);
    }
    sets.push_back(std::move(set));
    if (found->complete) complete = sets.size();
  }
  sets.resize(complete);
  return sets;
}

bool matchesByNumber(const std::vector<std::vector<double>>& camera_times_s) {
  const double interval_s = shortestInterval(camera_times_s);
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const std::vector<double>& times_s : camera_times_s) fewest = std::min(fewest, times_s.size());
  if (fewest == 0) return true;
  const std::vector<double>& first = camera_times_s.front();
  const double mean_s =
      fewest > 1 ? (first[fewest - 1] - first[0]) / static_cast<double>(fewest - 1) : interval_s;
  for (const std::vector<double>& times_s : camera_times_s)
    for (std::size_t k = 0; k < fewest; ++k)
      if (std::abs(times_s[k] - first[0] - static_cast<double>(k) * mean_s) > 0.25 * interval_s) return false;
  return true;
}

}  // namespace airclay
