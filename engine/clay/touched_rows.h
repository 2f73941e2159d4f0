// SPDX-License-Identifier: MIT
// The rows of A that a set of moves affects.
#pragma once

#include "engine/clay/subdivide.h"

namespace airclay {

/// The moved rows of A, restricted to the control points that they depend on.
struct TouchedRows {
  std::vector<int> columns;  ///< control points, ascending
  StencilMatrix matrix;      ///< rows by columns
};

/// \pre `rows` are in range
TouchedRows touchedRows(const StencilMatrix& matrix, const std::vector<int>& rows);

}  // namespace airclay
