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

constexpr auto kLookAgain = std::chrono::milliseconds(5);  // short beside any run

std::vector<std::string> mergedEnvironment(const std::map<std::string, std::string>& extra) {
  std::map<std::string, std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    all[text.substr(0, text.find('='))] = text.substr(std::min(text.find('=') + 1, text.size()));
  }
  // whoever runs the tests may sit before a display: it is not for windows of theirs
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

/// The child's side of fork(): only calls that are safe there, for other threads may hold locks.
[[noreturn]] void become(char* const* words, char* const* environment, const char* output,
                         const char* errors) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that crashes leaves no display behind
  const int to_output = open(output, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int to_errors = open(errors, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int from_nothing = open("/dev/null", O_RDONLY);
  if (to_output < 0 || to_errors < 0 || from_nothing < 0) _exit(127);
  dup2(from_nothing, STDIN_FILENO);
  dup2(to_output, STDOUT_FILENO);
  dup2(to_errors, STDERR_FILENO);
  execvpe(words[0], words, environment);
  _exit(127);
}

}  // namespace

std::string contentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool waitUntil(const std::function<bool()>& true_yet, double deadline_s) {
  const auto since = Clock::now();
  while (!true_yet()) {
    if (std::chrono::duration<double>(Clock::now() - since).count() > deadline_s) return false;
    std::this_thread::sleep_for(kLookAgain);
  }
  return true;
}

// ------------------------------------------------------------------------------------------- programs

Process::Process(const std::vector<std::string>& words, const std::map<std::string, std::string>& environment,
                 const std::filesystem::path& output, const std::filesystem::path& errors) {
  std::vector<std::string> all_words = words, entries = mergedEnvironment(environment);
  const std::vector<char*> word_pointers = pointers(all_words), entry_pointers = pointers(entries);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ == 0) become(word_pointers.data(), entry_pointers.data(), output.c_str(), errors.c_str());
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

std::vector<std::string> Ran::errorLines() const {
  std::vector<std::string> lines;
  std::istringstream in(errors);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Ran runAirclay(const std::vector<std::string>& words, const RunOptions& options) {
  const TemporaryFolder folder;
  std::vector<std::string> all = {AIRCLAY_PROGRAM};
  all.insert(all.end(), words.begin(), words.end());
  Process program(all, options.environment, folder / "output", folder / "errors");
  if (options.terminate_after_ms > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(options.terminate_after_ms));
    program.send(SIGTERM);
  }
  if (options.interrupt_when) {
    waitUntil([&] { return !program.running() || options.interrupt_when(); });
    program.send(SIGINT);
  }
  Ran ran;
  ran.status = *program.waitForExit(INFINITY);
  ran.output = contentOf(folder / "output");
  ran.errors = contentOf(folder / "errors");
  return ran;
}

Ran runProgram(const std::vector<std::string>& arguments,
               const std::map<std::string, std::string>& environment) {
  const TemporaryFolder folder;
  Process program(arguments, environment, folder / "output", folder / "errors");
  Ran ran;
  ran.status = *program.waitForExit(INFINITY);
  ran.output = contentOf(folder / "output");
  ran.errors = contentOf(folder / "errors");
  return ran;
}

}  // namespace airclay
