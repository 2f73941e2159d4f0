// SPDX-License-Identifier: MIT
// `airclay record`: records a take from live cameras, with the capture times of every set, losslessly.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/camera_options.h"
#include "app/cli/command.h"
#include "app/cli/progress.h"
#include "capture/takes/take_writer.h"
#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

using Json = nlohmann::ordered_json;

// After this time without a complete set, the recording ends.
constexpr double kAwayS = 5;
constexpr double kWaitS = 0.1;

struct RecordOptions : CommonOptions {
  CameraOptions cameras;
  std::string rig, out;
  double seconds = 0;  ///< 0: until Ctrl-C, or the end of files
  int background = 0;  ///< sets
  double background_s = 0;
};

/// A rig with only names and image sizes, for a recording to calibrate from.
Rig namesAndSizes(const std::vector<CameraStatus>& cameras) {
  Rig rig;
  for (const CameraStatus& one : cameras) {
    Camera camera;
    camera.name = one.name;
    camera.width = one.size.width;
    camera.height = one.size.height;
    rig.cameras.push_back(camera);
  }
  return rig;
}

/// Warns once when a camera freezes or is lost, and when it is back.
class Watcher {
 public:
  void look(const std::vector<CameraStatus>& all) {
    bad_.resize(all.size(), false);
    for (std::size_t c = 0; c < all.size(); ++c) {
      const CameraState state = all[c].state;
      const bool bad =
          state == CameraState::kFrozen || state == CameraState::kLost || state == CameraState::kReconnecting;
      if (bad && !bad_[c])
        printWarning(
            (all[c].fault.empty() ? "camera \"" + all[c].name + "\" is " + nameOf(state) : all[c].fault) +
            "; recording pauses until it is back");
      if (!bad && bad_[c]) printWarning("camera \"" + all[c].name + "\" is back");
      bad_[c] = bad;
    }
  }

 private:
  std::vector<bool> bad_;
};

/// One recording in progress.
class Recorder {
 public:
  Recorder(const RecordOptions& options, LiveCameras& cameras, const Rig& rig)
      : options_(options),
        cameras_(cameras),
        writer_(options.out, rig, {.rate_hz = cameras.slowestRateHz(), .writes_rig = !options.rig.empty()}) {}

  void takeBackground(int sets);
  void run();
  /// Closes all files. \throw Error if writing failed
  void finish() { writer_.finish(); }

  Json figures() const;
  std::string summary() const;
  std::string whyItEnded() const { return why_; }

 private:
  std::optional<LiveSet> nextComplete();
  void write(LiveSet set);
  double skewMs(bool worst) const;

  const RecordOptions& options_;
  LiveCameras& cameras_;
  TakeWriter writer_;
  Watcher watcher_;
  std::string why_;  ///< why the recording ended early; empty: it did not
  Clock::time_point last_complete_ = Clock::now();
  std::vector<std::uint64_t> drops_before_;
  std::vector<std::uint64_t> missed_;  ///< per camera: sets without its image
  int incomplete_ = 0, background_sets_ = 0, sets_ = 0;
  double first_s_ = 0, last_s_ = 0;  ///< of the sets' times
  std::vector<double> skews_s_;
};

/// The next complete set; nullopt if there is none yet or any more. Sets `why_` if none comes for kAwayS.
std::optional<LiveSet> Recorder::nextComplete() {
  std::optional<LiveSet> set = cameras_.next(kWaitS);
  const std::vector<CameraStatus> status = cameras_.status();
  watcher_.look(status);
  if (set && set->complete) {
    last_complete_ = Clock::now();
    return set;
  }
  if (set && sets_ > 0) {
    ++incomplete_;
    missed_.resize(status.size());
    for (std::size_t c = 0; c < status.size(); ++c) missed_[c] += set->images[c].bgr.empty();
  }
  if (secondsBetween(last_complete_, Clock::now()) < kAwayS) return std::nullopt;
  why_ = "no complete set for " + fixed(kAwayS, 0) + " s";
  for (const CameraStatus& one : status)
    if (one.state != CameraState::kLive && one.state != CameraState::kLate)
      why_ = "camera \"" + one.name + "\" has been " + nameOf(one.state) + " for " + fixed(kAwayS, 0) + " s";
  if (const std::optional<double> skew_s = cameras_.excessSkew())
    why_ += ": the images are " + fixed(1000 * *skew_s, 1) + " ms apart, the limit is " +
            fixed(1000 * cameras_.maxSkew(), 1) + " ms (--max-skew-ms)";
  return std::nullopt;
}

