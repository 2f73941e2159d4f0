// SPDX-License-Identifier: MIT
// Collects views of a board that is waved before cameras that run, and says what is still missing.
//
// A view is worth keeping when the board was nearly at rest (cameras are never quite in step: a board that
// moves is elsewhere in each) and when it lies elsewhere than in the views kept before.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/calibration/board_coverage.h"
#include "capture/calibration/board_detector.h"
#include "capture/calibration/calibration.h"
#include "capture/cameras/live_cameras.h"

namespace airclay {

/// How far a camera is.
struct CollectedCamera {
  std::string name;
  ImageSize size;
  std::optional<BoardView> seen;       ///< in the last set
  std::optional<BoardExposure> light;  ///< of the last view
  int views = 0;                       ///< kept
  int shared_views = 0;                ///< of them, those of boards that another camera saw at the same time
  int tilted_views = 0;  ///< of them, those in which the board was turned away by some 25 degrees
  BoardCoverage coverage;
  double share = 0;  ///< 0 to 1: of what is required

  /// What is wrong with how it sees the board, in a few words; empty: nothing.
  std::string fault() const;
};

/// What is required of a camera.
struct RequiredViews {
  int views = kFewViews, shared = kFewShared, tilted = 6;
  double coverage = kPoorCoverage;

  /// Where the lenses are known, and only the cameras' places are sought.
  static RequiredViews forPlaces() { return {.views = 8, .shared = 8, .tilted = 2, .coverage = 0.1}; }
};

class BoardCollector {
 public:
  struct Options {
    /// Where the cameras' times are those of arrival, they may be out of step by so much, unseen.
    double unseen_skew_s = 0.002;
    int threads = 2;
    RequiredViews required = {};
  };

  /// Cameras by name and size. \throw Error as checkBoard()
  BoardCollector(const Board& board, const std::vector<std::pair<std::string, ImageSize>>& cameras)
      : BoardCollector(board, cameras, Options{}) {}
  BoardCollector(const Board& board, const std::vector<std::pair<std::string, ImageSize>>& cameras,
                 const Options& options);

  /// Looks for the board in a set, an image each in the cameras' order, and keeps what is worth it. Images
  /// that are missing or of another size are passed over. \return whether it was kept
  bool add(const LiveSet& set);
  /// The last set shows the board where the world is to be. \return its number for CalibrationOptions; none
  /// when no camera saw the board in it
  std::optional<int> keepForWorld();
  /// Forgets all views.
  void clear();

  const Board& board() const { return detector_.board(); }
  const std::vector<CollectedCamera>& cameras() const { return cameras_; }
  int keptSets() const { return kept_sets_; }
  /// 0 to 1: of what is required.
  double share() const;
  bool enough() const;
  /// What to do next, a line.
  std::string advice() const;
  /// For calibrate().
  const std::vector<CameraViews>& views() const { return views_; }

  /// More sets add nothing that can be measured.
  static constexpr int kMostSets = 400;

 private:
  bool isOfUse(std::size_t camera) const;
  bool atRest(const LiveSet& set) const;
  bool isNew() const;
  void keep(int number);
  double shareOf(const CollectedCamera& camera) const;
  std::vector<std::vector<int>> groups() const;

  BoardDetector detector_;
  Options options_;
  std::vector<CollectedCamera> cameras_;
  std::vector<CameraViews> views_;
  std::vector<std::vector<int>> shared_;          ///< views that two cameras share
  std::vector<std::optional<BoardView>> before_;  ///< what was seen in the set before the last
  double before_s_ = 0;
  int sets_ = 0, kept_sets_ = 0;
  int unseen_sets_ = 0, hurried_sets_ = 0;  ///< in a row: no board; a new one, but moving
};

}  // namespace airclay
