// SPDX-License-Identifier: MIT
#include "tests/support/program.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPollInterval = std::chrono::milliseconds(5);  // short compared to any run

std::vector<std::string> mergedEnvironment(const std::map<std::string, std::string>& extra) {
  std::map<std::string, std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    all[text.substr(0, text.find('='))] = text.substr(std::min(text.find('=') + 1, text.size()));
  }
  // Windows must not open on the display of whoever runs the tests.
  all.erase("DISPLAY");
  all.erase("WAYLAND_DISPLAY");
  for (const auto& [name, value] : extra) all[name] = value;
  std::vector<std::string> entries;
  for (const auto& [name, value] : all) entries.push_back(name + "=" + value);
  return entries;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// The child's part of fork(): only async-signal-safe calls, because other threads may hold locks.
[[noreturn]] void runChild(char* const* arguments, char* const* environment, const char* output,
                           const char* errors) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a crashing test leaves no server running
  const int output_file = open(output, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int errors_file = open(errors, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int null_input = open("/dev/null", O_RDONLY);
  if (output_file < 0 || errors_file < 0 || null_input < 0) _exit(127);
  dup2(null_input, STDIN_FILENO);
  dup2(output_file, STDOUT_FILENO);
  dup2(errors_file, STDERR_FILENO);
  execvpe(arguments[0], arguments, environment);
  _exit(127);
}

}  // namespace

std::string contentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool waitUntil(const std::function<bool()>& condition, double deadline_s) {
  const auto started = Clock::now();
  while (!condition()) {
    if (std::chrono::duration<double>(Clock::now() - started).count() > deadline_s) return false;
    std::this_thread::sleep_for(kPollInterval);
  }
  return true;
}

// ------------------------------------------------------------------------------------------- programs

Process::Process(const std::vector<std::string>& arguments,
                 const std::map<std::string, std::string>& environment, const std::filesystem::path& output,
                 const std::filesystem::path& errors) {
  std::vector<std::string> all_arguments = arguments, entries = mergedEnvironment(environment);
  const std::vector<char*> argument_pointers = pointers(all_arguments), entry_pointers = pointers(entries);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ == 0) runChild(argument_pointers.data(), entry_pointers.data(), output.c_str(), errors.c_str());
}

Process::~Process() {
  if (!running()) return;
  send(SIGTERM);
  if (waitForExit(5)) return;
  send(SIGKILL);
  waitForExit();
}

std::optional<int> Process::exitStatus() {
  int state = 0;
  if (!status_ && waitpid(pid_, &state, WNOHANG) == pid_)
    status_ = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
  return status_;
}

std::optional<int> Process::waitForExit(double deadline_s) {
  waitUntil([&] { return exitStatus().has_value(); }, deadline_s);
  return status_;
}

void Process::send(int signal) {
  if (running()) kill(pid_, signal);
}

std::vector<std::string> RunResult::errorLines() const {
  std::vector<std::string> lines;
  std::istringstream in(errors);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

RunResult runAirclay(const std::vector<std::string>& arguments, const RunOptions& options) {
  const TemporaryFolder folder;
  std::vector<std::string> all = {AIRCLAY_PROGRAM};
  all.insert(all.end(), arguments.begin(), arguments.end());
  Process program(all, options.environment, folder / "output", folder / "errors");
  if (options.terminate_after_ms > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(options.terminate_after_ms));
    program.send(SIGTERM);
  }
  if (options.interrupt_when) {
    waitUntil([&] { return !program.running() || options.interrupt_when(); });
    program.send(SIGINT);
  }
  RunResult result;
  result.status = *program.waitForExit(INFINITY);
  result.output = contentOf(folder / "output");
  result.errors = contentOf(folder / "errors");
  return result;
}

RunResult runProgram(const std::vector<std::string>& arguments,
                     const std::map<std::string, std::string>& environment) {
  const TemporaryFolder folder;
  Process program(arguments, environment, folder / "output", folder / "errors");
  RunResult result;
  result.status = *program.waitForExit(INFINITY);
  result.output = contentOf(folder / "output");
  result.errors = contentOf(folder / "errors");
  return result;
}

}  // namespace airclay
