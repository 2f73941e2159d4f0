// SPDX-License-Identifier: MIT
// Where results go, checked before the work begins; and the words on the hand.
#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace airclay {

/// \throw Error unless a file of this name could be written: its folder is there and may be written. Nothing
/// is made.
void checkWritable(const std::filesystem::path& file);

/// Makes the folder where there is none. \throw Error when that fails or it may not be written.
void makeFolder(const std::filesystem::path& folder);

/// --hand and --fit.
void addHandOption(CLI::App& command, std::string& hand);
void addFitOption(CLI::App& command, std::string& fit);
/// \throw Error (Fault::kUsage) unless the fit exists.
void checkFit(const std::string& fit);

}  // namespace airclay
