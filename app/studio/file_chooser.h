// SPDX-License-Identifier: MIT
// Which file: a name typed, or picked from a folder's list.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace airclay {

class FileChooser {
 public:
  using Chosen = std::function<void(const std::filesystem::path&)>;

  /// Opens it in `folder`. `extensions` are shown (".clay"); an unnamed ending becomes the first when
  /// `to_write`.
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
