// SPDX-License-Identifier: MIT
// The files of a take, and the checks that they are consistent.
#include "capture/takes/take.h"

#include <algorithm>
#include <stdexcept>

#include "capture/images/video_reader.h"
#include "capture/takes/image_sets.h"
#include "capture/takes/rig_opencv.h"
#include "capture/takes/timestamps.h"
#include "engine/core/error.h"

namespace airclay {

using std::filesystem::path;

struct Take::Parts {
  path folder;
  TakeOptions options;
  path rig_file;
  Rig rig;
  std::vector<std::unique_ptr<FrameSource>> frames;  // one per camera, or empty
  std::vector<std::map<int, path>> masks;            // one per camera, or empty
  bool has_background = false;
  std::vector<ImageSet> sets;  // if images are matched by time; otherwise frame k is image k of every camera
  std::uint32_t missing_cameras = 0;       // in the frame that was read last
  std::vector<std::vector<double>> times;  // per frame, per camera; empty without timestamps.csv
  double seconds_per_frame = 1.0 / 30;
  int frame_count = 0;
  std::optional<std::vector<TimedPose>> truth;
  std::optional<std::string> note;

  void openRig();
  void openFrames();
  void openMasks();
  void openBackground();
  void fillSizes();
  void checkSizes() const;
  void countFrames();
  void openTimes();
  void matchByTime();
  std::vector<double> offsets() const;
  std::vector<std::vector<double>> imageTimes() const;
};

namespace {

ImageSize sizeOf(const Camera& camera) {
  return {camera.width, camera.height};
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value / static_cast<double>(values.size());
  return sum;
}

std::string text(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height) + " pixels";
}

void checkBuffers(const Rig& rig, Take::Buffers buffers, size_t bytes_per_pixel) {
  bool fits = buffers.size() == rig.cameras.size();
  for (size_t i = 0; fits && i < buffers.size(); ++i)
    fits = buffers[i].size() == static_cast<size_t>(rig.cameras[i].width) *
                                    static_cast<size_t>(rig.cameras[i].height) * bytes_per_pixel;
  if (!fits) throw std::logic_error("Take: the buffers do not have the rig's sizes");
}

/// A mask of 0 and 1 would be a silhouette of very low probability.
void checkRange(std::span<const std::uint8_t> mask, const path& file) {
  const std::uint8_t brightest = *std::max_element(mask.begin(), mask.end());
  if (brightest == 1)
    throw Error(file.string() + ": the mask's largest value is 1; expected 255 for the object");
}

}  // namespace

void Take::Parts::openRig() {
  const std::optional<path> found = rigFileIn(folder);
  if (!found)
    throw Error(folder.string() +
                ": the take has no rig; expected rig.toml, camera_array.toml, or intri.yml with extri.yml");
  rig_file = *found;
  rig = readAnyRig(rig_file, options.units).validRig();
}

void Take::Parts::openFrames() {
  std::string missing;
  for (const Camera& camera : rig.cameras) {
    std::unique_ptr<FrameSource> source = airclay::openFrames(folder, camera.name, options.unfinished);
    if (source)
      frames.push_back(std::move(source));
    else if (missing.empty())
      missing = camera.name;
  }
  const bool may_lack_all = frames.empty() && std::filesystem::is_directory(folder / "silhouettes");
  if (!missing.empty() && !may_lack_all)
    throw Error(folder.string() + ": camera \"" + missing + "\" has no frames; expected " + missing +
                ".mp4, .mkv or .avi, or images " + missing + "/000000.png, …");
}

void Take::Parts::openMasks() {
  if (!std::filesystem::is_directory(folder / "silhouettes")) return;
  for (const Camera& camera : rig.cameras) {
    const path masks_folder = folder / "silhouettes" / camera.name;
    if (!std::filesystem::is_directory(masks_folder))
      throw Error(masks_folder.string() + ": camera \"" + camera.name +
                  "\" has no masks; expected a folder, which may be empty");
    masks.push_back(numberedImages(masks_folder));
  }
}

void Take::Parts::openBackground() {
  has_background = !frames.empty() && std::filesystem::is_directory(folder / "background");
  if (!has_background) return;
  for (const Camera& camera : rig.cameras) {
    const path file = folder / "background" / (camera.name + ".png");
    if (!std::filesystem::exists(file))
      throw Error(file.string() + ": camera \"" + camera.name +
                  "\" has no background image; expected one per camera");
    if (const ImageSize size = imageSize(file); size != sizeOf(camera))
      throw Error(file.string() + ": the image is " + text(size) + "; expected the rig's " +
                  text(sizeOf(camera)));
  }
}

