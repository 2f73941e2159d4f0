// SPDX-License-Identifier: MIT
// A solve method converts moved data points to moved control points. Its description and its implementation
// are in one translation unit; engine/clay/solve_methods.cpp lists all methods. The command line, documents,
// recordings and panels iterate over that list.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine/clay/subdivide.h"
#include "engine/gpu/recorder.h"

namespace airclay {

class ClaySolver;

struct SolveMethod {
  const char* id;           ///< on the command line and in documents: "all"
  const char* name;         ///< in the window: "all points"
  const char* description;  ///< "fits ...": the data points that it fits
  bool fits_unmoved;        ///< the solve includes the rows of data points that are not moved
  int max_control_points;
  /// \pre `matrix` outlives the solver
  std::unique_ptr<ClaySolver> (*create)(Gpu& gpu, const StencilMatrix& matrix);
};

/// Fits every data point: points that are not moved keep their positions as closely as possible.
extern const SolveMethod kSolveAll;
/// Fits only the moved data points; the others follow freely.
extern const SolveMethod kSolveTouched;

/// A solve method applied to one subdivision d = A p. On the device it is part of a frame's submission; on
/// the host it runs between submissions.
class ClaySolver {
 public:
  virtual ~ClaySolver() = default;

  virtual bool onDevice() const = 0;

  /// Device: workgroup counts of the two kernels.
  virtual std::uint32_t projectGroups() const { return 0; }
  virtual std::uint32_t applyGroups() const { return 0; }
  /// Device: records p += A⁺ r. `displacements`: r, one per data point; `exact_points`: p, x y z of each
  /// control point, in double precision so that thousands of frames do not drift; `control_points`: p,
  /// rounded. `groups`: three uints per kernel, at the byte offsets.
  virtual void recordIndirect(Recorder&, const Buffer<vec3>& /*displacements*/,
                              const Buffer<double>& /*exact_points*/, const Buffer<vec3>& /*control_points*/,
                              const RawBuffer& /*groups*/, std::uint64_t /*project_offset*/,
                              std::uint64_t /*apply_offset*/) {}

  /// Host: the displacements of all control points. `rows`: the moved data points, ascending;
  /// `displacements`: one per row.
  virtual std::vector<Vec3> controlDisplacements(const std::vector<int>& /*rows*/,
                                                 const std::vector<Vec3>& /*displacements*/) {
    return {};
  }
};

/// All solve methods; the first is the default.
std::span<const SolveMethod* const> solveMethods();
/// nullptr if there is no such method.
const SolveMethod* findSolveMethod(std::string_view id);
/// The ids for messages: "all or touched".
std::string solveMethodIds();

}  // namespace airclay
