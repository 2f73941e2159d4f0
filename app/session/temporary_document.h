// SPDX-License-Identifier: MIT
// A temporary file for a document.
#pragma once

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "engine/core/error.h"

namespace airclay {

/// The path of a document in a new folder of the system's temporary folder. The destructor removes the folder
/// with all that SQLite leaves next to the document. Only a crash leaves it behind.
class TemporaryDocument {
 public:
  /// \throw Error if the folder cannot be created.
  explicit TemporaryDocument(const std::filesystem::path& name = "clay.clay") {
    std::string folder = (std::filesystem::temp_directory_path() / "airclay-XXXXXX").string();
    if (!::mkdtemp(folder.data()))
      throw Error(folder + ": cannot create a temporary folder: " + std::strerror(errno) +
                  "; set TMPDIR to a writable folder");
    folder_ = folder;
    file_ = folder_ / name;
  }
  ~TemporaryDocument() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TemporaryDocument(const TemporaryDocument&) = delete;
  TemporaryDocument& operator=(const TemporaryDocument&) = delete;

  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path folder_, file_;
};

}  // namespace airclay
