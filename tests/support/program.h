// SPDX-License-Identifier: MIT
// Programs that tests run: above all the built one, run as a user runs it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

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

/// What a file holds; nothing where there is none.
std::string contentOf(const std::filesystem::path& file);

/// What a run left.
struct Ran {
  int status = -1;  ///< exit status; 128 + the signal that ended it
  std::string output, errors;

  /// Lines of standard error.
  std::vector<std::string> errorLines() const;
};

struct RunOptions {
  std::map<std::string, std::string> environment;  ///< on top of this process' own
  int terminate_after_ms = 0;                      ///< SIGTERM after so long; 0: let it end
  std::function<bool()> interrupt_when;            ///< SIGINT as soon as this is so, as Ctrl-C gives it
};

/// Runs `airclay` with these words; neither of its streams is a terminal.
Ran runAirclay(const std::vector<std::string>& words, const RunOptions& options = {});

/// Runs a program, the first of `arguments`, looked up in PATH, until it ends.
Ran runProgram(const std::vector<std::string>& arguments,
               const std::map<std::string, std::string>& environment = {});

}  // namespace airclay
