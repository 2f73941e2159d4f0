// SPDX-License-Identifier: MIT
#include "app/cli/output_paths.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "engine/core/error.h"

namespace airclay {

void checkWritable(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(file.string() + ": cannot be written: it is a folder; expected a file");
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, ignored))
    throw Error(file.string() + ": cannot be written: no such folder: " + folder.string());
  const bool exists = std::filesystem::exists(file, ignored);
  if (access(folder.c_str(), W_OK) == 0 || (exists && access(file.c_str(), W_OK) == 0)) return;
  throw Error(file.string() + ": cannot be written: " + std::strerror(errno) +
              "; use a file in a writable folder");
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error))
    throw Error(folder.string() + ": the folder cannot be created: " +
                (error ? error.message() : "there is a file of that name") + "; use another name");
  if (access(folder.c_str(), W_OK) != 0)
    throw Error(folder.string() + ": the folder cannot be written: " + std::strerror(errno));
}

}  // namespace airclay
