// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

namespace airclay {

/// The middle value; the mean of the two middle values of an even count; 0 if empty.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

}  // namespace airclay
