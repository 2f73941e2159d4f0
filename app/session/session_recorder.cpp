// SPDX-License-Identifier: MIT
#include "app/session/session_recorder.h"

#include "engine/core/error.h"

namespace airclay {
namespace {

TakeWriter::Options optionsOf(const SessionRecorder::Start& start) {
  if (!start.source) return {.rate_hz = 30, .content = TakeWriter::Content::kNothing};
  return {
      .rate_hz = start.source->rateHz(),
      .content = start.source->hasSilhouettes() ? TakeWriter::Content::kMasks : TakeWriter::Content::kImages};
}

/// Images of the empty workspace, if the source has them.
std::vector<std::vector<std::uint8_t>> backgroundOf(const Recording& source) {
  std::vector<std::vector<std::uint8_t>> images;
  for (const Camera& camera : source.rig().cameras)
    images.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
  const std::vector<std::span<std::uint8_t>> buffers(images.begin(), images.end());
  source.readBackground(buffers);
  return images;
}

}  // namespace

SessionRecorder::SessionRecorder(const Start& start, const Document& document)
    : folder_(start.folder), by_mouse_(!start.source), take_(start.folder, start.rig, optionsOf(start)) {
  document.saveAs(folder_ / kStartFile);
  ActionsHeader head = start.head;
  head.by_mouse = by_mouse_;
  if (head.hand != "right" && head.hand != "left") {
    std::filesystem::copy_file(head.hand, folder_ / "hand.glb");
    head.hand = "hand.glb";
  }
  actions_.open(folder_ / kActionsFile);
  write(linesOf(head));
  if (start.source && start.source->hasBackground() && !start.source->hasSilhouettes())
    take_.writeBackground(backgroundOf(*start.source));
  ReplayFrame learned;
  learned.learned = true;
  for (const FrameSet& set : start.learned) frame(learned, &set);
}

void SessionRecorder::write(const std::string& lines) {
  actions_ << lines;
  if (!actions_.flush())
    throw Error((folder_ / kActionsFile).string() + ": cannot be written; is the disk full?");
}

void SessionRecorder::action(const Action& action) {
  write(lineOf(action));
}

std::filesystem::path SessionRecorder::nextFile() {
  return "clay-" + std::to_string(++files_) + ".clay";
}

void SessionRecorder::clay(const ClayState& state, const std::string& name) {
  Action action{.kind = Action::Kind::kClay, .file = nextFile(), .name = name};
  Document::create(folder_ / action.file, state, name);
  write(lineOf(action));
}

void SessionRecorder::document(const Document& opened) {
  const Action action{.kind = Action::Kind::kDocument, .file = nextFile()};
  opened.saveAs(folder_ / action.file);
  write(lineOf(action));
}

void SessionRecorder::frame(const ReplayFrame& frame, const FrameSet* set) {
  if (set) take_.write({set->camera_times_s, set->bytes});
  if (const std::string fault = take_.status().fault; !fault.empty()) throw Error(fault);
  write(lineOf(frame, by_mouse_));
  ++frames_;
}

void SessionRecorder::end() {
  take_.finish();
  write(kActionsEnd);
  actions_.close();
}

RecorderView SessionRecorder::view() const {
  return {true, folder_, frames_, take_.status().waited_s};
}

}  // namespace airclay
