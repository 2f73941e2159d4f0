// SPDX-License-Identifier: MIT
#include "tests/support/desktop.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace airclay {
namespace {

constexpr int kScreenWidth = 1400, kScreenHeight = 960;

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

std::uint32_t bigEndian(const std::string& bytes, std::size_t word) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes.at(4 * word + i));
  return value;
}

}  // namespace

// ------------------------------------------------------------------------------------------- images

double differingFraction(const Screenshot& a, const Screenshot& b, double part) {
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

Desktop::Desktop(const Options& options) {
  // The server takes the first free number and reports it; its image is a file (-fbdir). Without -noreset, it
  // would restart whenever its last client disconnects, and drop a client that is just connecting.
  const std::filesystem::path number = folder_ / "number";
  server_.emplace(
      std::vector<std::string>{"sh", "-c",
                               "exec Xvfb -displayfd 3 -noreset -nolisten tcp -screen 0 " +
                                   std::to_string(kScreenWidth) + "x" + std::to_string(kScreenHeight) +
                                   "x24 -fbdir \"$1\" " +
                                   (options.shared_memory ? "" : "-extension MIT-SHM ") + "3> \"$1/number\"",
                               "sh", folder_.path().string()},
      std::map<std::string, std::string>{}, folder_ / "server_output", folder_ / "server_errors");
  if (!waitUntil([&] { return contentOf(number).ends_with("\n") || !server_->running(); }) ||
      !server_->running())
    throw std::runtime_error("no display: " + contentOf(folder_ / "server_errors"));
  display_ = ":" + contentOf(number);
  display_.pop_back();
  manager_.emplace(std::vector<std::string>{"openbox", "--sm-disable"}, environment(),
                   folder_ / "manager_output", folder_ / "manager_errors");
  // The window manager is ready once it has set the number of desktops.
  if (!waitUntil([&] { return !xdotool({"get_num_desktops"}).empty() || !manager_->running(); }) ||
      !manager_->running())
    throw std::runtime_error("no window manager: " + contentOf(folder_ / "manager_errors"));
}

Desktop::~Desktop() = default;

std::map<std::string, std::string> Desktop::environment() const {
  return {{"DISPLAY", display_},
          {"XAUTHORITY", ""},
          {"XDG_CONFIG_HOME", folder_ / "config"},
          {"XDG_CACHE_HOME", folder_ / "cache"},
          {"XDG_DATA_HOME", folder_ / "data"},
          {"XDG_STATE_HOME", folder_ / "state"}};
}

Screenshot Desktop::screenshot() const {
  // X's dump format (XWDFile.h): a header of big-endian 32-bit values, a colour map of 12 bytes per entry,
  // the pixels
  const std::string dump = contentOf(folder_ / "Xvfb_screen0");
  const std::size_t width = bigEndian(dump, 4), height = bigEndian(dump, 5), row_bytes = bigEndian(dump, 12);
  const std::size_t first = bigEndian(dump, 0) + 12 * bigEndian(dump, 19);
  Screenshot shot{static_cast<int>(width), static_cast<int>(height), {}};
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      for (const std::size_t channel : {2, 1, 0})  // B G R and padding
        shot.rgb.push_back(static_cast<std::uint8_t>(dump.at(first + y * row_bytes + 4 * x + channel)));
  return shot;
}

std::string Desktop::xdotool(const std::vector<std::string>& arguments) const {
  std::vector<std::string> all = {"xdotool"};
  all.insert(all.end(), arguments.begin(), arguments.end());
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
