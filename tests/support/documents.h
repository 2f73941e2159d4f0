// SPDX-License-Identifier: MIT
// Documents for tests, and how another program would read and alter them.
#pragma once

#include "engine/clay/document.h"
#include "tests/support/temporary_folder.h"

namespace airclay {

constexpr std::size_t kMaxDocumentBytes = std::size_t(64) << 20;

ClayState tubeState();
/// A grid of 64 x 64 control points: as many as the solve over all rows takes.
ClayState largeState();
/// The state after stroke `number`: other control points, nothing else, every bit of them told by the number.
ClayState afterStroke(ClayState state, int number);
/// The bytes of whole.clay, made in `folder`: eight entries, of which the sixth is current.
std::string someDocument(const TemporaryFolder& folder);

/// Statements as another program would run them on the file.
void alter(const std::filesystem::path& file, const std::string& sql);
/// The rows of a query as another program reads them; bytes as they are.
std::vector<std::vector<std::string>> rowsOf(const std::filesystem::path& file, const std::string& sql);

/// Of the history, the current one with a > before it.
std::vector<std::string> namesOf(const Document& document);
/// The message is one line, begins with the file's name and says `expected`.
void expectOneLine(const std::string& message, const std::filesystem::path& file,
                   const std::string& expected);

}  // namespace airclay
