// SPDX-License-Identifier: MIT
// Commits strokes to a document.
#pragma once

#include "engine/clay/document.h"
#include "engine/clay/strokes.h"

namespace airclay {

class Clay;

/// The document's state with the control points of `clay`.
ClayState stateOf(const Document& document, const Clay& clay);

/// Commits every stroke when it ends.
class StrokeRecorder {
 public:
  /// `document` must outlive this; it may be assigned between strokes.
  explicit StrokeRecorder(Document& document) : document_(document) {}

  /// Takes the next sculpted frame. True if a stroke was committed.
  bool see(const StrokeFrame& frame, const std::string& tool, const Clay& clay);
  /// Ends the current stroke.
  bool finish(const Clay& clay);
  bool active() const { return watch_.active(); }

 private:
  Document& document_;
  StrokeDetector watch_;
};

}  // namespace airclay
