// SPDX-License-Identifier: MIT
// HuffYUV in Matroska through OpenCV's FFmpeg backend: the fastest lossless codec that it writes, and a
// truncated file can be read up to its last complete frame.
#include "capture/takes/take_writer.h"

#include <condition_variable>
#include <deque>
#include <fstream>
#include <future>
#include <mutex>
#include <opencv2/videoio.hpp>
#include <optional>
#include <thread>

#include "capture/images/image_file.h"
#include "capture/images/quiet_opencv.h"
#include "engine/core/clock.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

using std::filesystem::path;
using Bytes = std::vector<std::uint8_t>;

constexpr const char* kVideoExtension = ".mkv";
// The files must grow within this many sets, because OpenCV does not report write errors.
constexpr int kGrowthSets = 30;

/// Free disk space; unlimited if it is unknown.
std::uintmax_t freeBytesOnDisk(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  return error ? UINTMAX_MAX : space.available;
}

ImageSize sizeOf(const Camera& camera) {
  return {camera.width, camera.height};
}

/// OpenCV's writer crops odd sides.
bool fitsVideo(const Camera& camera) {
  return camera.width % 2 == 0 && camera.height % 2 == 0;
}

Bytes rgbaOf(const Bytes& bytes, int channels) {
  Bytes rgba;
  rgba.reserve(bytes.size() / std::size_t(channels) * 4);
  for (std::size_t i = 0; i + std::size_t(channels) <= bytes.size(); i += std::size_t(channels)) {
    const std::uint8_t *b = &bytes[i], last = channels == 3 ? b[2] : b[0];
    rgba.insert(rgba.end(), {last, channels == 3 ? b[1] : b[0], b[0], 255});
  }
  return rgba;
}

std::string numbered(int frame) {
  const std::string digits = std::to_string(frame);
  return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".png";
}

std::size_t bytesOf(const RecordedSet& set) {
  std::size_t bytes = 0;
  for (const Bytes& one : set.bytes) bytes += one.size();
  return bytes;
}

void createEmptyFolder(const path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error))
    throw Error(folder.string() + ": the folder for the recording cannot be created" +
                (error ? ": " + error.message() : ""));
  if (!std::filesystem::is_empty(folder, error) || error)
    throw Error(folder.string() + ": the folder is not empty; use a new folder for the recording");
}

}  // namespace

struct TakeWriter::Parts {
  path folder;
  Rig rig;
  Options options;
  std::vector<cv::VideoWriter> videos;  ///< one per camera; closed if its images are files
  std::ofstream timestamps;
  std::vector<double> last_times_s;
  double time_shift_s = 0;  ///< added to the times after they ran backwards

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<RecordedSet> queue;
  std::size_t queued_bytes = 0;
  bool stopping = false;
  Status status;
  std::uint64_t previous_bytes = 0;  ///< of all files, kGrowthSets sets ago
  std::thread thread;

  bool masks() const { return options.content == Content::kMasks; }
  void open();
  void run();
  void writeSet(const RecordedSet& set, int frame);
  void writeImage(std::size_t camera, const Bytes& bytes, int frame);
  void writeTimes(const std::vector<double>& times_s);
  std::uint64_t bytesOfFiles() const;
  void checkFreeSpace(int frame);
  void end();
};

void TakeWriter::Parts::open() {
  quietOpenCv();
  createEmptyFolder(folder);
  if (options.writes_rig) writeRig(folder / "rig.toml", rig, RotationFormat::kMatrices);
  if (options.content == Content::kNothing) return;
  videos.resize(rig.cameras.size());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Camera& camera = rig.cameras[c];
    if (masks() || !fitsVideo(camera)) {
      std::filesystem::create_directories(masks() ? folder / "silhouettes" / camera.name
                                                  : folder / camera.name);
      continue;
    }
    const path file = folder / (camera.name + kVideoExtension);
    const int huffyuv = cv::VideoWriter::fourcc('H', 'F', 'Y', 'U');
    if (!videos[c].open(file.string(), cv::CAP_FFMPEG, huffyuv, options.rate_hz,
                        {camera.width, camera.height}))
      throw Error(file.string() +
                  ": the video cannot be written; expected an OpenCV whose FFmpeg has HuffYUV");
  }
}

void TakeWriter::Parts::run() {
  for (;;) {
    RecordedSet set;
    int frame = 0;
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return stopping || !queue.empty(); });
      if (queue.empty()) return;
      set = std::move(queue.front());
      queue.pop_front();
      frame = status.sets;
    }
    std::string fault;
    try {
      if (status.fault.empty()) writeSet(set, frame);
    } catch (const std::exception& error) {
      fault = error.what();
    }
    const std::lock_guard lock(mutex);
    queued_bytes -= bytesOf(set);  // only now: the set needs its memory while it is written
    if (!fault.empty()) status.fault = fault;
    if (status.fault.empty()) ++status.sets;
    changed.notify_all();
  }
}