/// Averages the first sets, which reduces noise.
void Recorder::takeBackground(int sets) {
  std::vector<std::vector<unsigned>> sums;
  Progress progress("background", sets, options_.printsMessages());
  while (background_sets_ < sets && why_.empty() && !cameras_.ended()) {
    progress.reach(double(background_sets_) / sets);
    const std::optional<LiveSet> set = nextComplete();
    if (!set) continue;
    sums.resize(set->images.size());
    for (std::size_t c = 0; c < sums.size(); ++c) {
      const std::vector<std::uint8_t>& bgr = set->images[c].bgr;
      sums[c].resize(bgr.size());
      for (std::size_t i = 0; i < bgr.size(); ++i) sums[c][i] += bgr[i];
    }
    ++background_sets_;
  }
  if (background_sets_ == 0) return;
  const auto count = static_cast<unsigned>(background_sets_);
  std::vector<std::vector<std::uint8_t>> means(sums.size());
  for (std::size_t c = 0; c < sums.size(); ++c)
    for (const unsigned sum : sums[c])
      means[c].push_back(static_cast<std::uint8_t>((sum + count / 2) / count));
  writer_.writeBackground(means);
}

void Recorder::write(LiveSet set) {
  const std::vector<double>& times_s = set.camera_times_s;
  if (sets_ == 0) {
    // The take's clock starts at its first set.
    first_s_ = *std::min_element(times_s.begin(), times_s.end());
    for (const CameraStatus& one : cameras_.status()) drops_before_.push_back(one.drops);
  }
  RecordedSet taken;
  for (const double time_s : times_s) taken.camera_times_s.push_back(time_s - first_s_);
  for (LiveImage& image : set.images) taken.bytes.push_back(std::move(image.bgr));
  last_s_ = set.time_s;
  skews_s_.push_back(set.skew_s);
  ++sets_;
  writer_.write(std::move(taken));
}

void Recorder::run() {
  const Clock::time_point start = Clock::now();
  const auto passed = [&] { return secondsBetween(start, Clock::now()); };
  Progress progress("recording", static_cast<int>(std::ceil(options_.seconds)),
                    options_.printsMessages() && options_.seconds > 0);
  while (why_.empty() && !cameras_.ended() && writer_.status().fault.empty()) {
    progress.reach(options_.seconds > 0 ? std::min(1.0, passed() / options_.seconds) : 0);
    if (options_.seconds > 0 && sets_ > 0 && last_s_ - first_s_ >= options_.seconds) return;
    if (std::optional<LiveSet> set = nextComplete()) write(std::move(*set));
  }
}

double Recorder::skewMs(bool worst) const {
  if (skews_s_.empty()) return 0;
  return 1000 * (worst ? *std::max_element(skews_s_.begin(), skews_s_.end()) : median(skews_s_));
}

Json Recorder::figures() const {
  const std::vector<CameraStatus> status = cameras_.status();
  Json cameras = Json::array();
  for (std::size_t c = 0; c < status.size(); ++c)
    cameras.push_back({{"name", status[c].name},
                       {"times", nameOf(status[c].times)},
                       {"hz", status[c].measured_hz},
                       {"drops", drops_before_.empty() ? 0 : status[c].drops - drops_before_[c]},
                       {"missed", missed_.empty() ? 0 : missed_[c]},
                       {"reconnects", status[c].reconnects}});
  const double seconds = last_s_ - first_s_;
  const TakeWriter::Status written = writer_.status();
  return {{"sets", written.sets},
          {"incomplete", incomplete_},
          {"background_sets", background_sets_},
          {"seconds", sets_ > 0 ? seconds : 0},
          {"hz", sets_ > 1 && seconds > 0 ? (sets_ - 1) / seconds : 0},
          {"skew_ms", {{"median", skewMs(false)}, {"worst", skewMs(true)}}},
          {"waited_s", written.waited_s},
          {"cameras", cameras}};
}

