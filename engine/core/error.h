// SPDX-License-Identifier: MIT
// The exception that every engine error is reported by.
#pragma once

#include <stdexcept>
#include <string>

namespace airclay {

/// The kind of error for the program's caller; the value is the exit status.
enum class Fault {
  kInput = 1,   ///< an invalid file, take, device node or output
  kUsage = 2,   ///< the command line asks for something that does not exist
  kDevice = 3,  ///< no usable Vulkan device, or it was lost
};

/// An error. The message is one line: what is wrong, where (file, line or key, camera, frame), and what would
/// be right. It is printed unchanged.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message, Fault fault = Fault::kInput)
      : std::runtime_error(message), fault_(fault) {}
  Fault fault() const { return fault_; }

 private:
  Fault fault_;
};

}  // namespace airclay
