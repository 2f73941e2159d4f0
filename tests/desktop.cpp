// SPDX-License-Identifier: MIT
#include "tests/desktop.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace airclay {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kScreenWidth = 1400, kScreenHeight = 960;
// Every few steps of a drag: about as often as a mouse tells where it is.
constexpr auto kLookAgain = std::chrono::milliseconds(20);

std::string contentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool isInPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string folders = path ? path : "";
  for (std::size_t start = 0; start <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', start), folders.size());
    if (access((folders.substr(start, end - start) + "/" + program).c_str(), X_OK) == 0) return true;
    start = end + 1;
  }
  return false;
}

std::vector<std::string> mergedEnvironment(const std::map<std::string, std::string>& extra) {
  std::map<std::string, std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    all[text.substr(0, text.find('='))] = text.substr(std::min(text.find('=') + 1, text.size()));
  }
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

std::uint32_t bigEndian(const std::string& bytes, std::size_t word) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes.at(4 * word + i));
  return value;
}

}  // namespace

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

// ------------------------------------------------------------------------------------------- pictures

double differingShare(const Screenshot& a, const Screenshot& b, double part) {
  if (a.width != b.width || a.height != b.height) return 1;
  const int left = static_cast<int>(a.width * (1 - part) / 2),
            top = static_cast<int>(a.height * (1 - part) / 2);
  std::size_t all = 0, differing = 0;
  for (int y = top; y < a.height - top; ++y)
    for (int x = left; x < a.width - left; ++x, ++all) {
      const std::size_t at = 3 * (std::size_t(y) * std::size_t(a.width) + std::size_t(x));
      int most = 0;
      for (std::size_t i = at; i < at + 3; ++i)
        most = std::max(most, std::abs(int(a.rgb[i]) - int(b.rgb[i])));
      differing += most > 6;
    }
  return static_cast<double>(differing) / static_cast<double>(std::max<std::size_t>(all, 1));
}

// ------------------------------------------------------------------------------------------ the display

bool Desktop::possible() {
  return isInPath("Xvfb");
}

Desktop::Desktop() {
  // The server takes the first free number and says which; its picture is a file (-fbdir).
  const std::filesystem::path number = folder_ / "number";
  server_.emplace(
      std::vector<std::string>{"sh", "-c",
                               "exec Xvfb -displayfd 3 -nolisten tcp -screen 0 " +
                                   std::to_string(kScreenWidth) + "x" + std::to_string(kScreenHeight) +
                                   "x24 -fbdir \"$1\" 3> \"$1/number\"",
                               "sh", folder_.path().string()},
      std::map<std::string, std::string>{}, folder_ / "server_output", folder_ / "server_errors");
  if (!waitUntil([&] { return contentOf(number).ends_with("\n") || !server_->running(); }) ||
      !server_->running())
    throw std::runtime_error("no display: " + contentOf(folder_ / "server_errors"));
  display_ = ":" + contentOf(number);
  display_.pop_back();
  manager_.emplace(std::vector<std::string>{"openbox", "--sm-disable"}, environment(),
                   folder_ / "manager_output", folder_ / "manager_errors");
  // It is there once it has said how many desktops there are.
  if (!waitUntil([&] { return !xdotool({"get_num_desktops"}).empty() || !manager_->running(); }) ||
      !manager_->running())
    throw std::runtime_error("no window manager: " + contentOf(folder_ / "manager_errors"));
}

Desktop::~Desktop() = default;

std::map<std::string, std::string> Desktop::environment() const {
  return {{"DISPLAY", display_},
          {"WAYLAND_DISPLAY", ""},
          {"XAUTHORITY", ""},
          {"XDG_CONFIG_HOME", folder_ / "config"},
          {"XDG_CACHE_HOME", folder_ / "cache"},
          {"XDG_DATA_HOME", folder_ / "data"},
          {"XDG_STATE_HOME", folder_ / "state"}};
}

Screenshot Desktop::screenshot() const {
  // X's own dump (XWDFile.h): a header of big-endian words, a colour map of 12 bytes an entry, the pixels
  const std::string dump = contentOf(folder_ / "Xvfb_screen0");
  const std::size_t width = bigEndian(dump, 4), height = bigEndian(dump, 5), row_bytes = bigEndian(dump, 12);
  const std::size_t first = bigEndian(dump, 0) + 12 * bigEndian(dump, 19);
  Screenshot shot{static_cast<int>(width), static_cast<int>(height), {}};
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      for (const std::size_t channel : {2, 1, 0})  // B G R and nothing
        shot.rgb.push_back(static_cast<std::uint8_t>(dump.at(first + y * row_bytes + 4 * x + channel)));
  return shot;
}

std::string Desktop::xdotool(const std::vector<std::string>& words) const {
  std::vector<std::string> all = {"xdotool"};
  all.insert(all.end(), words.begin(), words.end());
  Process process(all, environment(), folder_ / "tool_output", folder_ / "tool_errors");
  if (process.waitForExit() != 0) return "";
  std::string said = contentOf(folder_ / "tool_output");
  while (said.ends_with("\n")) said.pop_back();
  return said;
}

void Desktop::findWindow(const std::string& title) {
  const auto found = [&] {
    window_ = xdotool({"search", "--onlyvisible", "--name", title});
    return !window_.empty() && window_.find('\n') == std::string::npos;
  };
  if (!waitUntil(found)) throw std::runtime_error("there is no window " + title);
  xdotool({"windowactivate", window_});
  if (!waitUntil([&] { return xdotool({"getwindowfocus"}) == window_; }))
    throw std::runtime_error("the window " + title + " gets no keyboard");
}

void Desktop::key(const std::string& keys) {
  xdotool({"key", keys});
}
void Desktop::keyDown(const std::string& key) {
  xdotool({"keydown", key});
}
void Desktop::keyUp(const std::string& key) {
  xdotool({"keyup", key});
}
void Desktop::type(const std::string& text) {
  xdotool({"type", "--delay", "5", text});
}
void Desktop::moveTo(int x, int y) {
  xdotool({"mousemove", "--window", window_, std::to_string(x), std::to_string(y)});
}
void Desktop::press(int button) {
  xdotool({"mousedown", std::to_string(button)});
}
void Desktop::release(int button) {
  xdotool({"mouseup", std::to_string(button)});
}
void Desktop::resize(int width, int height) {
  xdotool({"windowsize", window_, std::to_string(width), std::to_string(height)});
}
void Desktop::minimise() {
  xdotool({"windowminimize", window_});
}
void Desktop::restore() {
  xdotool({"windowactivate", window_});
}

}  // namespace airclay