std::string Recorder::summary() const {
  const Json all = figures();
  std::string text = std::to_string(all["sets"].get<int>()) + " sets, " + fixed(all["hz"], 2) +
                     " Hz, median skew " + fixed(skewMs(false), 1) + " ms (maximum " +
                     fixed(skewMs(true), 1) + "), in " + options_.out;
  if (background_sets_ > 0) text += "; background of " + std::to_string(background_sets_) + " sets";
  std::string lost;
  for (const Json& camera : all["cameras"])
    if (const auto drops = camera["drops"].get<std::uint64_t>() + camera["missed"].get<std::uint64_t>())
      lost += (lost.empty() ? "" : ", ") + camera["name"].get<std::string>() + " " + std::to_string(drops);
  text += lost.empty() ? "; no frames dropped" : "; frames dropped: " + lost;
  return text;
}

void checkOptions(const RecordOptions& options) {
  if (!options.cameras.given())
    throw Error("no cameras given; add --camera NAME=SOURCE once per camera", Fault::kUsage);
  if (options.background > 0 && options.background_s > 0)
    throw Error("--background and --background-seconds exclude each other; use one of them", Fault::kUsage);
  if (!(options.seconds >= 0 && options.seconds <= 86400 && options.background_s >= 0 &&
        options.background_s <= 60 && options.background >= 0 && options.background <= 10000))
    throw Error("--seconds must be 0 to 86400, --background 0 to 10000 sets, --background-seconds 0 to 60",
                Fault::kUsage);
}

void runRecord(const RecordOptions& options) {
  checkOptions(options);
  std::vector<NamedSource> sources = options.cameras.sources();
  std::optional<Rig> rig;
  if (!options.rig.empty()) {
    rig = readRig(options.rig);
    sources = inOrderOf(*rig, sources);
  }
  LiveCameras cameras(options.cameras.live(sources), options.cameras.liveOptions(LiveOptions::Sets::kEvery));
  if (rig) checkSizes(*rig, cameras);
  Recorder recorder(options, cameras, rig ? *rig : namesAndSizes(cameras.status()));
  const int background = options.background > 0
                             ? options.background
                             : static_cast<int>(std::lround(options.background_s * cameras.slowestRateHz()));
  try {
    if (background > 0) {
      printLine(options, "recording the background: " + std::to_string(background) +
                             " sets; keep out of the workspace");
      recorder.takeBackground(background);
    }
    if (options.seconds == 0) printLine(options, "recording; press Ctrl-C to stop");
    recorder.run();
  } catch (const Interrupted&) {
    // Ctrl-C ends a recording without --seconds
  }
  std::string fault;
  try {
    recorder.finish();
  } catch (const Error& error) {
    fault = error.what();
  }
  if (options.json) printJson(recorder.figures());
  printLine(options, recorder.summary());
  if (!fault.empty()) throw Error(fault);
  const int sets = recorder.figures()["sets"];
  if (!recorder.whyItEnded().empty())
    throw Error(options.out + ": " + recorder.whyItEnded() + ": the recording ends after " +
                std::to_string(sets) + " sets, which are readable; check the camera and its connection");
  if (sets == 0)
    throw Error(options.out +
                ": no set was recorded; expected running cameras, or files longer than the background");
}

}  // namespace

void addRecord(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("record", "record a take from live cameras, with a timestamp per image");
  const auto options = std::make_shared<RecordOptions>();
  command
      ->add_option("--rig", options->rig,
                   "rig with the names that --camera uses; omit it to record a board for calibration")
      ->type_name("RIG.toml");
  addCameraOptions(*command, options->cameras);
  command->add_option("--out", options->out, "new folder for the take")->type_name("TAKE")->required();
  command->add_option("--seconds", options->seconds, "duration [until Ctrl-C]")->type_name("S");
  command
      ->add_option(
          "--background", options->background,
          "average the first N sets of images into background/NAME.png, instead of recording them [none: "
          "the take starts with the empty workspace]")
      ->type_name("N");
  command
      ->add_option("--background-seconds", options->background_s,
                   "like --background, with the duration in seconds")
      ->type_name("S");
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay record --rig rig.toml --camera left=0 --camera right=2 --background-seconds 2 "
      "--seconds 30 --out monday\n"
      "  airclay record --camera left=0 --camera right=2 --out board");
  command->callback([options] { runRecord(*options); });
}

}  // namespace airclay
