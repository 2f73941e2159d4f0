// SPDX-License-Identifier: MIT
// File dialog: type a name or pick a file from a folder.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace airclay {

class FileChooser {
 public:
  using Chosen = std::function<void(const std::filesystem::path&)>;

  /// Opens the dialog in `folder` and lists files with these `extensions` (".clay"). If `to_write`, a name
  /// without an extension gets the first one.
  void open(const std::string& title, const std::filesystem::path& folder,
            std::vector<std::string> extensions, bool to_write, Chosen chosen);
  bool isOpen() const { return open_; }
  /// \pre between Window::begin(), with an interface, and draw()
  void draw();

 private:
  struct Listed {
    std::string name;
    bool is_folder = false;
  };
  void goTo(const std::filesystem::path& folder);
  bool accept();
  void drawList();

  bool open_ = false, asked_ = false, to_write_ = false;
  std::string title_, error_, name_;
  std::filesystem::path folder_;
  std::vector<std::string> extensions_;
  std::vector<Listed> listed_;
  Chosen chosen_;
};

}  // namespace airclay
