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

/// Parses a number from a text file; empty if it is not one, or not finite. Independent of the locale.
std::optional<double> parseNumber(std::string_view text);
/// The inverse: as many digits as needed to read the same number back.
std::string exactNumber(double value);

/// Text from a file, made safe for a one-line message: other bytes become `?`, at most 40 characters.
std::string printable(std::string_view word);

/// The file's extension in lower case: ".obj" of Cube.OBJ.
std::string lowerCaseExtension(const std::filesystem::path& file);

/// Writes `content` atomically: the file appears whole or not at all. \throw Error when it cannot be written
void writeWhole(const std::filesystem::path& file, const std::string& content);

}  // namespace airclay
