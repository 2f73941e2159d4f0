// SPDX-License-Identifier: MIT
// The studio: live sculpting in a window.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/session/session.h"

namespace airclay {

/// Status lines for tests and monitoring: one JSON object per line.
struct StudioLog {
  std::filesystem::path file;  ///< empty: no log
  double interval_s = 1;       ///< minimum time between lines
};

struct StudioOptions {
  std::string title = "Airclay";
  std::optional<TriangleMesh> forearm;  ///< drawn behind the hand
  bool close_at_end = false;            ///< close the window at the end of the take; for the demo
  StudioLog log;
};

/// Opens the window and returns when it is closed. The hand comes from `session.recording`, or from the mouse
/// if that is null. Every edit is in `document` on return. \throw Error if no window can be opened, or the
/// device fails
void runStudio(Gpu& gpu, const Session::Options& session, Document document, const StudioOptions& options);

}  // namespace airclay
