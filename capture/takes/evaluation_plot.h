// SPDX-License-Identifier: MIT
// The errors of a tracked take over time, as an image.
#pragma once

#include <filesystem>
#include <string>

#include "capture/takes/evaluation.h"

namespace airclay {

/// Draws position and rotation errors, one above the other, with lost and uncertain frames marked. An axis is
/// logarithmic if its largest value is far above the median.
void drawEvaluation(const std::filesystem::path& png, const std::string& name, const EvaluatedTake& take,
                    const Vec3& center_in_hand);

}  // namespace airclay
