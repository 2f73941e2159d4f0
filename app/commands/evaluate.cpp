// SPDX-License-Identifier: MIT
// `airclay evaluate`: tracks takes with ground truth and reports the errors.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/cli/progress.h"
#include "app/session/fit_options.h"
#include "app/session/take_options.h"
#include "app/session/take_tracking.h"
#include "capture/takes/evaluation_plot.h"
#include "capture/takes/room_recording.h"
#include "capture/takes/room_set.h"
#include "capture/takes/truth.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

using nlohmann::ordered_json;

struct EvaluateOptions : CommonOptions {
  std::vector<std::string> takes;
  TakeInputOptions reading;
  FitOptions fit;
  std::string hand = "right", out = "out/evaluate";
  bool is_synthetic = false;
  std::vector<std::string> only;  ///< names of synthetic takes
  std::string keep;               ///< folder for them
};

/// The last part of the take's path; a number tells takes with equal names apart.
std::vector<std::string> namesOf(const std::vector<std::string>& takes) {
  std::vector<std::string> names;
  for (const std::string& take : takes) {
    std::filesystem::path path = std::filesystem::absolute(take).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    const std::string name = path.filename().string();
    std::string unique = name;
    for (int k = 2; std::ranges::find(names, unique) != names.end(); ++k)
      unique = name + "-" + std::to_string(k);
    names.push_back(unique);
  }
  return names;
}

/// What tracking found in a frame, next to the truth. `center_from_mass`: from the hand's centre of mass to
/// its centre, hand frame, metres.
EvaluatedFrame evaluatedFrame(const PlayedFrame& frame, const Pose& truth, const Vec3& center_from_mass) {
  EvaluatedFrame evaluated{frame.frame, frame.time_s, std::nullopt, false, truth, std::nullopt};
  if (const HandFit* fit = frame.result.trackedHand();
      fit && fit->pose.world_from_hand.matrix().allFinite()) {
    evaluated.estimate = fit->pose.world_from_hand;
    if (!fit->covariance.isZero()) {
      // a turn t moves the centre by t x offset
      const Vec3 offset = fit->scale * (fit->pose.world_from_hand.linear() * center_from_mass);
      Eigen::Matrix<double, 6, 6> moves = Eigen::Matrix<double, 6, 6>::Identity();
      moves.topRightCorner<3, 3>() << 0, offset.z(), -offset.y(), -offset.z(), 0, offset.x(), offset.y(),
          -offset.x(), 0;
      evaluated.covariance = moves * fit->covariance * moves.transpose();
    }
  }
  evaluated.is_uncertain = frame.result.state() == HandState::kUncertain;
  return evaluated;
}

/// Tracks a take; the frames that have ground truth, without those of the empty workspace.
EvaluatedTake trackWithTruth(Gpu& gpu, Recording& take, const Truth& truth, const TakeTracking& tracking) {
  EvaluatedTake frames;
  const Vec3 center_from_mass = handCenter(tracking.hand) - massProperties(tracking.hand.skin).centroid;
  trackTake(gpu, take, tracking, [&](const Pipeline&, const PlayedFrame& frame) {
    if (frame.background) return;
    if (const std::optional<Pose> pose = truth.at(frame.time_s, 1 / take.rateHz()))
      frames.push_back(evaluatedFrame(frame, *pose, center_from_mass));
  });
  return frames;
}

ordered_json orNull(const auto& value) {
  return value ? ordered_json(*value) : ordered_json();
}

ordered_json jsonOf(const std::string& name, const Evaluation& evaluation) {
  ordered_json object = {{"name", name},
                         {"frames", evaluation.frames},
                         {"tracked", evaluation.tracked},
                         {"uncertain", evaluation.uncertain},
                         {"lost", evaluation.lost},
                         {"wrong_tracked", evaluation.wrong_tracked}};
  for (const auto& [unit, errors] : {std::pair("mm", evaluation.mm), {"deg", evaluation.deg}})
    for (const auto& [figure, member] : {std::pair("_median", &ErrorDistribution::median),
                                         {"_p90", &ErrorDistribution::p90},
                                         {"_p99", &ErrorDistribution::p99},
                                         {"_worst", &ErrorDistribution::worst}})
      object[std::string(unit) + figure] = errors ? ordered_json((*errors).*member) : ordered_json();
  object["jitter_mm"] = orNull(evaluation.jitter_mm);
  object["jitter_deg"] = orNull(evaluation.jitter_deg);
  object["frames_to_find"] = orNull(evaluation.frames_to_find);
  for (const auto& [key, inside] :
       {std::pair("inside_68_percent", evaluation.inside_68), {"inside_95_percent", evaluation.inside_95}})
    object[key] = inside ? ordered_json(100 * *inside) : ordered_json();
  return object;
}

