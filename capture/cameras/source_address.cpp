// SPDX-License-Identifier: MIT
// The parts of camera_source.h that do not need OpenCV: parsing of sources, and times from arrivals.
#include <algorithm>
#include <cctype>
#include <cstring>

#include "capture/cameras/camera_source.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

bool isNumber(const std::string& text) {
  return !text.empty() && text.size() <= 3 && text.find_first_not_of("0123456789") == std::string::npos;
}

/// img_%04d.png: a '%', digits, and a 'd'.
bool isPattern(const std::string& text) {
  const std::size_t percent = text.find('%');
  if (percent == std::string::npos) return false;
  const std::size_t end = text.find_first_not_of("0123456789", percent + 1);
  return end != std::string::npos && text[end] == 'd';
}

}  // namespace

Source parseSource(const std::string& source) {
  const auto startsWith = [&](const char* scheme) { return source.starts_with(scheme); };
  const std::string forms =
      "expected a device number or /dev/videoN, a video file, a folder or pattern of images (img_%04d.png), "
      "rtsp://... or gst: and a pipeline";
  if (source.empty()) throw Error("the source is empty; " + forms);
  if (isNumber(source)) return {SourceKind::kDevice, "/dev/video" + std::to_string(std::stoi(source))};
  if (startsWith("/dev/")) return {SourceKind::kDevice, source};
  if (startsWith("gst:")) {
    const std::size_t first = source.find_first_not_of(' ', 4);
    if (first == std::string::npos) throw Error("the source \"gst:\" has no pipeline; " + forms);
    return {SourceKind::kPipeline, source.substr(first)};
  }
  for (const char* scheme : {"rtsp://", "rtsps://", "rtmp://", "http://", "https://", "tcp://", "udp://"})
    if (startsWith(scheme)) return {SourceKind::kStream, source};
  if (source.find('!') != std::string::npos && !std::filesystem::exists(source))
    return {SourceKind::kPipeline, source};
  if (const std::size_t scheme = source.find("://"); scheme != std::string::npos)
    throw Error("\"" + source.substr(0, scheme) + "://\" is not a kind of source; " + forms);
  if (std::filesystem::is_directory(source) || isPattern(source)) return {SourceKind::kImages, source};
  return {SourceKind::kVideo, source};
}

NamedSource parseNamedSource(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const auto fits = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("-_.", c);
  };
  if (equals == std::string::npos || name.empty() || name.size() > 60 || name[0] == '.' ||
      !std::all_of(name.begin(), name.end(), fits))
    throw Error(
        "--camera " + text +
            ": it must be NAME=SOURCE with a name of letters, digits, '-', '_' and '.', such as left=0 "
            "or left=left.mp4",
        Fault::kUsage);
  try {
    return {name, parseSource(text.substr(equals + 1))};
  } catch (const Error& error) {
    throw Error("--camera " + text + ": " + error.what(), Fault::kUsage);
  }
}

const char* nameOf(TimeOrigin origin) {
  switch (origin) {
    case TimeOrigin::kBuffer:
      return "buffer times";
    case TimeOrigin::kFile:
      return "the file's rate";
    default:
      return "arrival, delay unknown";
  }
}

double ArrivalClock::captureOf(double arrival_s, double stream_s) {
  // A lasting step up (the stream restarted, or its clock was set) makes the old envelope invalid.
  constexpr std::size_t kFew = 8;
  constexpr double kStepS = 0.5;
  delays_s_.push_back(arrival_s - stream_s);
  if (delays_s_.size() > kFrames) delays_s_.pop_front();
  const auto few = delays_s_.end() - static_cast<std::ptrdiff_t>(std::min(kFew, delays_s_.size()));
  const double least_s = *std::min_element(delays_s_.begin(), delays_s_.end());
  const double least_of_few_s = *std::min_element(few, delays_s_.end());
  if (least_of_few_s - least_s <= kStepS) return stream_s + least_s;
  delays_s_.erase(delays_s_.begin(), few);
  return stream_s + least_of_few_s;
}

}  // namespace airclay
