// SPDX-License-Identifier: MIT
// OpenCV's marker dictionaries.
#pragma once

#include <optional>
#include <string>

namespace airclay {

struct ArucoDictionary {
  int opencv_number = 0;  ///< in cv::aruco::PredefinedDictionaryType
  int markers = 0;
  int bits = 0;  ///< along a marker's edge, without its border
};

/// Finds a dictionary by OpenCV's name without DICT_: 4X4_50 to 7X7_1000 and ARUCO_ORIGINAL.
std::optional<ArucoDictionary> arucoDictionary(const std::string& name);

}  // namespace airclay
