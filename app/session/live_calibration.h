// SPDX-License-Identifier: MIT
// Calibration with live cameras: a thread collects views of the board and computes a rig on request. A window
// (studio/calibration_window.h) or a terminal shows its state.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "capture/calibration/board_collector.h"

namespace airclay {

class LiveCalibration {
 public:
  /// Computes a rig from the views, writes it, and returns lines that describe the result. `world`: the set
  /// whose board defines the world. \throw Error
  using Finish = std::function<std::vector<std::string>(const std::vector<CameraViews>& views,
                                                        std::optional<int> world)>;
  struct Options {
    Board board;
    BoardCollector::Options collector;
    Finish finish;
    std::function<void()> wake;  ///< called on the thread when the state changes; may be empty
  };

  /// `cameras` must outlive it.
  LiveCalibration(LiveCameras& cameras, const Options& options);
  /// Cancels the running calibration.
  ~LiveCalibration();
  LiveCalibration(const LiveCalibration&) = delete;
  LiveCalibration& operator=(const LiveCalibration&) = delete;

  struct State {
    std::uint64_t serial = 0;            ///< of the set; 0: none yet
    std::shared_ptr<const LiveSet> set;  ///< the last one
    std::vector<CollectedCamera> cameras;
    std::vector<CameraStatus> status;
    double share = 0;  ///< 0 to 1: fraction of the required views
    bool enough = false;
    std::string advice;  ///< what to do next
    int kept_sets = 0;
    std::optional<int> world;  ///< the set whose board defines the world
    bool ended = false;        ///< the cameras were files, which have ended
    bool working = false;      ///< a calibration is running
    double work_share = 0;
    std::vector<std::string> result;  ///< describes the last rig; empty: none yet
    std::string fault;                ///< why the last attempt failed
  };
  State state() const;

  /// Starts the calibration with the views so far; its result or error follows in state(). Collecting then
  /// continues.
  void finish() { finish_requested_ = true; }
  /// Takes the current board as the world.
  void takeWorld() { world_requested_ = true; }
  /// Discards all views.
  void restart() { restart_requested_ = true; }

 private:
  class Working;
  void run();
  void processCommands();
  void makeRig();
  void publish(std::shared_ptr<const LiveSet> set);

  LiveCameras& cameras_;
  Options options_;
  BoardCollector collector_;
  std::optional<int> world_;
  mutable std::mutex mutex_;
  State state_;
  std::atomic<bool> stop_ = false, finish_requested_ = false, world_requested_ = false,
                    restart_requested_ = false;
  std::thread thread_;
};

}  // namespace airclay
