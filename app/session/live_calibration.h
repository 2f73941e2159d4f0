// SPDX-License-Identifier: MIT
// Calibrating with cameras that run: a thread collects views of the board, and makes a rig of them when told
// to. A window (studio/calibration_window.h) or a terminal looks on.
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
  /// Makes a rig of the views, keeps it, and says in a few lines what came of it. `world`: the set in which
  /// the board lay where the world is to be. \throw Error
  using Finish = std::function<std::vector<std::string>(const std::vector<CameraViews>& views,
                                                        std::optional<int> world)>;
  struct Options {
    Board board;
    BoardCollector::Options collector;
    Finish finish;
    std::function<void()> wake;  ///< called from the thread when something has changed; may be empty
  };

  /// `cameras` must outlive it.
  LiveCalibration(LiveCameras& cameras, const Options& options);
  /// Leaves the work under way.
  ~LiveCalibration();
  LiveCalibration(const LiveCalibration&) = delete;
  LiveCalibration& operator=(const LiveCalibration&) = delete;

  struct State {
    std::uint64_t serial = 0;            ///< of the set; 0: none yet
    std::shared_ptr<const LiveSet> set;  ///< the last one
    std::vector<CollectedCamera> cameras;
    std::vector<CameraStatus> status;
    double share = 0;  ///< 0 to 1: of what a calibration wants
    bool enough = false;
    std::string advice;  ///< what to do next
    int kept_sets = 0;
    std::optional<int> world;  ///< the set in which the board lies where the world is to be
    bool ended = false;        ///< the cameras were files, and these are over
    bool working = false;      ///< the rig is being made
    double work_share = 0;
    std::vector<std::string> result;  ///< what came of the last rig that was made; empty: none yet
    std::string fault;                ///< why nothing came of the last attempt
  };
  State state() const;

  /// Makes the rig of what there is; its result or fault follows. Collecting goes on afterwards.
  void finish() { finish_requested_ = true; }
  /// The board lies where the world is to be.
  void takeWorld() { world_requested_ = true; }
  /// All views are forgotten.
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
