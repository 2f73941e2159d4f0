// SPDX-License-Identifier: MIT
#include "app/commands/sculpting.h"

#include <algorithm>

#include "app/cli/progress.h"
#include "app/session/images.h"
#include "app/session/tracking_summary.h"
#include "capture/images/video_writer.h"
#include "capture/takes/player.h"
#include "engine/clay/clay.h"
#include "engine/core/median.h"
#include "engine/mesh/mesh_file.h"

namespace airclay {
namespace {

constexpr double kMouseRateHz = 30;  // of the video of a mouse session

/// Penetration statistics of the clay.
class ClayFigures {
 public:
  void add(const ClayStep& step) {
    if (step.touched > 0) penetration_mm_.push_back(1000 * step.penetration_m);
  }
  std::string summary() const {
    if (penetration_mm_.empty()) return "the hand never touched the clay";
    return "the hand moved clay in " + std::to_string(penetration_mm_.size()) +
           " frames; remaining penetration: median " + fixed(median(penetration_mm_), 2) + " mm, maximum " +
           fixed(*std::max_element(penetration_mm_.begin(), penetration_mm_.end()), 2) + " mm";
  }

 private:
  std::vector<double> penetration_mm_;
};

/// Renders the stills and the video during sculpting.
class Film {
 public:
  Film(Gpu& gpu, Pipeline& pipeline, const Sculpting& sculpting, double rate_hz)
      : images_(gpu, pipeline, sculpting.clay, sculpting.forearm), out_(sculpting.out) {
    if (sculpting.video)
      video_.emplace(*sculpting.video, VideoWriter::Options{SculptRenderer::kSize, rate_hz});
    save(out_ / "before.png", images_.frame({}));
  }

  void take(const FrameResult& result) {
    std::vector<HandPose> hands;
    if (const HandFit* fit = result.trackedHand()) hands.push_back(fit->pose);
    const bool first_touch = !touched_ && result.clay.touched > 0;
    if (!video_ && !first_touch) return;
    const RgbaImage image = images_.frame(hands);
    if (video_) video_->write(image.rgba);
    if (!first_touch) return;
    touched_ = true;
    save(out_ / "touch.png", image);
    save(out_ / "workings.png", images_.workings(hands));
  }

  void finish() {
    save(out_ / "after.png", images_.frame({}));
    if (video_) video_->finish();
  }

 private:
  SculptRenderer images_;
  std::filesystem::path out_;
  std::optional<VideoWriter> video_;
  bool touched_ = false;
};

}  // namespace

struct SculptResults::Parts {
  Parts(Gpu& gpu, Pipeline& pipeline, const Recording* of_recording, const Sculpting& of_sculpting)
      : recording(of_recording),
        sculpting(of_sculpting),
        film(gpu, pipeline, sculpting, recording ? recording->rateHz() : kMouseRateHz) {}
  const Recording* recording;
  const Sculpting& sculpting;
  Film film;
  Tracking tracking;
  ClayFigures clay;
};

SculptResults::SculptResults(Gpu& gpu, Pipeline& pipeline, const Recording* recording,
                             const Sculpting& sculpting)
    : parts_(std::make_unique<Parts>(gpu, pipeline, recording, sculpting)) {}
SculptResults::~SculptResults() = default;

void SculptResults::add(const PlayedFrame& frame) {
  parts_->tracking.add(frame, parts_->recording);
  parts_->clay.add(frame.result.clay);
  parts_->film.take(frame.result);
}

void SculptResults::finish(Pipeline& pipeline) {
  const Sculpting& sculpting = parts_->sculpting;
  parts_->film.finish();
  writeObj(sculpting.out / "surface.obj", pipeline.clay().surface());
  writeObj(sculpting.out / "cage.obj", pipeline.clay().cage());
  writePoses(sculpting.out / "poses.tum", parts_->tracking.poses());
}

void SculptResults::printLine(const CommonOptions& options) const {
  const Sculpting& sculpting = parts_->sculpting;
  for (const std::string& line : parts_->tracking.summary()) airclay::printLine(options, line);
  airclay::printLine(options, parts_->clay.summary());
  airclay::printLine(options, "surface.obj, cage.obj, poses.tum and images in " + sculpting.out.string() +
                                  (sculpting.video ? "; video " + sculpting.video->string() : ""));
}

void sculptHeadless(Gpu& gpu, const Session::Options& options, const Sculpting& sculpting,
                    const SculptControls& controls, Document document, const CommonOptions& common) {
  std::optional<SculptResults> results;
  std::optional<Progress> progress(std::in_place, options.replay ? "replaying" : "sculpting",
                                   options.recording ? options.recording->frameCount() : 1,
                                   common.printsMessages());
  Session::Options session_options = options;
  session_options.headless = true;
  session_options.settings.tool = controls.tool;
  session_options.settings.symmetry = controls.symmetry;
  session_options.on_frame = [&](Pipeline& pipeline, const PlayedFrame* frame) {
    if (!results) results.emplace(gpu, pipeline, options.recording, sculpting);
    if (frame) results->add(*frame);
    progress->advance();
    if (!frame) results->finish(pipeline);
  };
  Session session(gpu, session_options, std::move(document));
  session.finish();
  progress.reset();
  results->printLine(common);
  for (const std::string& line : session.takeMessages()) printLine(common, line);
}

}  // namespace airclay
