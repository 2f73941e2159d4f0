// SPDX-License-Identifier: MIT
// `airclay evaluate`: tracks takes with ground truth and reports the errors.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/session/fit_options.h"
#include "app/session/take_options.h"
#include "app/session/take_tracking.h"
#include "capture/takes/evaluation_plot.h"
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

/// What tracking found in a frame, next to the truth.
EvaluatedFrame evaluatedFrame(const PlayedFrame& frame, const Pose& truth) {
  EvaluatedFrame evaluated{frame.frame, frame.time_s, std::nullopt, false, truth};
  if (const HandFit* fit = frame.result.trackedHand(); fit && fit->pose.world_from_hand.matrix().allFinite())
    evaluated.estimate = fit->pose.world_from_hand;
  evaluated.is_uncertain = frame.result.state() == HandState::kUncertain;
  return evaluated;
}

/// Tracks a take; the frames that have ground truth, without those of the empty workspace.
EvaluatedTake trackWithTruth(Gpu& gpu, Take& take, const Truth& truth, const TakeTracking& tracking) {
  EvaluatedTake frames;
  trackTake(gpu, take, tracking, [&](const PlayedFrame& frame) {
    if (frame.background) return;
    if (const std::optional<Pose> pose = truth.at(frame.time_s, 1 / take.rateHz()))
      frames.push_back(evaluatedFrame(frame, *pose));
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
  return row;
}

void printEvaluations(const std::vector<std::string>& names, const std::vector<Evaluation>& evaluations,
                      const std::optional<Evaluation>& total) {
  std::vector<std::vector<std::string>> table = {{"take", "frames", "tracked", "uncertain", "lost", "wrong",
                                                  "mm: median", "90 %", "99 %", "worst", "deg: median",
                                                  "90 %", "99 %", "worst", "jitter: mm", "deg", "to find"}};
  for (std::size_t i = 0; i < names.size(); ++i) table.push_back(rowOf(names[i], evaluations[i]));
  if (total) table.push_back(rowOf("total", *total));
  printTable(table);
}

void runEvaluate(const EvaluateOptions& options) {
  checkVoxels(options.voxels);
  std::vector<Truth> truths;
  for (const std::string& take : options.takes) truths.push_back(readTruth(take));
  const HandModel hand = loadHand(options.hand);
  const Vec3 center_in_hand = handCenter(hand);
  const std::filesystem::path out = options.out;
  makeFolder(out);
  CommandGpu gpu(options);
  const std::vector<std::string> names = namesOf(options.takes);
  std::vector<EvaluatedTake> takes;
  std::vector<Evaluation> evaluations;
  for (std::size_t i = 0; i < names.size(); ++i) {
    TakeInputOptions input = options.reading;
    input.folder = options.takes[i];
    Take take = input.open();
    takes.push_back(trackWithTruth(gpu, take, truths[i],
                                   {.hand = hand,
                                    .pipeline = options.fit.pipeline(options.voxels),
                                    .label = names[i],
                                    .shows_progress = options.printsMessages()}));
    if (takes[i].empty())
      throw Error(input.folder + "/truth.tum: no pose is within half a frame of any of the take's frames");
    evaluations.push_back(evaluate({&takes[i], 1}, center_in_hand));
    drawEvaluation(out / (names[i] + ".png"), names[i], takes[i], center_in_hand);
  }
  if (options.json) {
    ordered_json objects = ordered_json::array();
    for (std::size_t i = 0; i < names.size(); ++i) objects.push_back(jsonOf(names[i], evaluations[i]));
    printJson({{"takes", objects}});
  } else if (!options.quiet) {
    printEvaluations(names, evaluations,
                     takes.size() > 1 ? std::optional(evaluate(takes, center_in_hand)) : std::nullopt);
    printLine(options, "error plots in " + options.out);
  }
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
      ->type_name("")
      ->required();
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
      "the true hand is still. \"to find\" counts the frames until the first pose within 10 mm.\n\n"
      "Example:\n  airclay evaluate takes/desk takes/window --out errors --json");
  command->callback([options] { runEvaluate(*options); });
}

}  // namespace airclay
