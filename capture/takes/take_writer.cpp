// SPDX-License-Identifier: MIT
// HuffYUV in Matroska through OpenCV's FFmpeg backend: of the codecs it writes that give every pixel back,
// the fastest, and a file that was cut off can be read up to its last whole frame.
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

constexpr const char* kVideoEnding = ".mkv";
// So many sets, and the files must have grown: OpenCV reports no fault of a write.
constexpr int kGrowthSets = 30;

/// What cannot be told is no fault.
std::uintmax_t roomOnDisk(const std::filesystem::path& folder) {
  std::error_code fault;
  const std::filesystem::space_info space = std::filesystem::space(folder, fault);
  return fault ? UINTMAX_MAX : space.available;
}

ImageSize sizeOf(const Camera& camera) {
  return {camera.width, camera.height};
}

/// OpenCV's writer cuts odd sides.
bool goesIntoVideo(const Camera& camera) {
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

std::size_t bytesOf(const TakenSet& set) {
  std::size_t bytes = 0;
  for (const Bytes& one : set.bytes) bytes += one.size();
  return bytes;
}

void makeEmptyFolder(const path& folder) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault || !std::filesystem::is_directory(folder, fault))
    throw Error(folder.string() + ": the folder for the recording cannot be made" +
                (fault ? ": " + fault.message() : ""));
  if (!std::filesystem::is_empty(folder, fault) || fault)
    throw Error(folder.string() +
                ": there is something in the folder already; a new one for the recording would be right");
}

}  // namespace

struct TakeWriter::Parts {
  path folder;
  Rig rig;
  Options options;
  std::vector<cv::VideoWriter> videos;  ///< a camera each; closed where its images are files
  std::ofstream timestamps;
  std::vector<double> last_times_s;
  double later_s = 0;  ///< what is added to times that ran back

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<TakenSet> queue;
  std::size_t queued_bytes = 0;
  bool ending = false;
  Status status;
  std::uint64_t bytes_then = 0;  ///< of all files, some sets ago
  std::thread thread;

  bool masks() const { return options.content == Content::kMasks; }
  void open();
  void run();
  void writeSet(const TakenSet& set, int frame);
  void writeImage(std::size_t camera, const Bytes& bytes, int frame);
  void writeTimes(const std::vector<double>& times_s);
  std::uint64_t bytesOfFiles() const;
  void checkRoom(int frame);
  void end();
};

void TakeWriter::Parts::open() {
  quietOpenCv();
  makeEmptyFolder(folder);
  if (options.writes_rig) writeRig(folder / "rig.toml", rig, RotationFormat::kMatrices);
  if (options.content == Content::kNothing) return;
  videos.resize(rig.cameras.size());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Camera& camera = rig.cameras[c];
    if (masks() || !goesIntoVideo(camera)) {
      std::filesystem::create_directories(masks() ? folder / "silhouettes" / camera.name
                                                  : folder / camera.name);
      continue;
    }
    const path file = folder / (camera.name + kVideoEnding);
    const int huffyuv = cv::VideoWriter::fourcc('H', 'F', 'Y', 'U');
    if (!videos[c].open(file.string(), cv::CAP_FFMPEG, huffyuv, options.rate_hz,
                        {camera.width, camera.height}))
      throw Error(file.string() +
                  ": the video cannot be written; an OpenCV whose FFmpeg has HuffYUV would be right");
  }
}

void TakeWriter::Parts::run() {
  for (;;) {
    TakenSet set;
    int frame = 0;
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return ending || !queue.empty(); });
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
    queued_bytes -= bytesOf(set);  // only now: what is being written still needs its memory
    if (!fault.empty()) status.fault = fault;
    if (status.fault.empty()) ++status.sets;
    changed.notify_all();
  }
}

void TakeWriter::Parts::writeSet(const TakenSet& set, int frame) {
  checkRoom(frame);
  // All cameras at once: one core codes four of 640 x 480 at 30 Hz with little to spare (3 ms an image).
  std::vector<std::future<void>> writing;
  for (std::size_t c = 0; c < set.bytes.size(); ++c)
    writing.push_back(std::async(std::launch::async, [&, c] { writeImage(c, set.bytes[c], frame); }));
  for (std::future<void>& one : writing) one.get();
  // After the images: a row tells that they are there.
  if (!set.camera_times_s.empty()) writeTimes(set.camera_times_s);
}

void TakeWriter::Parts::writeImage(std::size_t camera, const Bytes& bytes, int frame) {
  const Camera& of = rig.cameras[camera];
  if (masks()) {
    writePng(folder / "silhouettes" / of.name / numbered(frame), sizeOf(of), rgbaOf(bytes, 1));
  } else if (videos[camera].isOpened()) {
    // OpenCV only reads from it, but has no constant matrix over foreign memory.
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
    if (times_s[c] + later_s <= last_times_s[c]) later_s = last_times_s[c] - times_s[c] + 1 / options.rate_hz;
  last_times_s.clear();
  for (std::size_t c = 0; c < times_s.size(); ++c) {
    last_times_s.push_back(times_s[c] + later_s);
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

void TakeWriter::Parts::checkRoom(int frame) {
  if (options.room(folder) < kLeastRoomBytes)
    throw Error(folder.string() + ": the disk is full: the recording ends with set " + std::to_string(frame) +
                ", and what is there can be replayed");
  if (frame == 0 || frame % kGrowthSets != 0) return;
  const std::uint64_t bytes = bytesOfFiles();
  if (bytes <= bytes_then)
    throw Error(folder.string() + ": nothing more can be written: the recording ends before set " +
                std::to_string(frame) + "; room on the disk would be right");
  bytes_then = bytes;
  const std::lock_guard lock(mutex);
  status.bytes = bytes;
}

void TakeWriter::Parts::end() {
  {
    const std::lock_guard lock(mutex);
    ending = true;
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
  if (!options.room) parts_->options.room = roomOnDisk;
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

void TakeWriter::write(TakenSet set) {
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
