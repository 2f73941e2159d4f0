// SPDX-License-Identifier: MIT
// `airclay cameras`: lists devices and their modes, opens named cameras, and shows how they run together.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/camera_options.h"
#include "app/cli/command.h"
#include "app/cli/progress.h"
#include "app/studio/preview_window.h"
#include "app/studio/window.h"
#include "capture/cameras/v4l2_devices.h"
#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

using Json = nlohmann::ordered_json;

struct CamerasOptions : CommonOptions {
  CameraOptions cameras;
  double watch_s = 0;  ///< 0: until Ctrl-C
  bool watches = false, headless = false;
};

std::string sizeText(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::string ratesText(const std::vector<double>& rates_hz) {
  std::string text;
  for (const double rate_hz : rates_hz) text += (text.empty() ? "" : ", ") + fixed(rate_hz, 0);
  return text.empty() ? "?" : text;
}

// -------------------------------------------------------------------------------------------- the devices

Json devicesJson(const std::vector<V4l2Device>& devices) {
  Json list = Json::array();
  for (const V4l2Device& device : devices) {
    Json modes = Json::array();
    for (const V4l2Mode& mode : device.modes)
      modes.push_back({{"format", mode.format},
                       {"width", mode.size.width},
                       {"height", mode.size.height},
                       {"rates_hz", mode.rates_hz}});
    list.push_back({{"device", device.path},
                    {"name", device.name},
                    {"driver", device.driver},
                    {"bus", device.bus},
                    {"modes", modes}});
  }
  return list;
}

void printDevices(const std::vector<V4l2Device>& devices) {
  if (devices.empty()) {
    std::puts(
        "no camera device found (nothing in /dev/video*); a video file, a folder of images, an rtsp:// or "
        "http:// address or a GStreamer pipeline also works as a camera: airclay cameras --camera "
        "left=left.mp4");
    return;
  }
  for (const V4l2Device& device : devices) {
    std::printf("%s: %s (%s, %s)\n", device.path.c_str(), oneLine(device.name).c_str(), device.driver.c_str(),
                device.bus.c_str());
    std::vector<std::vector<std::string>> rows = {{"  FORMAT", "SIZE", "HZ"}};
    for (const V4l2Mode& mode : device.modes)
      rows.push_back({"  " + mode.format, sizeText(mode.size), ratesText(mode.rates_hz)});
    printTable(rows);
  }
}

// -------------------------------------------------------------------------------------------- watching

/// Statistics of the received sets.
struct SetFigures {
  int sets = 0, incomplete = 0;
  std::vector<double> skews_s;

  void add(const LiveSet& set) {
    ++(set.complete ? sets : incomplete);
    skews_s.push_back(set.skew_s);
  }
  double usual() const { return median(skews_s); }
  double worst() const { return skews_s.empty() ? 0 : *std::max_element(skews_s.begin(), skews_s.end()); }
};

std::vector<std::vector<std::string>> tableOf(const std::vector<CameraStatus>& all) {
  std::vector<std::vector<std::string>> rows = {
      {"camera", "state", "Hz", "declared Hz", "drops", "skew ms", "size", "times from", "last error"}};
  for (const CameraStatus& one : all)
    rows.push_back({one.name, nameOf(one.state), fixed(one.measured_hz, 1), fixed(one.rate_hz, 1),
                    std::to_string(one.drops), fixed(1000 * one.skew_s, 1), sizeText(one.size),
                    nameOf(one.times), oneLine(one.fault)});
  return rows;
}

Json statusJson(const std::vector<CameraStatus>& all, const std::vector<NamedSource>& sources) {
  Json list = Json::array();
  for (std::size_t c = 0; c < all.size(); ++c)
    list.push_back({{"name", all[c].name},
                    {"source", sources[c].source.text},
                    {"width", all[c].size.width},
                    {"height", all[c].size.height},
                    {"rate_hz", all[c].rate_hz},
                    {"times", nameOf(all[c].times)},
                    {"state", nameOf(all[c].state)},
                    {"hz", all[c].measured_hz},
                    {"frames", all[c].frames},
                    {"drops", all[c].drops},
                    {"reconnects", all[c].reconnects},
                    {"skew_ms", 1000 * all[c].skew_s}});
  return list;
}

/// Prints the table; on a terminal, over the previous one.
class Table {
 public:
  void show(const std::vector<CameraStatus>& all, const std::string& line) {
    if (isatty(STDOUT_FILENO) && lines_ > 0) std::printf("\033[%zuA\033[J", lines_);
    const auto rows = tableOf(all);
    printTable(rows);
    std::puts(line.c_str());
    std::fflush(stdout);
    lines_ = rows.size() + 1;
  }

 private:
  std::size_t lines_ = 0;
};

std::string summary(const SetFigures& figures, const LiveCameras& cameras) {
  if (figures.sets + figures.incomplete > 0)
    return std::to_string(figures.sets) + " sets, " + std::to_string(figures.incomplete) +
           " incomplete, median skew " + fixed(1000 * figures.usual(), 1) + " ms (maximum " +
           fixed(1000 * figures.worst(), 1) + ", limit " + fixed(1000 * cameras.maxSkew(), 1) + ")";
  if (const std::optional<double> skew_s = cameras.excessSkew())
    return "no set: the images are " + fixed(1000 * *skew_s, 1) + " ms apart, the limit is " +
           fixed(1000 * cameras.maxSkew(), 1) + " ms; synchronize the cameras, or use --max-skew-ms " +
           fixed(1000 * *skew_s + 1, 0);
  return "no set yet";
}

Json watch(const CamerasOptions& options, const std::vector<NamedSource>& sources) {
  std::optional<CommandGpu> gpu;  // before the cameras run
  if (!options.headless && options.printsMessages() && Window::possible()) gpu.emplace(options);
  LiveCameras cameras(options.cameras.live(sources), options.cameras.liveOptions(LiveOptions::Sets::kNewest));
  SetFigures figures;
  Table table;
  const Clock::time_point start = Clock::now();
  double shown_s = 0;
  const auto passed = [&] { return secondsBetween(start, Clock::now()); };
  try {
    Progress signals("watching", 1, false);  // handles Ctrl-C
    const auto onProgress = [&](const LiveSet* set) {
      signals.reach(0);
      if (set) figures.add(*set);
      if (passed() >= shown_s + 1 && options.printsMessages()) {
        shown_s = passed();
        table.show(cameras.status(), summary(figures, cameras));
      }
      return !(options.watch_s > 0 && passed() >= options.watch_s) && !cameras.ended();
    };
    if (gpu) {
      watchCameras(*gpu, cameras, onProgress);
    } else {
      for (bool on = true; on;) {
        const std::optional<LiveSet> set = cameras.next(0.1);
        on = onProgress(set ? &*set : nullptr);
      }
    }
  } catch (const Interrupted&) {
  }
  const std::vector<CameraStatus> status = cameras.status();
  if (options.printsMessages()) table.show(status, summary(figures, cameras));
  return {{"cameras", statusJson(status, sources)},
          {"sets", figures.sets},
          {"incomplete", figures.incomplete},
          {"skew_ms", {{"median", 1000 * figures.usual()}, {"worst", 1000 * figures.worst()}}}};
}

// -------------------------------------------------------------------------------------------- the command

Json openEach(const CamerasOptions& options, const std::vector<NamedSource>& sources) {
  Json list = Json::array();
  std::vector<std::vector<std::string>> rows = {{"camera", "size", "Hz", "times from", "source"}};
  for (const NamedSource& named : sources) {
    const std::unique_ptr<CameraSource> source = openSource(named, options.cameras.sourceOptions());
    rows.push_back({named.name, sizeText(source->size()), fixed(source->rateHz(), 2), nameOf(source->times()),
                    oneLine(named.source.text)});
    list.push_back({{"name", named.name},
                    {"source", named.source.text},
                    {"width", source->size().width},
                    {"height", source->size().height},
                    {"rate_hz", source->rateHz()},
                    {"times", nameOf(source->times())}});
  }
  if (options.printsMessages()) printTable(rows);
  return {{"cameras", list}};
}

void runCameras(const CamerasOptions& options) {
  if (options.watch_s < 0)
    throw Error("--watch: expected a number of seconds above 0, or no value to watch until Ctrl-C",
                Fault::kUsage);
  if (!options.cameras.given()) {
    if (options.watches)
      throw Error("--watch needs cameras to watch; add, for example, --camera left=0 --camera right=2",
                  Fault::kUsage);
    const std::vector<V4l2Device> devices = listV4l2Devices();
    if (options.json) printJson({{"devices", devicesJson(devices)}});
    if (options.printsMessages()) printDevices(devices);
    return;
  }
  const std::vector<NamedSource> sources = options.cameras.sources();
  const Json figures = options.watches ? watch(options, sources) : openEach(options, sources);
  if (options.json) printJson(figures);
}

}  // namespace

void addCameras(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("cameras", "list camera devices and their modes; open and watch cameras");
  const auto options = std::make_shared<CamerasOptions>();
  addCameraOptions(*command, options->cameras);
  CLI::Option* watch = command->add_option(
      "--watch", options->watch_s,
      "show the images in a window, and print a status table once per second [until Ctrl-C]");
  watch->type_name("SECONDS")->expected(0, 1);
  command->add_flag("--headless", options->headless, "run without a window");
  addCommonOptions(*command, *options, Uses::kDevice, true);
  command->footer(
      "Examples:\n  airclay cameras\n"
      "  airclay cameras --camera left=0 --camera right=2 --mode 640x480@30 --format MJPG --watch\n"
      "  airclay cameras --camera top=rtsp://10.0.0.7:8554/top --watch 10 --json");
  command->callback([options, watch] {
    options->watches = watch->count() > 0;
    runCameras(*options);
  });
}

}  // namespace airclay
