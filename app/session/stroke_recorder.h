// SPDX-License-Identifier: MIT
// Strokes as they are sculpted, kept in a document.
#pragma once

#include "engine/clay/document.h"
#include "engine/clay/strokes.h"

namespace airclay {

class Clay;

/// What the document would hold if `clay` were committed: its control points in the document's form.
ClayState stateOf(const Document& document, const Clay& clay);

/// Commits every stroke when it has ended.
class StrokeRecorder {
 public:
  /// `document` must outlive this; another may be moved into it between strokes.
  explicit StrokeRecorder(Document& document) : document_(document) {}

  /// The next frame, sculpted. True when a stroke went into the document.
  bool see(const StrokeFrame& frame, const std::string& tool, const Clay& clay);
  /// The stroke under way ends here.
  bool finish(const Clay& clay);
  bool active() const { return watch_.active(); }

 private:
  Document& document_;
  StrokeWatch watch_;
};

}  // namespace airclay
