// SPDX-License-Identifier: MIT
// A display of a test's own, with a window manager, and what somebody sitting before it would do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace airclay {

/// How long a test waits for what must come: long, as machines are slow, and only a failure takes it.
inline constexpr double kDeadlineS = 60;

/// Looks again and again whether `true_yet`; false when it never was.
bool waitUntil(const std::function<bool()>& true_yet, double deadline_s = kDeadlineS);

/// A program that runs beside the test, and ends with it.
class Process {
 public:
  /// `words` begin with the program's name, looked for in PATH. Output and errors go to files.
  Process(const std::vector<std::string>& words, const std::map<std::string, std::string>& environment,
          const std::filesystem::path& output, const std::filesystem::path& errors);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool running() { return !exitStatus(); }
  /// 128 + the signal that ended it; none while it runs.
  std::optional<int> exitStatus();
  /// The same, once it has ended; none when it doesn't.
  std::optional<int> waitForExit(double deadline_s = kDeadlineS);
  void send(int signal);

 private:
  int pid_ = -1;
  std::optional<int> status_;
};

/// Colours as they stand on the display: R G B, rows from the top.
struct Screenshot {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};
/// How much of the picture differs by more than a few of 255 levels, of 1, within a part of it that is
/// centred and `part` times as wide and high.
double differingShare(const Screenshot& a, const Screenshot& b, double part);

class Desktop {
 public:
  /// Whether there is an X server that needs no screen.
  static bool possible();

  /// Ready when this returns: the window manager has taken over.
  Desktop();
  ~Desktop();

  /// What a program must have in its environment to come up here.
  std::map<std::string, std::string> environment() const;
  Screenshot screenshot() const;

  // --- as xdotool does it, to the window that is the only one ---
  /// Waits for it, and for it to have the keyboard.
  void findWindow(const std::string& title);
  /// As xdotool names them: "ctrl+shift+z".
  void key(const std::string& keys);
  void keyDown(const std::string& key);
  void keyUp(const std::string& key);
  void type(const std::string& text);
  /// From the window's upper left corner.
  void moveTo(int x, int y);
  void press(int button = 1);
  void release(int button = 1);
  void resize(int width, int height);
  void minimise();
  void restore();

 private:
  std::string xdotool(const std::vector<std::string>& words) const;

  TemporaryFolder folder_;
  std::string display_, window_;
  std::optional<Process> server_, manager_;
};

}  // namespace airclay
