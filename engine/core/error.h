// SPDX-License-Identifier: MIT
// The one way a fault leaves the engine.
#pragma once

#include <stdexcept>
#include <string>

namespace airclay {

/// What a fault means to the one who started the program; the value is the exit status.
enum class Fault {
  kInput = 1,   ///< a file, a take, a device node or an output that is not as it must be
  kUsage = 2,   ///< the command line asks for what does not exist
  kDevice = 3,  ///< no usable Vulkan device, or it was lost
};

/// A fault. The message is one line that says what was wrong, where (file, line or key, camera, frame),
/// and what would be right; it is printed as it stands.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message, Fault fault = Fault::kInput)
      : std::runtime_error(message), fault_(fault) {}
  Fault fault() const { return fault_; }

 private:
  Fault fault_;
};

}  // namespace airclay
