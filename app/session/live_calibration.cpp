// SPDX-License-Identifier: MIT
#include "app/session/live_calibration.h"

#include "engine/core/error.h"
#include "engine/core/task.h"

namespace airclay {
namespace {

constexpr double kLookUpS = 0.1;

struct Left {};  // thrown to cancel the calibration

std::vector<std::pair<std::string, ImageSize>> sizesOf(const LiveCameras& cameras) {
  std::vector<std::pair<std::string, ImageSize>> sizes;
  for (const CameraStatus& camera : cameras.status()) sizes.emplace_back(camera.name, camera.size);
  return sizes;
}

}  // namespace

/// Reports the calibration's progress.
class LiveCalibration::Working : public Task {
 public:
  explicit Working(LiveCalibration& live) : live_(live) { show(true, 0); }
  ~Working() override { show(false, 0); }
  void onProgress(double share) override {
    if (live_.stop_) throw Left{};
    show(true, share);
  }

 private:
  void show(bool working, double share) {
    {
      const std::lock_guard lock(live_.mutex_);
      live_.state_.working = working;
      live_.state_.work_share = share;
    }
    if (live_.options_.wake) live_.options_.wake();
  }
  LiveCalibration& live_;
};

LiveCalibration::LiveCalibration(LiveCameras& cameras, const Options& options)
    : cameras_(cameras),
      options_(options),
      collector_(options.board, sizesOf(cameras), options.collector),
      thread_([this] { run(); }) {}

LiveCalibration::~LiveCalibration() {
  stop_ = true;
  thread_.join();
}

LiveCalibration::State LiveCalibration::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void LiveCalibration::run() {
  while (!stop_) {
    std::optional<LiveSet> set = cameras_.next(kLookUpS);
    if (set) collector_.add(*set);
    processCommands();
    publish(set ? std::make_shared<LiveSet>(std::move(*set)) : nullptr);
    // ended files give no set and do not wait
    if (!set && cameras_.ended()) std::this_thread::sleep_for(std::chrono::duration<double>(kLookUpS));
  }
}

void LiveCalibration::processCommands() {
  if (restart_requested_.exchange(false)) {
    collector_.clear();
    world_.reset();
    const std::lock_guard lock(mutex_);
    state_.result.clear();
    state_.fault.clear();
  }
  if (world_requested_.exchange(false)) {
    const std::optional<int> world = collector_.selectForWorld();
    if (world) world_ = world;
    const std::lock_guard lock(mutex_);
    state_.fault =
        world ? "" : "no camera sees the board that is to define the world; place it where one does";
  }
  if (finish_requested_.exchange(false)) makeRig();
}

void LiveCalibration::makeRig() {
  std::vector<std::string> result;
  std::string fault;
  try {
    const Working working(*this);
    result = options_.finish(collector_.views(), world_);
  } catch (const Left&) {
    return;
  } catch (const std::exception& error) {
    fault = error.what();
  }
  const std::lock_guard lock(mutex_);
  if (fault.empty()) state_.result = std::move(result);  // on failure, the previous rig stays in its file
  state_.fault = std::move(fault);
}

void LiveCalibration::publish(std::shared_ptr<const LiveSet> set) {
  {
    const std::lock_guard lock(mutex_);
    if (set) {
      state_.set = std::move(set);
      ++state_.serial;
    }
    state_.cameras = collector_.cameras();
    state_.status = cameras_.status();
    state_.share = collector_.progress();
    state_.enough = collector_.enough();
    state_.advice = collector_.advice();
    state_.kept_sets = collector_.selectedSets();
    state_.world = world_;
    state_.ended = cameras_.ended();
  }
  if (options_.wake) options_.wake();
}

}  // namespace airclay
