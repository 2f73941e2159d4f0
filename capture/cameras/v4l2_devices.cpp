// SPDX-License-Identifier: MIT
// Uses the enumeration ioctls of the Linux media documentation, "Video for Linux API": VIDIOC_QUERYCAP,
// ENUM_FMT, ENUM_FRAMESIZES, ENUM_FRAMEINTERVALS.
#include "capture/cameras/v4l2_devices.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace airclay {
namespace {

// A limit for broken drivers that never end their lists.
constexpr unsigned kMaxEntries = 256;

struct Node {
  explicit Node(const std::string& path) : file(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {}
  ~Node() {
    if (file >= 0) close(file);
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  template <class Argument>
  bool ask(unsigned long request, Argument& argument) const {
    return ioctl(file, request, &argument) == 0;
  }
  int file;
};

template <std::size_t size>
std::string textOf(const unsigned char (&bytes)[size]) {
  return {bytes, std::find(bytes, bytes + size, 0)};
}

std::vector<double> ratesOf(const Node& node, unsigned format, ImageSize size) {
  std::vector<double> rates_hz;
  v4l2_frmivalenum interval{};
  interval.pixel_format = format;
  interval.width = static_cast<unsigned>(size.width);
  interval.height = static_cast<unsigned>(size.height);
  for (; interval.index < kMaxEntries && node.ask(VIDIOC_ENUM_FRAMEINTERVALS, interval); ++interval.index) {
    const bool discrete = interval.type == V4L2_FRMIVAL_TYPE_DISCRETE;
    const v4l2_fract& period = discrete ? interval.discrete : interval.stepwise.min;
    if (period.numerator > 0) rates_hz.push_back(double(period.denominator) / period.numerator);
    if (!discrete) break;  // a range: list its fastest rate
  }
  std::sort(rates_hz.rbegin(), rates_hz.rend());
  return rates_hz;
}

void addModes(const Node& node, unsigned format, std::vector<V4l2Mode>& modes) {
  std::string letters;
  for (int shift = 0; shift < 32; shift += 8) letters += static_cast<char>(format >> shift & 0x7f);
  v4l2_frmsizeenum entry{};
  entry.pixel_format = format;
  for (; entry.index < kMaxEntries && node.ask(VIDIOC_ENUM_FRAMESIZES, entry); ++entry.index) {
    const bool discrete = entry.type == V4L2_FRMSIZE_TYPE_DISCRETE;
    const ImageSize size = discrete
                               ? ImageSize{int(entry.discrete.width), int(entry.discrete.height)}
                               : ImageSize{int(entry.stepwise.max_width), int(entry.stepwise.max_height)};
    modes.push_back({letters, size, ratesOf(node, format, size)});
    if (!discrete) break;  // a range: list its largest size
  }
}

}  // namespace

std::vector<V4l2Device> listV4l2Devices() {
  std::map<int, std::string> paths;
  std::error_code fault;
  for (std::filesystem::directory_iterator at("/dev", fault), end; !fault && at != end; at.increment(fault)) {
    const std::string name = at->path().filename().string();
    const std::string number = name.starts_with("video") ? name.substr(5) : "";
    if (!number.empty() && number.size() < 4 && number.find_first_not_of("0123456789") == std::string::npos)
      paths[std::stoi(number)] = at->path().string();
  }
  std::vector<V4l2Device> devices;
  for (const auto& [number, path] : paths) {
    const Node node(path);
    v4l2_capability capability{};
    if (node.file < 0 || !node.ask(VIDIOC_QUERYCAP, capability)) continue;
    const bool has_own = capability.capabilities & V4L2_CAP_DEVICE_CAPS;
    if (!((has_own ? capability.device_caps : capability.capabilities) & V4L2_CAP_VIDEO_CAPTURE)) continue;
    V4l2Device device{
        path, textOf(capability.card), textOf(capability.driver), textOf(capability.bus_info), {}};
    v4l2_fmtdesc format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; format.index < kMaxEntries && node.ask(VIDIOC_ENUM_FMT, format); ++format.index)
      addModes(node, format.pixelformat, device.modes);
    if (!device.modes.empty()) devices.push_back(device);
  }
  return devices;
}

}  // namespace airclay
