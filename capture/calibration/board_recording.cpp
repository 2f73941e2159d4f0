// SPDX-License-Identifier: MIT
#include "capture/calibration/board_recording.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>

#include "capture/calibration/board_advice.h"
#include "capture/images/video_reader.h"
#include "capture/takes/image_sets.h"
#include "capture/takes/timestamps.h"
#include "engine/camera/camera_name.h"
#include "engine/core/error.h"
#include "engine/core/task.h"

namespace airclay {

using std::filesystem::path;

namespace {

// More frames of a waved board say nothing new, and each takes some 20 ms to search.
constexpr int kFramesLookedAt = 150;

/// cam_2 before cam_10: numbers in names count as numbers.
bool comesBefore(const std::string& a, const std::string& b) {
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (isDigit(a[i]) && isDigit(b[j])) {
      const std::size_t i_end = std::min(a.find_first_not_of("0123456789", i), a.size());
      const std::size_t j_end = std::min(b.find_first_not_of("0123456789", j), b.size());
      const std::size_t i_from = std::min(a.find_first_not_of('0', i), i_end);
      const std::size_t j_from = std::min(b.find_first_not_of('0', j), j_end);
      if (i_end - i_from != j_end - j_from) return i_end - i_from < j_end - j_from;
      const int order = a.compare(i_from, i_end - i_from, b, j_from, j_end - j_from);
      if (order != 0) return order < 0;
      i = i_end, j = j_end;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a < b;
}

std::vector<std::string> cameraNames(const path& folder) {
  std::error_code fault;
  std::filesystem::directory_iterator entries(folder, fault);
  if (fault) throw Error(folder.string() + ": there is no such folder that can be read");
  std::set<std::string> names;
  for (const std::filesystem::directory_entry& entry : entries) {
    const std::string name = entry.path().filename().string();
    std::error_code unreadable;  // a loop of symbolic links
    if (entry.is_regular_file(unreadable) && isVideoName(name)) names.insert(entry.path().stem().string());
    const bool is_of_take = name == "background" || name == "silhouettes";
    if (entry.is_directory(unreadable) && !is_of_take && !numberedImages(entry.path()).empty())
      names.insert(name);
  }
  if (names.size() < 2 || names.size() > static_cast<std::size_t>(kMaxCameras))
    throw Error(folder.string() + ": it contains the frames of " + std::to_string(names.size()) +
                (names.size() == 1 ? " camera" : " cameras") +
                "; expected NAME.mp4, .mkv or .avi, or images " + "NAME/000000.png and on, of 2 to " +
                std::to_string(kMaxCameras));
  std::vector<std::string> sorted(names.begin(), names.end());
  std::sort(sorted.begin(), sorted.end(), comesBefore);
  return sorted;
}

struct RecordedCamera {
  std::string name;
  std::unique_ptr<FrameSource> source;
  std::map<int, int> frame_of_instant;
};

std::vector<CameraViews> namesAndSizes(const std::vector<RecordedCamera>& cameras) {
  std::vector<CameraViews> named;
  for (const RecordedCamera& camera : cameras)
    named.push_back({camera.name, camera.source->size().width, camera.source->size().height, {}});
  return named;
}

/// The camera's frame nearest to each time, where there is one within half of `interval_s`.
std::map<int, int> nearestFrames(const std::vector<double>& wanted_s, const std::vector<double>& times_s,
                                 double interval_s) {
  std::map<int, int> nearest;
  for (std::size_t instant = 0; instant < wanted_s.size(); ++instant) {
    auto after = std::lower_bound(times_s.begin(), times_s.end(), wanted_s[instant]);
    if (after == times_s.end() ||
        (after != times_s.begin() && wanted_s[instant] - after[-1] < *after - wanted_s[instant]))
      --after;
    if (std::abs(*after - wanted_s[instant]) <= interval_s / 2)
      nearest[static_cast<int>(instant)] = static_cast<int>(after - times_s.begin());
  }
  return nearest;
}

/// The dictionaries of OpenCV from which boards are printed, those of few markers first.
const std::vector<std::pair<const char*, int>> kDictionaries = {
    {"4X4_50", cv::aruco::DICT_4X4_50},
    {"5X5_50", cv::aruco::DICT_5X5_50},
    {"6X6_50", cv::aruco::DICT_6X6_50},
    {"7X7_50", cv::aruco::DICT_7X7_50},
    {"4X4_250", cv::aruco::DICT_4X4_250},
    {"5X5_250", cv::aruco::DICT_5X5_250},
    {"6X6_250", cv::aruco::DICT_6X6_250},
    {"7X7_250", cv::aruco::DICT_7X7_250},
    {"4X4_1000", cv::aruco::DICT_4X4_1000},
    {"5X5_1000", cv::aruco::DICT_5X5_1000},
    {"6X6_1000", cv::aruco::DICT_6X6_1000},
    {"7X7_1000", cv::aruco::DICT_7X7_1000},
    {"APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11}};

std::string describeBoard(const Board& board) {
  const std::string squares =
      std::to_string(board.squares_x) + " x " + std::to_string(board.squares_y) + " squares";
  if (board.chessboard) return "a chessboard of " + squares;
  return std::string(board.inverted ? "an inverted" : "a") + " board of " + squares + " with markers of " +
         board.dictionary;
}

/// What markers an image shows, of any dictionary, inverted or not: a half sentence, empty without any.
std::string markersIn(const cv::Mat& grey) {
  std::string seen;
  std::size_t most = 3;  // fewer may be chance
  for (const bool inverted : {false, true}) {
    const cv::Mat shown = inverted ? cv::Mat(255 - grey) : grey;
    for (const auto& [name, number] : kDictionaries) {
      std::vector<std::vector<cv::Point2f>> outlines;
      std::vector<int> ids;
      cv::aruco::detectMarkers(shown, cv::aruco::getPredefinedDictionary(number), outlines, ids);
      if (ids.size() <= most) continue;
      most = ids.size();
      seen = std::to_string(most) + (inverted ? " inverted" : "") + " markers of " + name + ", ids up to " +
             std::to_string(*std::max_element(ids.begin(), ids.end()));
    }
  }
  return seen;
}

}  // namespace

struct BoardRecording::Parts {
  path folder;
  std::vector<RecordedCamera> cameras;
  int frame_count = 0;
  std::vector<std::string> notes;

  void matchFrames();
  std::vector<int> instantsToSearch(const BoardSearch& search) const;
  [[noreturn]] void failUnseen(const Board& board);
  void checkSize(RecordedCamera& camera, const BoardDetector& detector) const;
};

void BoardRecording::Parts::matchFrames() {
  int fewest = cameras[0].source->frameCount(), most = fewest;
  std::vector<std::string> names;
  for (const RecordedCamera& camera : cameras) {
    names.push_back(camera.name);
    fewest = std::min(fewest, camera.source->frameCount());
    most = std::max(most, camera.source->frameCount());
  }
  const path file = folder / "timestamps.csv";
  std::vector<std::vector<double>> of_camera;
  if (std::filesystem::exists(file)) {
    of_camera.resize(cameras.size());
    for (const std::vector<double>& of_frame : readFrameTimes(file, names, fewest))
      for (std::size_t c = 0; c < cameras.size(); ++c) of_camera[c].push_back(of_frame[c]);
  } else {
    for (const RecordedCamera& camera : cameras) of_camera.push_back(camera.source->timesS());
    const bool is_timed =
        std::ranges::none_of(of_camera, [](const auto& times_s) { return times_s.empty(); });
    if (!is_timed || matchesByNumber(of_camera)) of_camera.clear();
  }
  if (of_camera.empty()) {
    for (RecordedCamera& camera : cameras)
      for (int frame = 0; frame < camera.source->frameCount(); ++frame)
        camera.frame_of_instant[frame] = frame;
    frame_count = most;
    if (fewest < most)
      notes.push_back(folder.string() + ": the videos are of unequal length, " + std::to_string(fewest) +
                      " to " + std::to_string(most) + " frames; frame k of each is taken to be one instant");
    return;
  }
  std::size_t densest = 0;
  const auto meanInterval = [](const std::vector<double>& times_s) {
    return times_s.size() > 1 ? (times_s.back() - times_s.front()) / static_cast<double>(times_s.size() - 1)
                              : 1;
  };
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (meanInterval(of_camera[c]) < meanInterval(of_camera[densest])) densest = c;
  const std::vector<double>& wanted_s = of_camera[densest];
  const double interval_s = meanInterval(wanted_s);
  for (std::size_t c = 0; c < cameras.size(); ++c)
    cameras[c].frame_of_instant = nearestFrames(wanted_s, of_camera[c], interval_s);
  frame_count = static_cast<int>(wanted_s.size());
}

std::vector<int> BoardRecording::Parts::instantsToSearch(const BoardSearch& search) const {
  const int every = search.every > 0 ? search.every : (frame_count + kFramesLookedAt - 1) / kFramesLookedAt;
  std::set<int> instants;
  for (int instant = 0; instant < frame_count; instant += every) instants.insert(instant);
  if (search.also) instants.insert(*search.also);
  return {instants.begin(), instants.end()};
}

/// Searches some frames enlarged, which also finds boards that are too small to be found in the frames
/// themselves. \throw Error if those are too small.
void BoardRecording::Parts::checkSize(RecordedCamera& camera, const BoardDetector& detector) const {
  constexpr int kFramesTried = 9, kEnlarged = 3;
  const ImageSize size = camera.source->size();
  if (kEnlarged * std::max(size.width, size.height) > kMaxImageSide) return;
  cv::Mat bgr(size.height, size.width, CV_8UC3), large;
  std::vector<BoardView> views;
  for (int i = 0; i < kFramesTried; ++i) {
    camera.source->read(i * (camera.source->frameCount() - 1) / kFramesTried, {bgr.data, bgr.total() * 3});
    cv::resize(bgr, large, {}, kEnlarged, kEnlarged, cv::INTER_CUBIC);
    if (std::optional<BoardView> view =
            detector.find({large.cols, large.rows}, PixelFormat::kBgr8, {large.data, large.total() * 3}))
      views.push_back(std::move(*view));
  }
  std::vector<const BoardView*> pointers;
  for (const BoardView& view : views) pointers.push_back(&view);
  const std::optional<double> enlarged_px = markerPixels(detector.board(), pointers);
  const std::string reason =
      enlarged_px ? describeSmallBoard(detector.board(), *enlarged_px / kEnlarged) : "";
  if (!reason.empty()) throw Error(folder.string() + ": camera \"" + camera.name + "\": " + reason);
}

void BoardRecording::Parts::failUnseen(const Board& board) {
  std::string seen;
  for (RecordedCamera& camera : cameras) {
    const ImageSize size = camera.source->size();
    cv::Mat bgr(size.height, size.width, CV_8UC3), grey;
    for (const int share : {1, 2, 3}) {
      if (!seen.empty()) break;
      camera.source->read(share * (camera.source->frameCount() - 1) / 4, {bgr.data, bgr.total() * 3});
      cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
      seen = markersIn(grey);
    }
  }
  throw Error(
      folder.string() + ": no camera saw " + describeBoard(board) + "; " +
      (seen.empty()
           ? "expected the recorded board (--squares, --dictionary, --invert), large enough and well lit"
           : "the images show " + seen +
                 "; describe the board with --dictionary, --squares, --invert or --chessboard"));
}

namespace {

/// The search for a board in the frames of several cameras, by several threads, a camera each at a time.
class Search {
 public:
  Search(std::vector<RecordedCamera>& cameras, const BoardDetector& detector, std::vector<int> instants)
      : cameras_(cameras),
        detector_(detector),
        instants_(std::move(instants)),
        found_(namesAndSizes(cameras)) {}

  std::vector<CameraViews> run(int threads) {
    std::vector<std::jthread> workers;
    running_ = threads;
    for (int i = 0; i < threads; ++i) workers.emplace_back([this] { work(); });
    try {
      tellUntilDone();
    } catch (...) {
      stop_ = true;
      throw;  // the threads end with the frame that they are at
    }
    workers.clear();
    if (fault_) std::rethrow_exception(fault_);
    return std::move(found_);
  }

 private:
  void tellUntilDone() {
    const double total = static_cast<double>(cameras_.size() * instants_.size());
    std::unique_lock lock(mutex_);
    while (running_ > 0) {
      changed_.wait_for(lock, std::chrono::milliseconds(50));
      lock.unlock();
      reportProgress(done_ / total);
      lock.lock();
    }
  }

  void work() {
    try {
      for (std::size_t camera = next_++; camera < cameras_.size(); camera = next_++) searchCamera(camera);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!fault_) fault_ = std::current_exception();
      stop_ = true;
    }
    const std::lock_guard lock(mutex_);
    --running_;
    changed_.notify_all();
  }

  void searchCamera(std::size_t index) {
    RecordedCamera& camera = cameras_[index];
    const ImageSize size = camera.source->size();
    std::vector<std::uint8_t> bgr(static_cast<std::size_t>(size.width) *
                                  static_cast<std::size_t>(size.height) * 3);
    for (const int instant : instants_) {
      if (stop_) return;
      const auto frame = camera.frame_of_instant.find(instant);
      if (frame != camera.frame_of_instant.end()) {
        camera.source->read(frame->second, bgr);
        if (std::optional<BoardView> view = detector_.find(size, PixelFormat::kBgr8, bgr))
          found_[index].views[instant] = std::move(*view);
      }
      ++done_;
    }
  }

  std::vector<RecordedCamera>& cameras_;
  const BoardDetector& detector_;
  const std::vector<int> instants_;
  std::vector<CameraViews> found_;
  std::atomic<std::size_t> next_{0};
  std::atomic<int> done_{0};
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  int running_ = 0;
  std::exception_ptr fault_;
};

}  // namespace

BoardRecording::BoardRecording(const path& folder) : parts_(std::make_unique<Parts>()) {
  parts_->folder = folder;
  for (const std::string& name : cameraNames(folder))
    parts_->cameras.push_back({name, openFrames(folder, name), {}});
  parts_->matchFrames();
}

BoardRecording::~BoardRecording() = default;

int BoardRecording::frameCount() const {
  return parts_->frame_count;
}
std::vector<CameraViews> BoardRecording::cameras() const {
  return namesAndSizes(parts_->cameras);
}
const std::vector<std::string>& BoardRecording::notes() const {
  return parts_->notes;
}

std::vector<CameraViews> BoardRecording::findBoards(const BoardDetector& detector,
                                                    const BoardSearch& search) {
  if (search.also && *search.also >= parts_->frame_count)
    throw Error(parts_->folder.string() + ": there is no frame " + std::to_string(*search.also) +
                "; expected 0 to " + std::to_string(parts_->frame_count - 1));
  std::vector<CameraViews> found =
      Search(parts_->cameras, detector, parts_->instantsToSearch(search)).run(search.threads);
  for (std::size_t c = 0; c < found.size(); ++c)
    if (static_cast<int>(found[c].views.size()) < kFewestViews)
      parts_->checkSize(parts_->cameras[c], detector);
  if (std::all_of(found.begin(), found.end(), [](const CameraViews& camera) { return camera.views.empty(); }))
    parts_->failUnseen(detector.board());
  return found;
}

}  // namespace airclay
