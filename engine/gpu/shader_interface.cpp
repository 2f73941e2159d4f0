// SPDX-License-Identifier: MIT
#include "engine/gpu/shader_interface.h"

#include <map>
#include <spirv/unified1/spirv.hpp>

#include "engine/core/error.h"

namespace airclay {
namespace {

/// The types and decorations of a module, as far as push constants need them.
struct Module {
  struct Member {
    std::uint32_t offset = 0;
    bool non_writable = false, non_readable = false;
  };
  struct Type {
    spv::Op op{};
    std::vector<std::uint32_t> operands;  ///< after the result id
  };
  std::map<std::uint32_t, Type> types;
  std::map<std::uint32_t, std::map<std::uint32_t, Member>> members;  ///< by struct, by member
  std::uint32_t push_constant_type = 0;

  explicit Module(std::span<const std::uint32_t> words) {
    constexpr std::size_t header = 5;
    for (std::size_t at = header; at < words.size();) {
      const std::size_t length = words[at] >> spv::WordCountShift;
      const auto op = static_cast<spv::Op>(words[at] & spv::OpCodeMask);
      if (length == 0 || at + length > words.size())
        throw Error("a built-in shader is corrupt", Fault::kDevice);
      read(op, words.subspan(at + 1, length - 1));
      at += length;
    }
  }

  void read(spv::Op op, std::span<const std::uint32_t> operands) {
    switch (op) {
      case spv::OpMemberDecorate: {
        Member& member = members[operands[0]][operands[1]];
        if (operands[2] == spv::DecorationOffset) member.offset = operands[3];
        if (operands[2] == spv::DecorationNonWritable) member.non_writable = true;
        if (operands[2] == spv::DecorationNonReadable) member.non_readable = true;
        break;
      }
      case spv::OpTypeInt:
      case spv::OpTypeFloat:
      case spv::OpTypeVector:
      case spv::OpTypeMatrix:
      case spv::OpTypeStruct:
      case spv::OpTypeArray:
      case spv::OpTypePointer:
        types[operands[0]] = {op, {operands.begin() + 1, operands.end()}};
        break;
      case spv::OpVariable:
        if (operands[2] == spv::StorageClassPushConstant) push_constant_type = operands[0];
        break;
      default:
        break;
    }
  }

  /// Size under scalar layout.
  std::uint32_t bytes(std::uint32_t type) const {
    const Type& t = types.at(type);
    switch (t.op) {
      case spv::OpTypeInt:
      case spv::OpTypeFloat:
        return t.operands[0] / 8;
      case spv::OpTypeVector:
      case spv::OpTypeMatrix:
        return bytes(t.operands[0]) * t.operands[1];
      case spv::OpTypePointer:
        return 8;
      case spv::OpTypeStruct: {
        const auto last = static_cast<std::uint32_t>(t.operands.size() - 1);
        return members.at(type).at(last).offset + bytes(t.operands[last]);
      }
      default:
        throw Error("a built-in shader has a push constant of an unknown type", Fault::kDevice);
    }
  }

  PointerArgument pointer(std::uint32_t pointee, std::uint32_t offset) const {
    PointerArgument argument{offset, true, true};
    const auto found = members.find(pointee);
    if (found == members.end()) return argument;
    bool all_non_writable = true, all_non_readable = true;
    for (const auto& [index, member] : found->second) {
      all_non_writable = all_non_writable && member.non_writable;
      all_non_readable = all_non_readable && member.non_readable;
    }
    argument.writes = !all_non_writable;
    argument.reads = !all_non_readable;
    return argument;
  }

  void collectPointers(std::uint32_t struct_type, std::uint32_t base,
                       std::vector<PointerArgument>& found) const {
    const std::vector<std::uint32_t>& member_types = types.at(struct_type).operands;
    for (std::uint32_t i = 0; i < member_types.size(); ++i) {
      const Type& type = types.at(member_types[i]);
      const std::uint32_t offset = base + members.at(struct_type).at(i).offset;
      if (type.op == spv::OpTypePointer) found.push_back(pointer(type.operands[1], offset));
      if (type.op == spv::OpTypeStruct) collectPointers(member_types[i], offset, found);
    }
  }
};

}  // namespace

ShaderInterface shaderInterface(std::span<const std::uint32_t> spirv) {
  const Module module(spirv);
  ShaderInterface result;
  if (module.push_constant_type == 0) return result;
  const std::uint32_t block = module.types.at(module.push_constant_type).operands[1];
  result.push_constant_bytes = module.bytes(block);
  module.collectPointers(block, 0, result.pointers);
  return result;
}

}  // namespace airclay
