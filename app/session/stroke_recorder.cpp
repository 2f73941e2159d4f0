// SPDX-License-Identifier: MIT
#include "app/session/stroke_recorder.h"

#include "engine/clay/clay.h"

namespace airclay {

ClayState stateOf(const Document& document, const Clay& clay) {
  ClayState state = document.state();
  state.cage.points = clay.cage().points;
  state.workspace_from_clay = clay.workspaceFromClay();
  return state;
}

bool StrokeRecorder::see(const StrokeFrame& frame, const std::string& tool, const Clay& clay) {
  const std::string name = watch_.name();  // name of the stroke that may end here, before another starts
  if (watch_.addFrame(frame, tool) != StrokeEvent::kEnded) return false;
  document_.commit(name, stateOf(document_, clay));
  return true;
}

bool StrokeRecorder::finish(const Clay& clay) {
  if (watch_.finish() != StrokeEvent::kEnded) return false;
  document_.commit(watch_.name(), stateOf(document_, clay));
  return true;
}

}  // namespace airclay
