// SPDX-License-Identifier: MIT
// Output paths, checked before work starts.
#pragma once

#include <filesystem>

namespace airclay {

/// \throw Error unless `file` can be written: its folder exists and is writable. Creates nothing.
void checkWritable(const std::filesystem::path& file);

/// Creates the folder if it does not exist. \throw Error if that fails or the folder is not writable.
void makeFolder(const std::filesystem::path& folder);

}  // namespace airclay
