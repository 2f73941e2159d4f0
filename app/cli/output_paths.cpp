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
    throw Error(file.string() + ": cannot be written: it is a folder; name a file");
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, ignored))
    throw Error(file.string() + ": cannot be written: no such folder: " + folder.string());
  const bool exists = std::filesystem::exists(file, ignored);
  if (access(folder.c_str(), W_OK) == 0 || (exists && access(file.c_str(), W_OK) == 0)) return;
  throw Error(file.string() + ": cannot be written: " + std::strerror(errno) +
              "; name a file in a folder that can be");
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault || !std::filesystem::is_directory(folder, fault))
    throw Error(folder.string() + ": the folder cannot be made: " +
                (fault ? fault.message() : "something else is there") + "; name one that can be");
  if (access(folder.c_str(), W_OK) != 0)
    throw Error(folder.string() + ": the folder cannot be written: " + std::strerror(errno));
}

}  // namespace airclay
