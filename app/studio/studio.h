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
  bool close_at_end = false;            ///< of the take: the demo's
  std::filesystem::path log;            ///< optional: a line of JSON a second with what the status shows
};

/// Opens the window and stays until it is closed. The hand is `session.recording`'s, or the mouse's where
/// there is none. Every edit is in `document` when this returns. \throw Error when no window can be opened,
/// or the device fails
void runStudio(Gpu& gpu, const Session::Options& session, Document document, const StudioOptions& options);

}  // namespace airclay
