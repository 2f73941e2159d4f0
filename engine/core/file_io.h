// SPDX-License-Identifier: MIT
// Whole files, and the numbers in text files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace airclay {

/// A file's bytes. \throw Error when it cannot be read or is larger than `max_bytes`.
std::string readWhole(const std::filesystem::path& file, size_t max_bytes);

/// A word of a text file as a number; none when it isn't one, or isn't finite. The same in every locale.
std::optional<double> parseNumber(std::string_view word);
/// Its inverse: with all the digits that bring the same number back.
std::string exactNumber(double value);

/// A word of a file as it can stand in a one-line message: other bytes as `?`, at most 40.
std::string printable(std::string_view word);

/// Writes `content` so that the file appears whole or not at all. \throw Error when the folder cannot be
/// written.
void writeWhole(const std::filesystem::path& file, const std::string& content);

}  // namespace airclay
