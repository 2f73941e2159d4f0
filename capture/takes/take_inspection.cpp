// SPDX-License-Identifier: MIT
// Opens a take camera by camera, so that an error in one does not hide errors in others.
#include "capture/takes/take_inspection.h"

#include <algorithm>
#include <set>

#include "capture/images/video_reader.h"
#include "capture/takes/image_sets.h"
#include "engine/core/error.h"
#include "engine/core/task.h"
#include "engine/silhouette/silhouette.h"

namespace airclay {
namespace {

using std::filesystem::path;
using BgrImage = std::vector<std::uint8_t>;

// Fewer pixels are noise, or a fingertip at the image's border.
constexpr std::size_t kMinSilhouettePixels = 100;
// At most this many frames of a long recording are decoded.
constexpr int kMaxFrames = 600;

ImageSize sizeOf(const Camera& camera) {
  return {camera.width, camera.height};
}

std::size_t bytesOf(const Camera& camera) {
  return std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height);
}

std::size_t countSet(const Silhouette& mask) {
  return mask.pixels.size() - std::size_t(std::count(mask.pixels.begin(), mask.pixels.end(), 0));
}

/// Whether at least two cameras have a silhouette.
bool isUsable(const SilhouetteSet& masks) {
  return std::count_if(masks.begin(), masks.end(),
                       [](const Silhouette& mask) { return countSet(mask) >= kMinSilhouettePixels; }) >= 2;
}

/// Selects `count` elements of `all`, evenly spread, in order.
std::vector<int> spread(const std::vector<int>& all, int count) {
  if (static_cast<int>(all.size()) <= count) return all;
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i)
    chosen.push_back(all[(std::size_t(2 * i + 1) * all.size()) / std::size_t(2 * count)]);
  return chosen;
}

class Inspector {
 public:
  Inspector(const path& folder, Rig& rig, const TakeInspectionOptions& options)
      : folder_(folder), rig_(rig), options_(options) {}

