#version 460
// SPDX-License-Identifier: MIT
// Passes the fitted pose on to the clay if the images confirm it.
#extension GL_GOOGLE_include_directive : require
#include "shaders/hand/outline_io.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { OutlineJudgeArgs args; };

void main() {
  float length_ = 0, good = 0;
  uint agreeing = 0;
  for (uint camera = 0; camera < args.cameras; ++camera) {
    const float own = args.fit.at[0].camera_length[camera], own_good = args.fit.at[0].camera_good[camera];
    length_ += own;
    good += own_good;
    if (own >= kLeastOutline && own_good >= kCameraAgreement * own) ++agreeing;
  }
  const float judged = args.fit.at[0].judged_length;
  const bool is_clear = judged >= kLeastJudged * length_ && good >= kJudgedAgreement * judged;
  args.hand.at[0].rotation = args.fit.at[0].pose.rotation;
  args.hand.at[0].position = args.fit.at[0].pose.position;
  args.hand.at[0].tracked = agreeing >= kAgreeingCameras && (good >= kTrackedAgreement * length_ || is_clear) ? 1 : 0;
}
