// SPDX-License-Identifier: MIT
// A solve method: how moved data points become moved control points. Its description and its implementation
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
  const char* description;  ///< which data points are fitted, one phrase
  bool holds_unmoved;       ///< data points that are not moved are rows of the solve, too
  int max_control_points;
  /// `matrix` outlives the solver.
  std::unique_ptr<ClaySolver> (*create)(Gpu& gpu, const StencilMatrix& matrix);
};

extern const SolveMethod
    kSolveAll;  ///< every data point: those not moved hold their place as well as possible
extern const SolveMethod kSolveTouched;  ///< only the moved ones: the rest follows freely

/// A solve method at work on one subdivision d = A p. On the device it is part of a frame's submission; on
/// the host it runs between submissions.
class ClaySolver {
 public:
  virtual ~ClaySolver() = default;

  virtual bool onDevice() const = 0;

  /// On the device: workgroups of its two kernels.
  virtual std::uint32_t projectGroups() const { return 0; }
  virtual std::uint32_t applyGroups() const { return 0; }
  /// On the device: records p += A⁺ r. `displacements`: r, one per data point; `exact_points`: p, x y z of
  /// each control point, in double so that thousands of frames don't drift; `control_points`: the same,
  /// rounded. `groups`: three uints for each of the two kernels, at the offsets.
  virtual void recordIndirect(Recorder&, const Buffer<vec3>& /*displacements*/,
                              const Buffer<double>& /*exact_points*/, const Buffer<vec3>& /*control_points*/,
                              const RawBuffer& /*groups*/, std::uint64_t /*project_offset*/,
                              std::uint64_t /*apply_offset*/) {}

  /// On the host: the displacements of all control points. `rows`: the moved data points, ascending;
  /// `displacements`: theirs.
  virtual std::vector<Vec3> controlDisplacements(const std::vector<int>& /*rows*/,
                                                 const std::vector<Vec3>& /*displacements*/) {
    return {};
  }
};

/// All solve methods; the first is the default.
std::span<const SolveMethod* const> solveMethods();
/// nullptr when there is none.
const SolveMethod* findSolveMethod(std::string_view id);
/// "all or touched"
std::string solveMethodIds();

}  // namespace airclay
