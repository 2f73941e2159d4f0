// SPDX-License-Identifier: MIT
#include "tests/support/small_take.h"

#include "capture/images/image_file.h"
#include "capture/takes/synthetic.h"
#include "tests/support/gpu_fixture.h"

namespace airclay {

HandScript smallTakeScript(const SmallTake& take) {
  const HandScript demo = demoScript();
  const double begins_s = 10.0 / 30;  // in the demo's script
  if (!take.way.empty()) {
    std::vector<HandMove> steps;
    for (const Vec3& place : take.way) {
      Pose pose = *demo.at(begins_s + 0.8);
      pose.pretranslate(place);
      steps.push_back({0.5 * take.slower, pose});
    }
    return HandScript(take.empty_frames / 30.0, *demo.at(begins_s + 0.8), steps);
  }
  return HandScript(take.empty_frames / 30.0, *demo.at(begins_s + 0.8),
                    {{take.slower * 0.15, *demo.at(begins_s + 0.95)},
                     {take.slower * 0.45, *demo.at(begins_s + 1.55)},
                     {take.slower * 0.4, *demo.at(begins_s + 2.35)}});
}

int writeSmallTake(const std::filesystem::path& folder, const SmallTake& take) {
  SyntheticOptions options;
  for (Camera& camera : options.rig.cameras) {
    camera.width /= 2;
    camera.height /= 2;
    for (double* value : {&camera.lens.fx, &camera.lens.fy, &camera.lens.cx, &camera.lens.cy}) *value /= 2;
  }
  options.script = smallTakeScript(take);
  Synthetic synthetic(testGpu(), options);
  std::filesystem::create_directories(folder);
  writeRig(folder / "rig.toml", synthetic.rig());
  std::vector<std::vector<std::uint8_t>> images;
  for (const Camera& camera : synthetic.rig().cameras) {
    std::filesystem::create_directories(folder / camera.name);
    images.emplace_back(std::size_t(3) * std::size_t(camera.width) * std::size_t(camera.height));
  }
  const std::vector<std::span<std::uint8_t>> buffers(images.begin(), images.end());
  constexpr int kDistinctEmptyFrames = 30;  // further ones repeat these, which saves the time to write them
  for (int frame = 0; frame < synthetic.frameCount(); ++frame) {
    if (frame >= kDistinctEmptyFrames && frame < take.empty_frames) {
      for (const Camera& camera : synthetic.rig().cameras)
        std::filesystem::create_hard_link(
            folder / camera.name / (std::to_string(frame % kDistinctEmptyFrames) + ".png"),
            folder / camera.name / (std::to_string(frame) + ".png"));
      continue;
    }
    synthetic.readImages(frame, buffers);
    for (std::size_t c = 0; c < images.size(); ++c) {
      std::vector<std::uint8_t> rgba;
      for (std::size_t i = 0; i < images[c].size(); i += 3)
        rgba.insert(rgba.end(), {images[c][i + 2], images[c][i + 1], images[c][i], 255});
      const Camera& camera = synthetic.rig().cameras[c];
      writePng(folder / camera.name / (std::to_string(frame) + ".png"), {camera.width, camera.height}, rgba);
    }
  }
  return synthetic.frameCount();
}

}  // namespace airclay
