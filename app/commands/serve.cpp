// SPDX-License-Identifier: MIT
// `airclay serve`: streams this machine's cameras by RTSP to Airclay on another machine.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/cli/camera_options.h"
#include "app/cli/command.h"
#include "app/cli/progress.h"
#include "capture/cameras/stream_server.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

using Json = nlohmann::ordered_json;

constexpr auto kLookAgain = std::chrono::milliseconds(50);

struct ServeOptions : CommonOptions {
  CameraOptions cameras;
  std::string address = "127.0.0.1";
  int port = 8554;
  double seconds = 0;  ///< 0: until Ctrl-C, or the end of files
};

/// Warns once when a camera freezes, is lost or ends, and when it is back.
class Watcher {
 public:
  void look(const std::vector<StreamStatus>& all) {
    said_.resize(all.size(), CameraState::kLive);
    for (std::size_t c = 0; c < all.size(); ++c) {
      const CameraStatus& camera = all[c].camera;
      const CameraState now = whatMatters(camera.state);
      if (now == said_[c]) continue;
      said_[c] = now;
      std::string line = "camera \"" + camera.name + "\" is ";
      if (now == CameraState::kLive)
        line += "back";
      else if (now == CameraState::kEnded)
        line += "at its end; --loop restarts it";
      else if (now == CameraState::kLost && !camera.fault.empty())
        line = camera.fault + "; reopening it once per second; the other cameras continue";
      else
        line += std::string(nameOf(now)) + "; the other cameras continue";
      printWarning(line);
    }
  }

 private:
  static CameraState whatMatters(CameraState state) {
    if (state == CameraState::kLate) return CameraState::kLive;
    return state == CameraState::kReconnecting ? CameraState::kLost : state;
  }
  std::vector<CameraState> said_;
};

void printAddresses(const ServeOptions& options, const StreamServer& server) {
  for (const StreamStatus& stream : server.status())
    printLine(options, stream.address + "  " + std::to_string(stream.camera.size.width) + "x" +
                           std::to_string(stream.camera.size.height) + " at " +
                           fixed(stream.camera.rate_hz, 2) + " Hz");
  if (options.address == "0.0.0.0" || options.address == "::")
    printLine(options, "replace this address by this machine's name or address: " + options.address);
  if (options.seconds == 0) printLine(options, "press Ctrl-C to stop");
  std::fflush(stdout);  // scripts wait for these lines
  if (!options.address.starts_with("127.") && options.address != "::1")
    printWarning("anyone who reaches port " + std::to_string(server.port()) +
                 " of this machine can watch its cameras; "
                 "there is no password");
}

/// \throw Interrupted
void run(const ServeOptions& options, const StreamServer& server, Progress& progress) {
  Watcher watcher;
  const Clock::time_point start = Clock::now();
  while (!server.ended() && (options.seconds == 0 || secondsBetween(start, Clock::now()) < options.seconds)) {
    progress.reach(0);
    std::this_thread::sleep_for(kLookAgain);
    watcher.look(server.status());
  }
}

Json figures(const std::vector<StreamStatus>& all) {
  Json cameras = Json::array();
  for (const StreamStatus& one : all)
    cameras.push_back({{"name", one.camera.name},
                       {"address", one.address},
                       {"width", one.camera.size.width},
                       {"height", one.camera.size.height},
                       {"frames", one.camera.frames},
                       {"streamed", one.streamed},
                       {"drops", one.camera.drops},
                       {"reconnects", one.camera.reconnects}});
  return {{"cameras", cameras}};
}

void runServe(const ServeOptions& options) {
  if (!options.cameras.given())
    throw Error("no cameras given; add --camera NAME=SOURCE once per camera", Fault::kUsage);
  if (!(options.seconds >= 0)) throw Error("--seconds must be above 0", Fault::kUsage);
  const std::vector<NamedSource> sources = options.cameras.sources();
  Progress progress("serving", 1, false);
  const StreamServer server(sources, {options.address, options.port, options.cameras.sourceOptions()});
  printAddresses(options, server);
  try {
    run(options, server, progress);
  } catch (const Interrupted&) {
    // Ctrl-C ends it without --seconds
  }
  const std::vector<StreamStatus> last = server.status();
  if (options.json) printJson(figures(last));
  std::string line;
  for (const StreamStatus& one : last)
    line +=
        (line.empty() ? "images streamed: " : ", ") + one.camera.name + " " + std::to_string(one.streamed);
  printLine(options, line);
}

}  // namespace

void addServe(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("serve", "stream this machine's cameras to Airclay on another machine");
  const auto options = std::make_shared<ServeOptions>();
  addCameraOptions(*command, options->cameras);
  for (const char* of_sets : {"--offset", "--max-skew-ms"})
    command->remove_option(command->get_option(of_sets));
  command
      ->add_option("--address", options->address,
                   "address to listen on [127.0.0.1: only this machine can watch; 0.0.0.0: every machine "
                   "that reaches this one can watch]")
      ->type_name("ADDRESS");
  command->add_option("--port", options->port, "port to listen on [8554]; 0 picks a free port")
      ->type_name("N");
  command->add_option("--seconds", options->seconds, "duration [until Ctrl-C]")->type_name("S");
  addDeprecatedName(*command, "--for", "--seconds");
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay serve --camera left=0 --camera right=2 --mode 640x480@30 --address 0.0.0.0\n"
      "On the other machine:\n  airclay cameras --camera left=rtsp://10.0.0.7:8554/left --watch");
  command->callback([options] { runServe(*options); });
}

}  // namespace airclay
