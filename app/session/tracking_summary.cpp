// SPDX-License-Identifier: MIT
#include "app/session/tracking_summary.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/cli/command.h"
#include "capture/takes/truth.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

double worst(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

void Tracking::add(const PlayedFrame& frame, const Recording* recording) {
  ++frames_;
  if (frame.skew_s) skew_ms_.push_back(1000 * *frame.skew_s);
  decode_ms_.push_back(frame.decode_ms);
  const FrameResult& result = frame.result;
  if (frame.background || result.state() == HandState::kEmpty) {
    ++empty_;
    return;  // its times would distort the statistics
  }
  frame_ms_.push_back(result.frame_ms);
  for (const auto& [name, ms] : result.stage_ms) {
    auto stage =
        std::find_if(stage_ms_.begin(), stage_ms_.end(), [&](const auto& s) { return s.first == name; });
    if (stage == stage_ms_.end()) stage = stage_ms_.insert(stage_ms_.end(), {name, {}});
    stage->second.push_back(ms);
  }
  if (result.state() == HandState::kLost) {
    ++lost_;
    return;
  }
  ++tracked_;
  uncertain_ += result.state() == HandState::kUncertain;
  const Pose& pose = result.trackedHand()->pose.world_from_hand;
  poses_.push_back({frame.time_s, pose});
  if (!recording || !recording->truth()) return;
  const std::optional<Pose> truth = nearestPose(*recording->truth(), frame.time_s, 1 / recording->rateHz());
  if (!truth) return;
  errors_mm_.push_back(1000 * (pose.translation() - truth->translation()).norm());
  errors_deg_.push_back(angleBetween(pose.linear(), truth->linear()) * 180 / std::numbers::pi);
}

double Tracking::frameMs() const {
  return median(frame_ms_);
}

nlohmann::ordered_json Tracking::json() const {
  nlohmann::ordered_json stages = {{"silhouette", 0.0}, {"carve", 0.0}, {"fit", 0.0}};
  for (const auto& [name, ms] : stage_ms_) stages[name] = median(ms);
  nlohmann::ordered_json object = {{"frames", frames_},
                                   {"tracked", tracked_},
                                   {"uncertain", uncertain_},
                                   {"lost", lost_},
                                   {"empty", empty_},
                                   {"stage_ms", stages},
                                   {"frame_ms", frameMs()},
                                   {"decode_ms", median(decode_ms_)},
                                   {"hz", frameMs() > 0 ? 1000 / frameMs() : 0}};
  if (!skew_ms_.empty()) {
    object["skew_ms"] = median(skew_ms_);
    object["worst_skew_ms"] = worst(skew_ms_);
  }
  if (!errors_mm_.empty()) {
    object["median_error_mm"] = median(errors_mm_);
    object["worst_error_mm"] = worst(errors_mm_);
    object["median_error_deg"] = median(errors_deg_);
    object["worst_error_deg"] = worst(errors_deg_);
  }
  return object;
}

std::vector<std::string> Tracking::summary() const {
  std::vector<std::string> lines = {std::to_string(frames_) + " frames: " + std::to_string(tracked_) +
                                    " tracked, " + std::to_string(uncertain_) + " of them uncertain, " +
                                    std::to_string(lost_) + " lost, " + std::to_string(empty_) + " empty"};
  if (frameMs() > 0) {
    std::string line = fixed(frameMs(), 1) + " ms per frame, " + fixed(1000 / frameMs(), 1) + " Hz (";
    for (const auto& [name, ms] : stage_ms_) line += name + " " + fixed(median(ms), 1) + ", ";
    lines.push_back(line + "plus decoding " + fixed(median(decode_ms_), 1) + ")");
  }
  if (!skew_ms_.empty())
    lines.push_back("skew between cameras: median " + fixed(median(skew_ms_), 1) + " ms, maximum " +
                    fixed(worst(skew_ms_), 1) + " ms");
  if (!errors_mm_.empty())
    lines.push_back("pose error: median " + fixed(median(errors_mm_), 2) + " mm and " +
                    fixed(median(errors_deg_), 2) + " degrees, maximum " + fixed(worst(errors_mm_), 2) +
                    " mm and " + fixed(worst(errors_deg_), 2) + " degrees");
  return lines;
}

}  // namespace airclay