void TakeWriter::Parts::writeSet(const RecordedSet& set, int frame) {
  checkFreeSpace(frame);
  // All cameras in parallel: one core barely encodes four of 640 x 480 at 30 Hz (3 ms per image).
  std::vector<std::future<void>> writing;
  for (std::size_t c = 0; c < set.bytes.size(); ++c)
    writing.push_back(std::async(std::launch::async, [&, c] { writeImage(c, set.bytes[c], frame); }));
  for (std::future<void>& one : writing) one.get();
  // After the images: a row implies that they are written.
  if (!set.camera_times_s.empty()) writeTimes(set.camera_times_s);
}

void TakeWriter::Parts::writeImage(std::size_t camera, const Bytes& bytes, int frame) {
  const Camera& of = rig.cameras[camera];
  if (masks()) {
    writePng(folder / "silhouettes" / of.name / numbered(frame), sizeOf(of), rgbaOf(bytes, 1));
  } else if (videos[camera].isOpened()) {
    // OpenCV only reads the data, but cv::Mat cannot wrap const memory.
    videos[camera].write(cv::Mat(of.height, of.width, CV_8UC3, const_cast<std::uint8_t*>(bytes.data())));
  } else {
    writePng(folder / of.name / numbered(frame), sizeOf(of), rgbaOf(bytes, 3));
  }
}

void TakeWriter::Parts::writeTimes(const std::vector<double>& times_s) {
  if (!timestamps.is_open()) {
    timestamps.open(folder / "timestamps.csv");
    timestamps << "cam_id,frame_time\n";
  }
  for (std::size_t c = 0; c < times_s.size() && !last_times_s.empty(); ++c)
    if (times_s[c] + time_shift_s <= last_times_s[c])
      time_shift_s = last_times_s[c] - times_s[c] + 1 / options.rate_hz;
  last_times_s.clear();
  for (std::size_t c = 0; c < times_s.size(); ++c) {
    last_times_s.push_back(times_s[c] + time_shift_s);
    timestamps << rig.cameras[c].name << ',' << exactNumber(last_times_s.back()) << '\n';
  }
  if (!timestamps.flush())
    throw Error((folder / "timestamps.csv").string() + ": cannot be written; is the disk full?");
}

std::uint64_t TakeWriter::Parts::bytesOfFiles() const {
  std::uint64_t bytes = 0;
  std::error_code ignored;
  for (std::filesystem::recursive_directory_iterator at(folder, ignored), end; !ignored && at != end;
       at.increment(ignored))
    if (std::error_code no_file; at->is_regular_file(no_file)) bytes += at->file_size(no_file);
  return bytes;
}

void TakeWriter::Parts::checkFreeSpace(int frame) {
  if (options.free_bytes(folder) < kMinFreeBytes)
    throw Error(folder.string() + ": the disk is full: the recording ends with set " + std::to_string(frame) +
                " and can be replayed up to it");
  if (frame == 0 || frame % kGrowthSets != 0) return;
  const std::uint64_t bytes = bytesOfFiles();
  if (bytes <= previous_bytes)
    throw Error(folder.string() + ": nothing more can be written: the recording ends before set " +
                std::to_string(frame) + "; free some disk space");
  previous_bytes = bytes;
  const std::lock_guard lock(mutex);
  status.bytes = bytes;
}

void TakeWriter::Parts::end() {
  {
    const std::lock_guard lock(mutex);
    stopping = true;
  }
  changed.notify_all();
  if (thread.joinable()) thread.join();
  for (cv::VideoWriter& video : videos) video.release();
  timestamps.close();
}

TakeWriter::TakeWriter(const path& folder, const Rig& rig, const Options& options)
    : parts_(std::make_unique<Parts>()) {
  parts_->folder = folder;
  parts_->rig = rig;
  parts_->options = options;
  if (!options.free_bytes) parts_->options.free_bytes = freeBytesOnDisk;
  parts_->open();
  parts_->thread = std::thread([parts = parts_.get()] { parts->run(); });
}

TakeWriter::~TakeWriter() {
  parts_->end();
}

void TakeWriter::writeBackground(const std::vector<Bytes>& bgr) {
  std::filesystem::create_directories(parts_->folder / "background");
  for (std::size_t c = 0; c < bgr.size(); ++c) {
    const Camera& camera = parts_->rig.cameras[c];
    writePng(parts_->folder / "background" / (camera.name + ".png"), sizeOf(camera), rgbaOf(bgr[c], 3));
  }
}

void TakeWriter::write(RecordedSet set) {
  std::unique_lock lock(parts_->mutex);
  const std::size_t bytes = bytesOf(set);
  const auto hasRoom = [&] { return parts_->queue.empty() || parts_->queued_bytes + bytes <= kQueueBytes; };
  if (!hasRoom()) {
    const Clock::time_point start = Clock::now();
    parts_->changed.wait(lock, hasRoom);
    parts_->status.waited_s += 1e-3 * millisecondsSince(start);
  }
  parts_->queued_bytes += bytes;
  parts_->queue.push_back(std::move(set));
  parts_->changed.notify_all();
}

void TakeWriter::finish() {
  parts_->end();
  const Status now = status();
  if (!now.fault.empty()) throw Error(now.fault);
}

TakeWriter::Status TakeWriter::status() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->status;
}

}  // namespace airclay
