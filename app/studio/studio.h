// SPDX-License-Identifier: MIT
// The studio: live sculpting in a window.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/session/session.h"

namespace airclay {

struct StudioOptions {
  std::string title = "Airclay";
  std::optional<TriangleMesh> forearm;  ///< drawn behind the hand
  bool close_at_end = false;            ///< close the window at the end of the take; for the demo
  std::filesystem::path log;            ///< optional: writes the status once per second, as JSON lines
};

/// Opens the window and returns when it is closed. The hand comes from `session.recording`, or from the mouse
/// if that is null. Every edit is in `document` on return. \throw Error if no window can be opened, or the
/// device fails
void runStudio(Gpu& gpu, const Session::Options& session, Document document, const StudioOptions& options);

}  // namespace airclay
