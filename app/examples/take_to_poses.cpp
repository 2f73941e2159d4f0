// SPDX-License-Identifier: MIT
// A recording to hand poses, as a TUM trajectory: one line per frame in which the hand is tracked.
//
//     take_to_poses TAKE POSES.tum
//
// TAKE holds rig.toml and a video or a folder of images per camera; its first frames show the empty
// workspace.
#include <airclay/capture/takes/player.h>
#include <airclay/capture/takes/take.h>
#include <airclay/engine/core/error.h>

#include <cstdio>

using namespace airclay;

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: take_to_poses TAKE POSES.tum\n");
    return 2;
  }
  try {
    Take take(argv[1]);
    Gpu gpu;
    Pipeline pipeline(gpu, take.rig(), builtInHand(false));
    Player player(take, pipeline);
    std::vector<TimedPose> poses;
    while (const std::optional<PlayedFrame> frame = player.next())
      if (const HandFit* hand = frame->result.trackedHand())
        poses.push_back({frame->time_s, hand->pose.world_from_hand});
    writePoses(argv[2], poses);
    std::printf("%zu of %d frames tracked\n", poses.size(), take.frameCount());
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