/// Takes image sizes that the rig file does not state from the first image.
void Take::Parts::fillSizes() {
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    Camera& camera = rig.cameras[i];
    if (camera.width > 0 && camera.height > 0) continue;
    ImageSize size;
    if (!frames.empty())
      size = frames[i]->size();
    else if (!masks[i].empty())
      size = imageSize(masks[i].begin()->second);
    camera.width = size.width;
    camera.height = size.height;
  }
  checkRig(rig, rig_file);
}

void Take::Parts::checkSizes() const {
  for (size_t i = 0; i < frames.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    const ImageSize size = frames[i]->size();
    if (size == sizeOf(camera)) continue;
    const bool is_rotated = size == ImageSize{camera.height, camera.width};
    throw Error(folder.string() + ": camera \"" + camera.name + "\" recorded " + text(size) +
                "; expected the rig's " + text(sizeOf(camera)) +
                (is_rotated ? " (the recording is rotated by 90° against the calibration)" : ""));
  }
}

void Take::Parts::countFrames() {
  if (frames.empty()) {
    for (const std::map<int, path>& of_camera : masks)
      if (!of_camera.empty()) frame_count = std::max(frame_count, of_camera.rbegin()->first + 1);
    if (frame_count == 0) throw Error(folder.string() + ": the take is empty; expected frames or masks");
    return;
  }
  const auto shorter = [](const auto& a, const auto& b) { return a->frameCount() < b->frameCount(); };
  const auto [shortest, longest] = std::minmax_element(frames.begin(), frames.end(), shorter);
  frame_count = (*shortest)->frameCount();
  if (frame_count == (*longest)->frameCount()) return;
  const auto nameOf = [&](auto place) {
    return rig.cameras[static_cast<size_t>(place - frames.begin())].name;
  };
  note = folder.string() + ": the recordings have unequal length; stopping at the shortest: camera \"" +
         nameOf(shortest) + "\" has " + std::to_string(frame_count) + " frames, \"" + nameOf(longest) +
         "\" " + std::to_string((*longest)->frameCount());
}

void Take::Parts::openTimes() {
  if (!frames.empty()) {
    seconds_per_frame = 0;
    for (const std::unique_ptr<FrameSource>& source : frames)
      seconds_per_frame += 1 / source->rateHz() / static_cast<double>(frames.size());
  }
  const path file = folder / "timestamps.csv";
  if (!std::filesystem::exists(file)) return;
  std::vector<std::string> names;
  for (const Camera& camera : rig.cameras) names.push_back(camera.name);
  times = readFrameTimes(file, names, frame_count, options.unfinished);
  frame_count = std::min(frame_count, static_cast<int>(times.size()));
  if (times.size() > 1)
    seconds_per_frame = (mean(times.back()) - mean(times.front())) / static_cast<double>(times.size() - 1);
}

/// One offset per camera, seconds.
std::vector<double> Take::Parts::offsets() const {
  for (const auto& [name, offset_s] : options.offsets_s)
    if (std::ranges::find(rig.cameras, name, &Camera::name) == rig.cameras.end())
      throw Error(folder.string() + ": --offset names camera \"" + name + "\", which the rig does not have",
                  Fault::kUsage);
  std::vector<double> of_cameras;
  for (const Camera& camera : rig.cameras) {
    const auto found = options.offsets_s.find(camera.name);
    of_cameras.push_back(found == options.offsets_s.end() ? 0 : found->second);
  }
  return of_cameras;
}

/// When each camera took its images: by timestamps.csv, by the videos, or at a constant rate.
std::vector<std::vector<double>> Take::Parts::imageTimes() const {
  std::vector<std::vector<double>> of_cameras(frames.size());
  for (size_t c = 0; c < frames.size(); ++c) {
    for (const std::vector<double>& of_frame : times) of_cameras[c].push_back(of_frame[c]);
    if (times.empty()) of_cameras[c] = frames[c]->timesS();
    for (int k = 0; of_cameras[c].empty() && k < frames[c]->frameCount(); ++k)
      of_cameras[c].push_back(k / frames[c]->rateHz());
  }
  return of_cameras;
}