std::vector<std::string> rowOf(const std::string& name, const Evaluation& evaluation) {
  std::vector<std::string> row = {name};
  for (const int count : {evaluation.frames, evaluation.tracked, evaluation.uncertain, evaluation.lost,
                          evaluation.wrong_tracked})
    row.push_back(std::to_string(count));
  const auto add = [&](const std::optional<double>& value) { row.push_back(value ? fixed(*value, 2) : "-"); };
  for (const std::optional<ErrorDistribution>& errors : {evaluation.mm, evaluation.deg})
    for (const auto member : {&ErrorDistribution::median, &ErrorDistribution::p90, &ErrorDistribution::p99,
                              &ErrorDistribution::worst})
      add(errors ? std::optional((*errors).*member) : std::nullopt);
  add(evaluation.jitter_mm);
  add(evaluation.jitter_deg);
  row.push_back(evaluation.frames_to_find ? std::to_string(*evaluation.frames_to_find) : "-");
  for (const std::optional<double>& inside : {evaluation.inside_68, evaluation.inside_95})
    row.push_back(inside ? fixed(100 * *inside, 0) : "-");
  return row;
}

void printEvaluations(const std::vector<std::string>& names, const std::vector<Evaluation>& evaluations,
                      const std::optional<Evaluation>& total) {
  std::vector<std::vector<std::string>> table = {
      {"take", "frames", "tracked", "uncertain", "lost", "wrong", "mm: median", "90 %", "99 %", "worst",
       "deg: median", "90 %", "99 %", "worst", "jitter: mm", "deg", "to find", "in 68 %", "in 95 %"}};
  for (std::size_t i = 0; i < names.size(); ++i) table.push_back(rowOf(names[i], evaluations[i]));
  if (total) table.push_back(rowOf("total", *total));
  printTable(table);
}

/// What every take of a run is tracked with, and what it yields.
class EvaluationRun {
 public:
  EvaluationRun(const EvaluateOptions& options, const HandModel& hand)
      : options_(options), hand_(hand), center_in_hand_(handCenter(hand)), gpu_(options) {
    makeFolder(options.out);
  }

  /// Tracks a take and draws its plot. \throw Error if no frame has ground truth.
  void add(const std::string& name, Recording& take, const Truth& truth) {
    EvaluatedTake frames = trackWithTruth(gpu_, take, truth,
                                          {.hand = hand_,
                                           .pipeline = options_.fit.pipeline(options_.voxels),
                                           .label = name,
                                           .shows_progress = options_.printsMessages()});
    if (frames.empty())
      throw Error(name + "/truth.tum: no pose is within half a frame of any of the take's frames");
    names_.push_back(name);
    evaluations_.push_back(evaluate({&frames, 1}, center_in_hand_));
    drawEvaluation(std::filesystem::path(options_.out) / (name + ".png"), name, frames, center_in_hand_);
    takes_.push_back(std::move(frames));
  }
  void print() const {
    if (options_.json) {
      ordered_json objects = ordered_json::array();
      for (std::size_t i = 0; i < names_.size(); ++i) objects.push_back(jsonOf(names_[i], evaluations_[i]));
      printJson({{"takes", objects}});
    } else if (!options_.quiet) {
      printEvaluations(names_, evaluations_,
                       takes_.size() > 1 ? std::optional(evaluate(takes_, center_in_hand_)) : std::nullopt);
      printLine(options_, "error plots in " + options_.out);
    }
  }

 private:
  const EvaluateOptions& options_;
  const HandModel& hand_;
  Vec3 center_in_hand_;
  CommandGpu gpu_;
  std::vector<std::string> names_;
  std::vector<EvaluatedTake> takes_;
  std::vector<Evaluation> evaluations_;
};

/// The synthetic takes that the options select. \throw Error (Fault::kUsage) for a name that does not exist.
std::vector<RoomTake> selectedRooms(const EvaluateOptions& options) {
  std::vector<RoomTake> takes = standardRooms();
  if (options.only.empty()) return takes;
  std::string names;
  for (const RoomTake& take : takes) names += (names.empty() ? "" : ", ") + take.name;
  for (const std::string& name : options.only)
    if (std::ranges::find(takes, name, &RoomTake::name) == takes.end())
      throw Error("--only " + name + ": there is no such synthetic take; expected one of " + names,
                  Fault::kUsage);
  std::erase_if(takes, [&](const RoomTake& take) {
    return std::ranges::find(options.only, take.name) == options.only.end();
  });
  return takes;
}

