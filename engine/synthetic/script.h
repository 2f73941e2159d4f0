// SPDX-License-Identifier: MIT
// A hand's scripted path: reaching movements of minimum jerk, one after another.
#pragma once

#include <optional>

#include "engine/core/math.h"

namespace airclay {

/// One reach, from where the last one ended. Positions follow the minimum-jerk profile (Flash and Hogan 1985,
/// "The coordination of arm movements", J. Neurosci. 5(7)): s = 10 t³ − 15 t⁴ + 6 t⁵, at rest at both ends;
/// orientations the same profile along the shortest arc. The path is twice continuously differentiable.
struct HandMove {
  double duration_s = 0;
  Pose world_from_hand = Pose::Identity();  ///< at its end
  Vec3 detour_m = Vec3::Zero();             ///< how far off the straight line it passes at half way
};

class HandScript {
 public:
  /// The hand appears at `appears_s`, at rest in `start`, makes the moves, and stays where the last one ends.
  HandScript(double appears_s, const Pose& start, std::vector<HandMove> moves);

  /// world_from_hand; none before the hand appears.
  std::optional<Pose> at(double time_s) const;
  double endS() const;

 private:
  double appears_s_;
  Pose start_;
  std::vector<HandMove> moves_;
};

/// What `airclay demo` shows: the built-in right hand comes up to the clay `tube`, flattens its side with the
/// fingers as a spatula would, turns palm down, and presses the rim in from above. All of the hand stays in
/// the 60 cm cube.
HandScript demoScript();

}  // namespace airclay
