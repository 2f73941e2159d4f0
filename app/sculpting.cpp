// SPDX-License-Identifier: MIT
#include "app/sculpting.h"

#include <algorithm>

#include "app/kept_strokes.h"
#include "app/pictures.h"
#include "app/player.h"
#include "app/progress.h"
#include "app/tracking.h"
#include "capture/video_writer.h"
#include "engine/clay.h"
#include "engine/mesh_file.h"

namespace airclay {
namespace {

/// What the clay went through.
class ClayFigures {
 public:
  void add(const ClayStep& step) {
    if (step.touched > 0) penetration_mm_.push_back(1000 * step.penetration_m);
  }
  std::string words() const {
    if (penetration_mm_.empty()) return "the hand never touched the clay";
    return "the hand moved clay in " + std::to_string(penetration_mm_.size()) +
           " frames; how deep it was still in the clay after each: " + fixed(median(penetration_mm_), 2) +
           " mm in the median, " +
           fixed(*std::max_element(penetration_mm_.begin(), penetration_mm_.end()), 2) + " mm at worst";
  }

 private:
  std::vector<double> penetration_mm_;
};

/// Takes the stills and the video while the clay is sculpted.
class Film {
 public:
  Film(Gpu& gpu, const Pipeline& pipeline, const Sculpting& sculpting, double rate_hz)
      : pictures_(gpu, pipeline, sculpting.clay, sculpting.forearm), out_(sculpting.out) {
    if (sculpting.video)
      video_.emplace(*sculpting.video, VideoWriter::Options{SculptPictures::kSize, rate_hz});
    save(out_ / "before.png", pictures_.frame(std::nullopt));
  }

  void take(const FrameResult& result) {
    std::optional<Pose> world_from_hand;
    if (result.hand == HandState::kTracked) world_from_hand = result.fit.world_from_hand;
    const bool first_touch = !touched_ && result.clay.touched > 0;
    if (!video_ && !first_touch) return;
    const Picture picture = pictures_.frame(world_from_hand);
    if (video_) video_->write(picture.rgba);
    if (!first_touch) return;
    touched_ = true;
    save(out_ / "touch.png", picture);
    save(out_ / "workings.png", pictures_.workings(world_from_hand));
  }

  void finish() {
    save(out_ / "after.png", pictures_.frame(std::nullopt));
    if (video_) video_->finish();
  }

 private:
  SculptPictures pictures_;
  std::filesystem::path out_;
  std::optional<VideoWriter> video_;
  bool touched_ = false;
};

}  // namespace

struct SculptResults::Parts {
  Parts(Gpu& gpu, const Pipeline& of_pipeline, const Recording& of_recording, const Sculpting& of_sculpting)
      : pipeline(of_pipeline),
        recording(of_recording),
        sculpting(of_sculpting),
        film(gpu, pipeline, sculpting, recording.rateHz()) {}
  const Pipeline& pipeline;
  const Recording& recording;
  const Sculpting& sculpting;
  Film film;
  Tracking tracking;
  ClayFigures clay;
};

SculptResults::SculptResults(Gpu& gpu, const Pipeline& pipeline, const Recording& recording,
                             const Sculpting& sculpting)
    : parts_(std::make_unique<Parts>(gpu, pipeline, recording, sculpting)) {}
SculptResults::~SculptResults() = default;

void SculptResults::add(const PlayedFrame& frame) {
  parts_->tracking.add(frame, parts_->recording);
  parts_->clay.add(frame.result.clay);
  parts_->film.take(frame.result);
}

void SculptResults::finish(const CommonOptions& options) {
  const Sculpting& sculpting = parts_->sculpting;
  parts_->film.finish();
  writeObj(sculpting.out / "surface.obj", parts_->pipeline.clay().surface());
  writeObj(sculpting.out / "cage.obj", parts_->pipeline.clay().cage());
  writePoses(sculpting.out / "poses.tum", parts_->tracking.poses());
  for (const std::string& line : parts_->tracking.words()) say(options, line);
  say(options, parts_->clay.words());
  say(options, "surface.obj, cage.obj, poses.tum and pictures in " + sculpting.out.string() +
                   (sculpting.video ? ", the video " + sculpting.video->string() : ""));
}

void sculptHeadless(Gpu& gpu, Recording& recording, const Sculpting& sculpting, Document* document,
                    const CommonOptions& options) {
  Pipeline pipeline(gpu, recording.rig(), sculpting.hand, {options.voxels}, sculpting.clay);
  Player player(recording, pipeline);
  SculptResults results(gpu, pipeline, recording, sculpting);
  std::optional<KeptStrokes> strokes;
  if (document) strokes.emplace(*document);
  {
    Progress progress("sculpting", recording.frameCount(), options.talks());
    while (const std::optional<PlayedFrame> frame = player.next(sculpting.controls)) {
      results.add(*frame);
      if (strokes)
        strokes->see(
            {frame->time_s, frame->result.clay.touched, true, frame->result.hand == HandState::kTracked},
            toolName(sculpting.controls.tool), pipeline.clay());
      progress.advance();
    }
  }
  if (strokes) strokes->finish(pipeline.clay());
  results.finish(options);
}

}  // namespace airclay
