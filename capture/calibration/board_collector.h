// SPDX-License-Identifier: MIT
// Selects views of a board from live cameras, and advises what to show next.
//
// A view is selected if the board is nearly at rest and its position is new. It must be at rest because
// cameras are never exactly synchronized: a moving board has a different pose in each image.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/calibration/board_coverage.h"
#include "capture/calibration/board_detector.h"
#include "capture/calibration/calibration.h"
#include "capture/cameras/live_cameras.h"

namespace airclay {

/// The views of one camera, and its progress.
struct CollectedCamera {
  std::string name;
  ImageSize size;
  std::optional<BoardView> seen;       ///< in the last set of images
  std::optional<BoardExposure> light;  ///< of the last view, also if it is not in the last set
  int views = 0;                       ///< selected views
  int shared_views = 0;                ///< selected views whose board another camera saw at the same time
  int tilted_views = 0;                ///< selected views with the board tilted by at least about 25 degrees
  BoardCoverage coverage;              ///< of the selected views
  double progress = 0;                 ///< 0 to 1: fraction of the required views

  /// The problem with the board's exposure: "too dark", "too bright", "low contrast" or "blurred"; empty if
  /// there is none.
  std::string problem() const;
};

/// The views that each camera needs.
struct RequiredViews {
  int views = kFewViews, shared = kFewShared, tilted = 6;
  double coverage = kPoorCoverage;  ///< fraction of the image

  /// If the lenses are known, and only the cameras' poses are estimated.
  static RequiredViews forPoses() { return {.views = 8, .shared = 8, .tilted = 2, .coverage = 0.1}; }
};

class BoardCollector {
 public:
  struct Options {
    /// The skew between cameras that their capture times do not show; larger if they are arrival times.
    double unseen_skew_s = 0.002;
    int threads = 2;
    RequiredViews required = {};
  };

  /// `cameras`: names and image sizes. \throw Error as checkBoard()
  BoardCollector(const Board& board, const std::vector<std::pair<std::string, ImageSize>>& cameras)
      : BoardCollector(board, cameras, Options{}) {}
  BoardCollector(const Board& board, const std::vector<std::pair<std::string, ImageSize>>& cameras,
                 const Options& options);

  /// Detects the board in one image per camera, in the cameras' order, and selects its views if they are new
  /// and the board is at rest. Skips images that are missing or of another size. \return whether the set was
  /// selected
  bool add(const LiveSet& set);
  /// Selects the last set as the one whose board defines the world. \return its frame number for
  /// CalibrationOptions::world_frame; empty if no camera saw the board in it
  std::optional<int> selectForWorld();
  /// Discards all views.
  void clear();

  const Board& board() const { return detector_.board(); }
  const std::vector<CollectedCamera>& cameras() const { return cameras_; }
  int selectedSets() const { return selected_sets_; }
  /// 0 to 1: fraction of the required views of all cameras.
  double progress() const;
  /// Whether all cameras have the required views, and shared views connect them.
  bool enough() const;
  /// What to do next, one line.
  std::string advice() const;
  /// The selected views, one element per camera; for calibrate().
  const std::vector<CameraViews>& views() const { return views_; }

  /// More sets do not improve the result measurably.
  static constexpr int kMaxSets = 400;

 private:
  bool isUsable(std::size_t camera) const;
  bool atRest(const LiveSet& set) const;
  bool isNew() const;
  void select(int number);
  double progressOf(const CollectedCamera& camera) const;
  std::vector<std::vector<int>> groups() const;

  BoardDetector detector_;
  Options options_;
  std::vector<CollectedCamera> cameras_;
  std::vector<CameraViews> views_;
  std::vector<std::vector<int>> shared_;            ///< [a][b]: views of boards that cameras a and b both saw
  std::vector<std::optional<BoardView>> previous_;  ///< views in the set before the last
  double previous_s_ = 0;                           ///< time of the last set
  int sets_ = 0, selected_sets_ = 0;
  int boardless_sets_ = 0;  ///< consecutive sets in which no camera saw the board
  int moving_sets_ = 0;     ///< consecutive sets with the board at a new position, but moving
};

}  // namespace airclay
