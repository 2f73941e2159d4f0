// SPDX-License-Identifier: MIT
// What a compiled shader says of its arguments: which push constants are device pointers, and what it does
// through each.
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
  std::uint32_t push_constant_bytes = 0;  ///< the end of the last member; 0 without any
  std::vector<PointerArgument> pointers;
};

/// Reads the push-constant block of a SPIR-V module, structs within it included. A pointee whose members are
/// all decorated NonWritable is only read through, NonReadable only written (SPIR-V specification, 3.20
/// Decoration).
ShaderInterface shaderInterface(std::span<const std::uint32_t> spirv);

}  // namespace airclay