void evaluateSynthetic(const EvaluateOptions& options) {
  const std::vector<RoomTake> takes = selectedRooms(options);
  const HandModel hand = loadHand(options.hand);
  EvaluationRun run(options, hand);
  for (const RoomTake& take : takes) {
    RoomRecording room(hand, take.options);
    if (options.keep.empty()) {
      run.add(take.name, room, room.fullTruth());
      continue;
    }
    const std::filesystem::path folder = std::filesystem::path(options.keep) / take.name;
    {
      Progress progress("writing " + folder.string(), room.frameCount(), options.printsMessages());
      writeTake(room, folder, [&] { progress.advance(); });
    }
    TakeInputOptions input = options.reading;
    input.folder = folder.string();
    Take written = input.open();
    run.add(take.name, written, readTruth(folder));
  }
  run.print();
}

void evaluateTakes(const EvaluateOptions& options) {
  std::vector<Truth> truths;
  for (const std::string& take : options.takes) truths.push_back(readTruth(take));
  const HandModel hand = loadHand(options.hand);
  EvaluationRun run(options, hand);
  const std::vector<std::string> names = namesOf(options.takes);
  for (std::size_t i = 0; i < names.size(); ++i) {
    TakeInputOptions input = options.reading;
    input.folder = options.takes[i];
    Take take = input.open();
    run.add(names[i], take, truths[i]);
  }
  run.print();
}

void runEvaluate(const EvaluateOptions& options) {
  checkVoxels(options.voxels);
  if (options.is_synthetic == !options.takes.empty())
    throw Error(options.is_synthetic
                    ? "--synthetic evaluates rendered takes; give either it or TAKE"
                    : "nothing to evaluate: give at least one TAKE, or --synthetic for the standard set",
                Fault::kUsage);
  if (!options.is_synthetic && (!options.only.empty() || !options.keep.empty()))
    throw Error("--only and --keep belong to --synthetic, which is missing", Fault::kUsage);
  options.is_synthetic ? evaluateSynthetic(options) : evaluateTakes(options);
}

/// The standard set, one take per line.
std::string listOfRooms() {
  std::string lines;
  for (const RoomTake& take : standardRooms()) lines += "  " + take.name + ": " + take.contents + "\n";
  return lines;
}

}  // namespace

void addEvaluate(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("evaluate", "track takes with ground truth and report the pose errors");
  const auto options = std::make_shared<EvaluateOptions>();
  command
      ->add_option("TAKE", options->takes,
                   "recordings with truth.tum, the true poses; truth_dense.tum, the same motion at a higher "
                   "rate, is interpolated at each frame's time")
      ->type_name("");
  command->add_flag(
      "--synthetic", options->is_synthetic,
      "render the standard set of takes: cameras, noise, hand scale, speed, forearm, person, skin, "
      "sleeve, shadows, light, blur, clocks");
  command->add_option("--only", options->only, "only these of the standard set")->type_name("NAME");
  command->add_option("--keep", options->keep, "write the rendered takes to DIR/NAME before they are tracked")
      ->type_name("DIR");
  addTakeReadingOptions(*command, options->reading);
  addHandOption(*command, options->hand);
  addFitOptions(*command, options->fit);
  command
      ->add_option("--out", options->out, "output folder for the error plots, TAKE.png each [out/evaluate]")
      ->type_name("DIR");
  addCommonOptions(*command, *options, Uses::kDeviceAndVoxels, true);
  command->footer(
      "Position errors refer to the middle between wrist and middle finger's knuckle. A frame is wrong if "
      "its "
      "pose is reported as tracked and is more than 10 mm off. Jitter is the RMS deviation from the mean "
      "while "
      "the true hand is still. \"to find\" counts the frames until the first pose within 10 mm. \"in 68 %\" "
      "and \"in 95 %\" are the percentages of errors inside the ellipsoids of the poses' covariance that "
      "should contain so many.\n\n"
      "--synthetic renders a hand over a desk, each take with its own path, colours and rotation of the "
      "world:\n" +
      listOfRooms() +
      "\nExamples:\n  airclay evaluate takes/desk takes/window --out errors --json\n"
      "  airclay evaluate --synthetic --only shadows --only everything --keep takes");
  command->callback([options] { runEvaluate(*options); });
}

}  // namespace airclay
