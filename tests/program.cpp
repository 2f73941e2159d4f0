// SPDX-License-Identifier: MIT
#include "tests/program.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/temporary_folder.h"

namespace airclay {
namespace {

std::string contentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// The child's side of fork(): only calls that are safe there, for other threads may hold locks.
[[noreturn]] void become(char* const* arguments, char* const* environment, const char* output,
                         const char* errors) {
  const int to_output = open(output, O_WRONLY | O_CREAT, 0600);
  const int to_errors = open(errors, O_WRONLY | O_CREAT, 0600);
  const int from_nothing = open("/dev/null", O_RDONLY);
  if (to_output < 0 || to_errors < 0 || from_nothing < 0) _exit(127);
  dup2(from_nothing, STDIN_FILENO);
  dup2(to_output, STDOUT_FILENO);
  dup2(to_errors, STDERR_FILENO);
  execve(AIRCLAY_PROGRAM, arguments, environment);
  _exit(127);
}

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

}  // namespace

std::vector<std::string> Ran::errorLines() const {
  std::vector<std::string> lines;
  std::istringstream in(errors);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Ran runAirclay(const std::vector<std::string>& words, const RunOptions& options) {
  const TemporaryFolder folder;
  const std::string output = folder / "output", errors = folder / "errors";
  std::vector<std::string> arguments = {"airclay"};
  arguments.insert(arguments.end(), words.begin(), words.end());
  std::vector<std::string> environment = mergedEnvironment(options.environment);
  const std::vector<char*> argument_pointers = pointers(arguments),
                           environment_pointers = pointers(environment);

  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0)
    become(argument_pointers.data(), environment_pointers.data(), output.c_str(), errors.c_str());
  if (options.terminate_after_ms > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(options.terminate_after_ms));
    kill(child, SIGTERM);
  }
  int state = 0;
  if (waitpid(child, &state, 0) != child) throw std::runtime_error("cannot wait for the program");
  Ran ran;
  ran.status = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
  ran.output = contentOf(output);
  ran.errors = contentOf(errors);
  return ran;
}

}  // namespace airclay
