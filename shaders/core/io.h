// SPDX-License-Identifier: MIT
// Included by every *_io.h: the types shared by GLSL and C++, and typed device pointers.
//
// A kernel's arguments are one struct of plain values and pointers, passed as push constants (at most 128
// bytes, lavapipe's limit). A pointer's type states how the kernel accesses it: the GLSL compiler rejects a
// write through Read…, the SPIR-V carries the declaration, and the recorder derives its barriers from it
// (engine/gpu/recorder.h).
#ifndef AIRCLAY_IO_H
#define AIRCLAY_IO_H

#ifdef __cplusplus

#include <Eigen/Core>
#include <cstdint>

namespace airclay {

using uint = std::uint32_t;
using vec2 = Eigen::Matrix<float, 2, 1, Eigen::DontAlign>;
using vec3 = Eigen::Matrix<float, 3, 1, Eigen::DontAlign>;
using vec4 = Eigen::Matrix<float, 4, 1, Eigen::DontAlign>;
using mat3 = Eigen::Matrix<float, 3, 3, Eigen::DontAlign>;  // column-major, as in GLSL
using mat4 = Eigen::Matrix<float, 4, 4, Eigen::DontAlign>;

/// The device address of an array of `T`; 0 is null.
template <class T>
struct DevicePointer {
  std::uint64_t address = 0;
};

}  // namespace airclay

#define AIRCLAY_IO_BEGIN namespace airclay {
#define AIRCLAY_IO_END }
#define READ_POINTER(Name, T) using Name = DevicePointer<const T>;
#define WRITE_POINTER(Name, T) using Name = DevicePointer<T>;
#define READ_WRITE_POINTER(Name, T) using Name = DevicePointer<T>;
#define DEFAULT(value) = value

#else

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_explicit_arithmetic_types_float64 : require

#define AIRCLAY_IO_BEGIN
#define AIRCLAY_IO_END
#define READ_POINTER(Name, T)                                                         \
  layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Name { \
    T at[];                                                                           \
  };
#define WRITE_POINTER(Name, T)                                                         \
  layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Name { \
    T at[];                                                                            \
  };
#define READ_WRITE_POINTER(Name, T)                                          \
  layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Name { \
    T at[];                                                                  \
  };
#define DEFAULT(value)

#endif

AIRCLAY_IO_BEGIN

READ_POINTER(ReadUints, uint)
WRITE_POINTER(WriteUints, uint)
READ_WRITE_POINTER(ReadWriteUints, uint)
READ_POINTER(ReadUlongs, uint64_t)
WRITE_POINTER(WriteUlongs, uint64_t)
READ_POINTER(ReadFloats, float)
WRITE_POINTER(WriteFloats, float)
READ_WRITE_POINTER(ReadWriteFloats, float)
READ_POINTER(ReadVec3s, vec3)
WRITE_POINTER(WriteVec3s, vec3)
READ_WRITE_POINTER(ReadWriteVec3s, vec3)
READ_POINTER(ReadVec4s, vec4)

AIRCLAY_IO_END

#endif