/// Matches images by their times if equal numbers do not mean equal times.
void Take::Parts::matchByTime() {
  const std::vector<double> offsets_s = offsets();
  const bool has_offset = std::ranges::any_of(offsets_s, [](double offset_s) { return offset_s != 0; });
  if (frames.empty() || !masks.empty()) {
    if (has_offset)
      throw Error(folder.string() + ": --offset does not apply to masks, which have no timestamps",
                  Fault::kUsage);
    return;
  }
  if (!times.empty() && !has_offset) return;  // the rows of timestamps.csv are frames
  std::vector<std::vector<double>> of_cameras = imageTimes();
  for (size_t c = 0; c < of_cameras.size(); ++c)
    for (double& time_s : of_cameras[c]) time_s -= offsets_s[c];
  if (matchesByNumber(of_cameras)) return;

  sets = matchImages(of_cameras);
  if (sets.empty())
    throw Error(
        folder.string() +
        ": at no instant does every camera have an image; expected recordings of the same time, or --offset "
        "NAME=MS with how late each camera's timestamps are");
  sets.resize(std::min(sets.size(), static_cast<size_t>(options.max_frames)));
  frame_count = static_cast<int>(sets.size());
  times.clear();
  for (const ImageSet& set : sets) times.push_back(set.times_s);
  if (sets.size() > 1)
    seconds_per_frame = (mean(times.back()) - mean(times.front())) / static_cast<double>(sets.size() - 1);
  std::string missing;
  for (size_t c = 0; c < rig.cameras.size(); ++c) {
    const auto count =
        std::ranges::count_if(sets, [&](const ImageSet& set) { return set.missing_cameras >> c & 1; });
    if (count > 0)
      missing += "; camera \"" + rig.cameras[c].name + "\" has no image in " + std::to_string(count);
  }
  note = folder.string() + ": images are matched by their timestamps: " + std::to_string(frame_count) +
         " frames" + missing;
}

Take::Take(const path& folder, const TakeOptions& options) : parts_(std::make_unique<Parts>()) {
  if (!std::filesystem::is_directory(folder))
    throw Error(folder.string() + ": there is no such take; expected a folder with rig.toml and recordings");
  parts_->folder = folder;
  parts_->options = options;
  parts_->openRig();
  parts_->openFrames();
  parts_->openMasks();
  parts_->fillSizes();
  parts_->checkSizes();
  parts_->openBackground();
  parts_->countFrames();
  parts_->frame_count = std::min(parts_->frame_count, options.max_frames);
  parts_->openTimes();
  parts_->matchByTime();
  const path truth = folder / "truth.tum";
  if (std::filesystem::exists(truth)) parts_->truth = readPoses(truth);
}

Take::~Take() = default;
Take::Take(Take&&) noexcept = default;
Take& Take::operator=(Take&&) noexcept = default;

const Rig& Take::rig() const {
  return parts_->rig;
}
int Take::frameCount() const {
  return parts_->frame_count;
}
double Take::rateHz() const {
  return 1 / parts_->seconds_per_frame;
}

double Take::timeOf(int frame) const {
  return parts_->times.empty() ? frame * parts_->seconds_per_frame
                               : mean(parts_->times.at(static_cast<size_t>(frame)));
}
std::vector<double> Take::cameraTimesOf(int frame) const {
  return parts_->times.empty() ? std::vector<double>{} : parts_->times.at(static_cast<size_t>(frame));
}

std::uint32_t Take::missingCameras() const {
  return parts_->missing_cameras;
}

bool Take::hasImages() const {
  return !parts_->frames.empty();
}
bool Take::hasSilhouettes() const {
  return !parts_->masks.empty();
}
bool Take::hasBackground() const {
  return parts_->has_background;
}

int Take::backgroundFrames() const {
  return hasSilhouettes() || hasBackground() ? 0 : parts_->options.background_frames;
}

bool Take::readImages(int frame, Buffers bgr) {
  checkBuffers(parts_->rig, bgr, 3);
  if (frame < 0 || frame >= parts_->frame_count) return false;
  // One camera after another: FFmpeg's own threads already use all cores.
  const ImageSet* set = parts_->sets.empty() ? nullptr : &parts_->sets[static_cast<size_t>(frame)];
  for (size_t i = 0; i < parts_->frames.size(); ++i)
    parts_->frames[i]->read(set ? set->images[i] : frame, bgr[i]);
  parts_->missing_cameras = set ? set->missing_cameras : 0;
  return true;
}

bool Take::readSilhouettes(int frame, Buffers masks) {
  checkBuffers(parts_->rig, masks, 1);
  if (frame < 0 || frame >= parts_->frame_count) return false;
  for (size_t i = 0; i < parts_->masks.size(); ++i) {
    const auto found = parts_->masks[i].find(frame);
    if (found == parts_->masks[i].end()) {
      std::fill(masks[i].begin(), masks[i].end(), std::uint8_t{0});
      continue;
    }
    readImage(found->second, sizeOf(parts_->rig.cameras[i]), PixelFormat::kGrey8, masks[i]);
    checkRange(masks[i], found->second);
  }
  return true;
}

void Take::readBackground(Buffers bgr) const {
  checkBuffers(parts_->rig, bgr, 3);
  for (size_t i = 0; i < parts_->rig.cameras.size(); ++i) {
    const Camera& camera = parts_->rig.cameras[i];
    readImage(parts_->folder / "background" / (camera.name + ".png"), sizeOf(camera), PixelFormat::kBgr8,
              bgr[i]);
  }
}

const std::optional<std::vector<TimedPose>>& Take::truth() const {
  return parts_->truth;
}
const std::optional<std::string>& Take::note() const {
  return parts_->note;
}

}  // namespace airclay
