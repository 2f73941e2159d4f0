// SPDX-License-Identifier: MIT
// Runs programs, above all the built `airclay`, as a user would.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace airclay {

/// Timeout of waits: long, because machines may be slow and only failures reach it.
inline constexpr double kDeadlineS = 60;

/// Polls `condition`. Returns false after the timeout.
bool waitUntil(const std::function<bool()>& condition, double deadline_s = kDeadlineS);

/// A child process; the destructor ends it.
class Process {
 public:
  /// `arguments` begin with the program's name, searched in PATH. Output and errors go to files.
  Process(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment,
          const std::filesystem::path& output, const std::filesystem::path& errors);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool running() { return !exitStatus(); }
  /// Exit status, or 128 + the signal that ended it; empty while it runs.
  std::optional<int> exitStatus();
  /// The same after waiting; empty after the timeout.
  std::optional<int> waitForExit(double deadline_s = kDeadlineS);
  void send(int signal);

 private:
  int pid_ = -1;
  std::optional<int> status_;
};

/// The content of a file; empty if the file does not exist.
std::string contentOf(const std::filesystem::path& file);

/// The result of a finished program.
struct RunResult {
  int status = -1;  ///< exit status, or 128 + the signal that ended it
  std::string output, errors;

  /// Lines of standard error.
  std::vector<std::string> errorLines() const;
};

struct RunOptions {
  std::map<std::string, std::string> environment;  ///< in addition to this process's
  int terminate_after_ms = 0;                      ///< SIGTERM after this time; 0: never
  std::function<bool()> interrupt_when;            ///< SIGINT, like Ctrl-C, once this returns true
};

/// Runs `airclay` with these arguments; standard output and error are not terminals.
RunResult runAirclay(const std::vector<std::string>& arguments, const RunOptions& options = {});

/// Runs the program `arguments[0]`, searched in PATH, until it ends.
RunResult runProgram(const std::vector<std::string>& arguments,
                     const std::map<std::string, std::string>& environment = {});

}  // namespace airclay
