// SPDX-License-Identifier: MIT
// Loops on all cores.
#pragma once

#include <cstddef>
#include <functional>

namespace airclay {

/// Calls `body(first, last)` for ranges of at most `grain` elements that cover [0, count), each range once,
/// on all cores. The ranges do not depend on the number of cores: if a call writes only its own elements, the
/// result does not either. The calling thread reports progress (engine/core/task.h) between its ranges.
/// \throw what a call or the Task throws, after all threads have ended
void parallelFor(std::size_t count, std::size_t grain,
                 const std::function<void(std::size_t first, std::size_t last)>& body);

}  // namespace airclay
