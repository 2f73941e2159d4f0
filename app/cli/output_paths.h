// SPDX-License-Identifier: MIT
// Output paths, checked before work starts; and the hand options.
#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace airclay {

/// \throw Error unless `file` can be written: its folder exists and is writable. Creates nothing.
void checkWritable(const std::filesystem::path& file);

/// Creates the folder if it does not exist. \throw Error if that fails or the folder is not writable.
void makeFolder(const std::filesystem::path& folder);

/// --hand and --fit.
void addHandOption(CLI::App& command, std::string& hand);
void addFitOption(CLI::App& command, std::string& fit);
/// \throw Error (Fault::kUsage) unless the fit exists.
void checkFit(const std::string& fit);

}  // namespace airclay
