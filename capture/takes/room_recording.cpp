// SPDX-License-Identifier: MIT
#include "capture/takes/room_recording.h"

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "capture/takes/take_writer.h"

namespace airclay {
namespace {

constexpr double kDenseHz = 300;

/// `work` for each camera, on several threads.
template <class Work>
void forEachCamera(std::size_t count, const Work& work) {
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (std::size_t camera = next++; camera < count; camera = next++) work(camera);
  };
  std::vector<std::jthread> helpers;
  const std::size_t threads = std::min<std::size_t>(count, std::max(1u, std::thread::hardware_concurrency()));
  for (std::size_t i = 1; i < threads; ++i) helpers.emplace_back(run);
  run();
}

}  // namespace

RoomRecording::RoomRecording(const HandModel& hand, const RoomOptions& options)
    : options_(options), room_(hand, options), truth_(std::in_place) {
  for (int frame = 0; frame < frameCount(); ++frame)
    if (frame >= options_.background_frames && room_.isHandInCube(timeOf(frame)))
      truth_->push_back({timeOf(frame), *room_.handAt(timeOf(frame))});
}

double RoomRecording::timeOf(int frame) const {
  const std::vector<double> times = cameraTimesOf(frame);
  return std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
}

bool RoomRecording::readImages(int frame, Buffers bgr) {
  if (frame >= frameCount()) return false;
  if (bgr.size() != options_.rig.cameras.size())
    throw std::logic_error("RoomRecording: expected one buffer per camera");
  for (std::size_t c = 0; c < bgr.size(); ++c) {
    const Camera& camera = options_.rig.cameras[c];
    if (bgr[c].size() !=
        std::size_t(3) * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height))
      throw std::logic_error("RoomRecording: a buffer does not have its camera's size");
  }
  forEachCamera(bgr.size(), [&](std::size_t camera) { room_.render(camera, frame, bgr[camera]); });
  return true;
}

Truth RoomRecording::fullTruth() const {
  Truth truth{*truth_, {}};
  const double end_s = timeOf(frameCount() - 1) + 0.1;
  for (int i = 0; i / kDenseHz < end_s; ++i)
    if (const std::optional<Pose> pose = room_.handAt(i / kDenseHz))
      truth.dense.push_back({i / kDenseHz, *pose});
  return truth;
}

void writeTake(RoomRecording& recording, const std::filesystem::path& folder,
               const std::function<void()>& on_frame) {
  TakeWriter writer(folder, recording.rig(), {.rate_hz = recording.rateHz()});
  for (int frame = 0; frame < recording.frameCount(); ++frame) {
    RecordedSet set{recording.cameraTimesOf(frame), {}};
    std::vector<std::span<std::uint8_t>> buffers;
    for (const Camera& camera : recording.rig().cameras)
      set.bytes.emplace_back(std::size_t(3) * static_cast<std::size_t>(camera.width) *
                             static_cast<std::size_t>(camera.height));
    for (std::vector<std::uint8_t>& bytes : set.bytes) buffers.emplace_back(bytes);
    recording.readImages(frame, buffers);
    writer.write(std::move(set));
    if (on_frame) on_frame();
  }
  writer.finish();
  const Truth truth = recording.fullTruth();
  writePoses(folder / "truth.tum", truth.frames);
  writePoses(folder / "truth_dense.tum", truth.dense);
}

}  // namespace airclay