  TakeInspection all() {
    openFrames();
    openMasks();
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) checkSize(i);
    if (!result_.findings.empty() || options_.instants == 0) return std::move(result_);
    try {
      if (!masks_.empty())
        takeSilhouettes();
      else
        segment();
    } catch (const Error& error) {
      result_.findings.push_back(diagnosticFromError(error, folder_.string()));
    }
    return std::move(result_);
  }

 private:
  void add(const std::string& camera, const std::string& what) {
    result_.findings.push_back({Severity::kError, camera, what});
  }

  void openFrames() {
    bool has_any = false;
    for (const Camera& camera : rig_.cameras) {
      frames_.emplace_back();
      try {
        frames_.back() = airclay::openFrames(folder_, camera.name);
        has_any = has_any || frames_.back();
      } catch (const Error& error) {
        add(camera.name, error.what());
        has_any = true;
      }
    }
    if (!has_any && std::filesystem::is_directory(folder_ / "silhouettes")) return;
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) {
      const std::string& name = rig_.cameras[i].name;
      const bool is_reported =
          std::any_of(result_.findings.begin(), result_.findings.end(),
                      [&](const RigDiagnostic& finding) { return finding.camera == name; });
      if (!frames_[i] && !is_reported)
        add(name, "the take has no frames of it; expected " + name + ".mp4, .mkv or .avi, or images " + name +
                      "/000000.png, …");
    }
  }

  void openMasks() {
    if (!std::filesystem::is_directory(folder_ / "silhouettes")) return;
    for (const Camera& camera : rig_.cameras) {
      const path of_camera = folder_ / "silhouettes" / camera.name;
      masks_.emplace_back();
      if (std::filesystem::is_directory(of_camera))
        masks_.back() = numberedImages(of_camera);
      else
        add(camera.name, "the take has no masks of it; expected a folder silhouettes/" + camera.name +
                             ", which may be empty");
    }
  }

  void checkSize(std::size_t index) {
    Camera& camera = rig_.cameras[index];
    ImageSize size;
    try {
      if (frames_[index])
        size = frames_[index]->size();
      else if (!masks_.empty() && !masks_[index].empty())
        size = imageSize(masks_[index].begin()->second);
    } catch (const Error& error) {
      return add(camera.name, error.what());
    }
    if (size == ImageSize{}) return;
    if (camera.width == 0 && camera.height == 0) {
      camera.width = size.width;
      camera.height = size.height;
    }
    if (size != sizeOf(camera))
      add(camera.name, "it recorded " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                           " pixels; expected the rig's " + std::to_string(camera.width) + " x " +
                           std::to_string(camera.height));
  }

  void takeSilhouettes() {
    std::set<int> numbers;
    for (const std::map<int, path>& of_camera : masks_)
      for (const auto& [number, file] : of_camera) numbers.insert(number);
    for (const int number : spread({numbers.begin(), numbers.end()}, 4 * options_.instants)) {
      SilhouetteSet set;
      for (std::size_t i = 0; i < rig_.cameras.size(); ++i) {
        const Camera& camera = rig_.cameras[i];
        Silhouette mask{camera.width, camera.height, BgrImage(bytesOf(camera) / 3)};
        const auto found = masks_[i].find(number);
        if (found != masks_[i].end()) {
          readImage(found->second, sizeOf(camera), PixelFormat::kGrey8, mask.pixels);
          for (std::uint8_t& pixel : mask.pixels) pixel = pixel >= 128 ? 255 : 0;
        }
        set.push_back(std::move(mask));
      }
      addInstant(std::move(set));
    }
  }

  void addInstant(SilhouetteSet set) {
    if (static_cast<int>(result_.instants.size()) < options_.instants && isUsable(set))
      result_.instants.push_back(std::move(set));
  }

  /// For each camera, learns the background and then segments the chosen frames, decoded in order.
  void segment() {
    const std::vector<ImageSet> sets_by_time = matchedByTime();
    int count = sets_by_time.empty() ? kMaxFrames : static_cast<int>(sets_by_time.size());
    for (const auto& source : frames_)
      if (sets_by_time.empty()) count = std::min(count, source->frameCount());
    const bool has_background = std::filesystem::is_directory(folder_ / "background");
    const int empty = has_background ? 0 : options_.background_frames;
    result_.source = has_background ? SilhouetteSource::kKnown : SilhouetteSource::kAssumed;
    if (count <= empty)
      throw Error(folder_.string() + ": it has " + std::to_string(count) + " frames, and the first " +
                  std::to_string(empty) +
                  " are assumed to be empty; use a smaller --background or images in background/");
    std::vector<int> numbers;
    for (int frame = empty; frame < count; ++frame) numbers.push_back(frame);
    const std::vector<int> chosen = spread(numbers, 2 * options_.instants);
    std::vector<SilhouetteSet> sets(chosen.size());
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) {
      const std::vector<BackgroundPixel> background = backgroundOf(i, empty);
      for (std::size_t k = 0; k < chosen.size(); ++k) {
        BgrImage image(bytesOf(rig_.cameras[i]));
        frames_[i]->read(sets_by_time.empty() ? chosen[k] : sets_by_time[std::size_t(chosen[k])].images[i],
                         image);
        sets[k].push_back(silhouette(rig_.cameras[i], image, background));
        reportProgress(double(i * chosen.size() + k + 1) / double(chosen.size() * rig_.cameras.size()));
      }
    }
    for (SilhouetteSet& set : sets) addInstant(std::move(set));
  }

  /// The frames, if images are matched by their times; empty if by their numbers.
  std::vector<ImageSet> matchedByTime() const {
    std::vector<std::vector<double>> times_s;
    for (const auto& source : frames_) {
      times_s.push_back(source->timesS());
      if (times_s.back().empty()) return {};
    }
    if (std::filesystem::exists(folder_ / "timestamps.csv") || matchesByNumber(times_s)) return {};
    return matchImages(times_s);
  }

  std::vector<BackgroundPixel> backgroundOf(std::size_t index, int empty) {
    const Camera& camera = rig_.cameras[index];
    std::vector<BgrImage> shots(std::size_t(std::max(empty, 1)), BgrImage(bytesOf(camera)));
    if (empty == 0)
      readImage(folder_ / "background" / (camera.name + ".png"), sizeOf(camera), PixelFormat::kBgr8,
                shots[0]);
    for (int frame = 0; frame < empty; ++frame) frames_[index]->read(frame, shots[std::size_t(frame)]);
    return learnBackgroundReference(shots);
  }

  static Silhouette silhouette(const Camera& camera, const BgrImage& image,
                               const std::vector<BackgroundPixel>& background) {
    std::vector<double> scores(background.size());
    for (std::size_t i = 0; i < scores.size(); ++i)
      scores[i] = scoreReference(Vec3(image[3 * i], image[3 * i + 1], image[3 * i + 2]), background[i]);
    const Silhouette mask = majorityReference(edgesReference(camera.width, camera.height, scores));
    return closeHolesReference(largestPartReference(mask), largestHole(camera.width));
  }

  const path folder_;
  Rig& rig_;
  const TakeInspectionOptions options_;
  std::vector<std::unique_ptr<FrameSource>> frames_;  // one per camera; null if it has none
  std::vector<std::map<int, path>> masks_;            // one per camera, or empty
  TakeInspection result_;
};

}  // namespace

TakeInspection inspectTake(const path& folder, Rig& rig, const TakeInspectionOptions& options) {
  if (!std::filesystem::is_directory(folder))
    throw Error(folder.string() + ": there is no such take; expected a folder with recordings");
  return Inspector(folder, rig, options).all();
}

}  // namespace airclay
