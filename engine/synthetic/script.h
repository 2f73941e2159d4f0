// SPDX-License-Identifier: MIT
// A scripted hand path: a sequence of minimum-jerk reaching movements.
#pragma once

#include <optional>

#include "engine/core/math.h"

namespace airclay {

/// One reaching movement, from the end of the previous one. Positions follow the minimum-jerk profile (Flash
/// and Hogan 1985, "The coordination of arm movements", J. Neurosci. 5(7)): s = 10 t³ − 15 t⁴ + 6 t⁵, at rest
/// at both ends; orientations follow the same profile along the shortest arc. The path is twice continuously
/// differentiable.
struct HandMove {
  double duration_s = 0;
  Pose world_from_hand = Pose::Identity();  ///< at its end
  Vec3 midpoint_offset_m = Vec3::Zero();    ///< offset from the straight line at the midpoint, world
};

class HandScript {
 public:
  /// The hand appears at `appears_s`, at rest in `start`, performs the moves, and stays at the end of the
  /// last one.
  HandScript(double appears_s, const Pose& start, std::vector<HandMove> moves);

  /// world_from_hand; empty before the hand appears.
  std::optional<Pose> at(double time_s) const;
  double endSeconds() const;

 private:
  double appears_s_;
  Pose start_;
  std::vector<HandMove> moves_;
};

/// The script of `airclay demo`: the built-in right hand approaches the clay `tube`, flattens its side with
/// the fingers, turns palm down, and presses the rim in from above. The whole hand stays in the 60 cm cube.
HandScript demoScript();

}  // namespace airclay
