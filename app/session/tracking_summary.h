// SPDX-License-Identifier: MIT
// Summary of a run: counts, times, poses, and errors if the truth is known.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "capture/takes/player.h"
#include "capture/takes/poses_file.h"

namespace airclay {

/// Collects frames and summarizes them.
class Tracking {
 public:
  /// `recording` may be null; it may know the frame's true pose.
  void add(const PlayedFrame& frame, const Recording* recording);

  /// One per tracked frame.
  const std::vector<TimedPose>& poses() const { return poses_; }
  int lost() const { return lost_; }

  /// The keys that `track --json` documents; with a known truth also `median_error_mm` and similar.
  nlohmann::ordered_json json() const;
  /// Text for the terminal, one item per line.
  std::vector<std::string> summary() const;

 private:
  double frameMs() const;

  int frames_ = 0, tracked_ = 0, uncertain_ = 0, lost_ = 0, empty_ = 0;
  std::vector<double> frame_ms_, decode_ms_, skew_ms_, errors_mm_, errors_deg_;
  std::vector<std::pair<std::string, std::vector<double>>> stage_ms_;  ///< in pipeline order
  std::vector<TimedPose> poses_;
};

}  // namespace airclay
