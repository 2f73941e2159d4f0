// SPDX-License-Identifier: MIT
#include "app/cli/camera_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "app/cli/board_options.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& value, const std::string& right) {
  throw Error(option + " " + value + "; expected " + right, Fault::kUsage);
}

ImageSize sizeOf(const std::string& text) {
  const auto [width, height] = parsePair("--mode", text);
  if (std::min(width, height) < kMinImageSide || std::max(width, height) > kMaxImageSide)
    refuse("--mode", text,
           "sides from " + std::to_string(kMinImageSide) + " to " + std::to_string(kMaxImageSide));
  return {width, height};
}

}  // namespace

std::vector<NamedSource> CameraOptions::sources() const {
  std::vector<NamedSource> sources;
  for (const std::string& text : cameras) {
    NamedSource source = parseNamedSource(text);
    if (std::any_of(sources.begin(), sources.end(),
                    [&](const NamedSource& other) { return other.name == source.name; }))
      refuse("--camera", text, "another name; this one is already used");
    sources.push_back(std::move(source));
  }
  if (sources.size() > kMaxCameras)
    refuse("--camera", std::to_string(sources.size()) + " cameras", "at most " + std::to_string(kMaxCameras));
  return sources;
}

SourceOptions CameraOptions::sourceOptions() const {
  SourceOptions options;
  options.format = format;
  options.exposure = exposure;
  options.gain = gain;
  options.loop = loop;
  options.size = usual_size;
  if (mode.empty()) return options;
  const std::size_t at = mode.find('@');
  options.size = sizeOf(mode.substr(0, at));
  if (at == std::string::npos) return options;
  options.rate_hz = parseNumber(mode.substr(at + 1));
  if (!options.rate_hz || !(*options.rate_hz > 0 && *options.rate_hz <= 1000))
    refuse("--mode", mode, "a rate above 0 and at most 1000, as 640x480@30");
  return options;
}

std::vector<LiveCamera> CameraOptions::live(const std::vector<NamedSource>& sources) const {
  std::vector<LiveCamera> all;
  for (const NamedSource& source : sources) all.push_back(liveCamera(source, sourceOptions()));
  for (const std::string& text : offsets) {
    const auto [name, offset_s] = parseOffset(text);
    const auto found = std::ranges::find(all, name, &LiveCamera::name);
    if (found == all.end()) refuse("--offset", text, "NAME=MS with the name of a --camera, as left=12.5");
    found->offset_s = offset_s;
  }
  return all;
}

LiveOptions CameraOptions::liveOptions(LiveOptions::Sets sets) const {
  LiveOptions options;
  options.sets = sets;
  if (max_skew_ms && !(*max_skew_ms > 0 && *max_skew_ms <= 1000))
    refuse("--max-skew-ms", exactNumber(*max_skew_ms), "above 0 and at most 1000");
  if (max_skew_ms) options.max_skew_s = *max_skew_ms / 1000;
  return options;
}

std::pair<std::string, double> parseOffset(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const std::optional<double> offset_ms =
      equals == std::string::npos ? std::nullopt : parseNumber(text.substr(equals + 1));
  if (!offset_ms || equals == 0) refuse("--offset", text, "NAME=MS with the name of a camera, as left=12.5");
  return {text.substr(0, equals), *offset_ms / 1000};
}

void addOffsetOption(CLI::App& command, std::vector<std::string>& offsets) {
  if (command.get_option_no_throw("--offset")) return;
  command
      .add_option("--offset", offsets,
                  "milliseconds by which a camera's timestamps are late; repeat for each camera [0]")
      ->type_name("NAME=MS")
      ->allow_extra_args(false);
}

void addCameraOptions(CLI::App& command, CameraOptions& options) {
  const auto one = [](CLI::Option* option) { option->allow_extra_args(false); };
  CLI::Option* camera = command.add_option(
      "--camera", options.cameras,
      "name and source of a camera; repeat for each camera. A source is a device number, /dev/videoN, a "
      "video "
      "file, a folder or pattern of images (img_%04d.png), rtsp://..., http://..., or a GStreamer pipeline "
      "(gst: ...)");
  camera->type_name("NAME=SOURCE");
  one(camera);
  command.add_option("--mode", options.mode, "image size and frame rate of the devices [their current mode]")
      ->type_name("WxH@HZ");
  command
      .add_option("--format", options.format,
                  "pixel format of the devices: MJPG, YUYV [their current format]")
      ->type_name("CODE");
  command.add_option("--exposure", options.exposure, "lock the exposure, in the driver's unit")
      ->type_name("N");
  command.add_option("--gain", options.gain, "lock the gain, in the driver's unit")->type_name("N");
  addOffsetOption(command, options.offsets);
  command
      .add_option("--max-skew-ms", options.max_skew_ms,
                  "maximum time difference between the images of a set [half a frame; for record: one frame]")
      ->type_name("MS");
  command.add_flag("--loop", options.loop, "restart sources that are files at their end");
}

}  // namespace airclay
