// SPDX-License-Identifier: MIT
// The arguments of a compiled shader: which push constants are device pointers, and whether it reads or
// writes through each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace airclay {

/// One device pointer among a shader's push constants.
struct PointerArgument {
  std::uint32_t offset = 0;  ///< bytes into the push constants
  bool reads = true;
  bool writes = true;
};

struct ShaderInterface {
  std::uint32_t push_constant_bytes = 0;  ///< the end of the last member; 0 if there is none
  std::vector<PointerArgument> pointers;
};

/// Reads the push-constant block of a SPIR-V module, including nested structs. A pointee whose members are
/// all decorated NonWritable is only read; NonReadable, only written (SPIR-V specification, 3.20 Decoration).
ShaderInterface shaderInterface(std::span<const std::uint32_t> spirv);

}  // namespace airclay
