// SPDX-License-Identifier: MIT
// The marker dictionaries that OpenCV has.
#pragma once

#include <optional>
#include <string>

namespace airclay {

struct ArucoDictionary {
  int opencv_number = 0;  ///< of its enumeration PREDEFINED_DICTIONARY_NAME
  int markers = 0;
  int bits = 0;  ///< along a marker's edge, without its border
};

/// By OpenCV's name without DICT_: 4X4_50 to 7X7_1000 and ARUCO_ORIGINAL.
std::optional<ArucoDictionary> arucoDictionary(const std::string& name);

}  // namespace airclay
