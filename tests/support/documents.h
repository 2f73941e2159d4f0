// SPDX-License-Identifier: MIT
// Documents for tests, and access to them through SQLite as another program would.
#pragma once

#include "engine/clay/document.h"
#include "tests/support/temporary_folder.h"

namespace airclay {

constexpr std::size_t kMaxDocumentBytes = std::size_t(64) << 20;

ClayState tubeState();
/// A grid of 64 x 64 control points: the limit of the solve over all rows.
ClayState largeState();
/// The state after stroke `number`: only the control points differ, and the number determines every bit.
ClayState afterStroke(ClayState state, int number);
/// The bytes of whole.clay, created in `folder`: eight entries, the sixth is current.
std::string someDocument(const TemporaryFolder& folder);

/// Runs statements on the file as another program would.
void alter(const std::filesystem::path& file, const std::string& sql);
/// The rows of a query as another program reads them; blobs as bytes.
std::vector<std::vector<std::string>> rowsOf(const std::filesystem::path& file, const std::string& sql);

/// Names in the history; > marks the current one.
std::vector<std::string> namesOf(const Document& document);
/// The message is one line, begins with the file name and contains `expected`.
void expectOneLine(const std::string& message, const std::filesystem::path& file,
                   const std::string& expected);

}  // namespace airclay
