// SPDX-License-Identifier: MIT
// `airclay new`, `history`, `undo`, `redo`, `refine`, `set` and `turn`: edit a document without a window.
#include "engine/clay/document.h"

#include <CLI/CLI.hpp>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/cage_options.h"
#include "app/cli/clay_options.h"
#include "app/cli/command.h"
#include "app/cli/progress.h"
#include "engine/clay/refine.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

struct DocumentOptions : CommonOptions {
  std::string file;
  int count = 1;
};

struct NewOptions : DocumentOptions {
  std::string clay = "tube";
  CageOptions cage_options;
  ClayOptions clay_options;
};

struct SetOptions : DocumentOptions {
  std::string clay;
  CageOptions cage_options;
  ClayOptions clay_options;
};

struct TurnOptions : DocumentOptions {
  std::string axis, about;
  double degrees = 0;
};

/// Requires the extension .clay, so that a typing error cannot overwrite an OBJ with a document.
void checkEnding(const std::string& file) {
  if (!file.ends_with(".clay"))
    throw Error(file + ": a document's name ends in .clay; use " + file + ".clay", Fault::kUsage);
}

void runNew(const NewOptions& options) {
  checkEnding(options.file);
  const ClayState state{options.cage_options.load(options.clay), options.clay_options.subdivisionRule(),
                        options.clay_options.levels, options.clay_options.solveMethod()};
  // Checked before the file exists: a level that is too high is an error of this command, not of the
  // document.
  const Subdivision subdivision = subdivide(state.cage, state.levels, state.rule);
  Document::create(options.file, state);
  printLine(options, options.file + ": " + counted(state.cage.points.size(), "control point") + ", " +
                         counted(static_cast<std::size_t>(subdivision.matrix.rows()), "data point"));
}

std::string localTime(std::int64_t unix_time_s) {
  const std::time_t time = static_cast<std::time_t>(unix_time_s);
  std::tm parts{};
  char text[64];
  if (!localtime_r(&time, &parts) || std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts) == 0)
    return "unknown";  // year out of range
  return text;
}

void runHistory(const DocumentOptions& options) {
  const Document document = Document::open(options.file);
  const std::vector<HistoryEntry> history = document.history();
  if (options.json) {
    nlohmann::ordered_json entries = nlohmann::ordered_json::array();
    for (const HistoryEntry& entry : history)
      entries.push_back(
          {{"name", entry.name}, {"unix_time_s", entry.unix_time_s}, {"current", entry.is_current}});
    const ClayState& state = document.state();
    printJson({{"entries", entries},
               {"undo", document.undoCount()},
               {"redo", document.redoCount()},
               {"control_points", state.cage.points.size()},
               {"levels", state.levels},
               {"rule", state.rule == SubdivisionRule::kPrinted ? "printed" : "catmull-clark"},
               {"solve", state.solve->id}});
  }
  if (!options.printsMessages()) return;
  std::vector<std::vector<std::string>> rows = {{"edit", "what", "when", ""}};
  for (std::size_t i = 0; i < history.size(); ++i)
    rows.push_back({std::to_string(i), oneLine(history[i].name), localTime(history[i].unix_time_s),
                    history[i].is_current ? "<- now" : ""});
  printTable(rows);
}

void printPosition(const DocumentOptions& options, const Document& document, const std::string& done) {
  printLine(options, options.file + ": " + done + "; " + std::to_string(document.undoCount()) + " to undo, " +
                         std::to_string(document.redoCount()) + " to redo");
}

void runUndo(const DocumentOptions& options) {
  Document document = Document::open(options.file);
  const std::string name = oneLine(document.canUndo().value_or(""));
  document.undo(options.count);
  printPosition(options, document,
                options.count == 1 ? name + " undone" : std::to_string(options.count) + " edits undone");
}

void runRedo(const DocumentOptions& options) {
  Document document = Document::open(options.file);
  const std::string name = oneLine(document.canRedo().value_or(""));
  document.redo(options.count);
  printPosition(options, document,
                options.count == 1 ? name + " redone" : std::to_string(options.count) + " edits redone");
}

void runRefine(const DocumentOptions& options) {
  Document document = Document::open(options.file);
  const ClayState before = document.state();
  ClayState refined;
  try {
    const ProgressTask progress("refining", options.printsMessages());
    refined = refine(before);
  } catch (const Error& error) {
    throw Error(options.file + ": " + error.what());
  }
  document.commit("Refine", refined);
  printLine(options,
            options.file + ": " + counted(refined.cage.points.size(), "control point") + " at level " +
                std::to_string(refined.levels) + ", from " + std::to_string(before.cage.points.size()) +
                " at level " + std::to_string(before.levels) +
                (before.levels == 1 ? "; the surface is one level finer" : "; the surface is the same"));
}

void runSet(const SetOptions& options) {
  if (options.clay.empty()) options.cage_options.refuse("--clay names one");
  Document document = Document::open(options.file);
  ClayState state = document.state();
  if (!options.clay.empty()) {
    state.cage = options.cage_options.load(options.clay);
    state.workspace_from_clay.setIdentity();
  }
  options.clay_options.applyTo(state);
  if (sameClay(state, document.state()))
    throw Error("set " + options.file +
                    ": nothing to change; use --levels, --rule, --solve or --clay with another value",
                Fault::kUsage);
  const Subdivision subdivision =
      subdivide(state.cage, state.levels, state.rule);  // throws if the level is too high
  document.commit(!options.clay.empty() ? "Import " + std::filesystem::path(options.clay).filename().string()
                  : options.clay_options.levelsGiven() ? "Level " + std::to_string(state.levels)
                                                       : "Settings",
                  state);
  printLine(options, options.file + ": " + counted(state.cage.points.size(), "control point") + ", " +
                         counted(static_cast<std::size_t>(subdivision.matrix.rows()), "data point") +
                         " at level " + std::to_string(state.levels));
}

void runTurn(const TurnOptions& options) {
  Document document = Document::open(options.file);
  ClayState state = document.state();
  const Vec3 axis = Vec3::Unit(options.axis[0] - 'x');
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(options.degrees * M_PI / 180, axis));
  const Vec3 about = options.about.empty() ? Vec3::Zero() : parsePoint("--about", options.about);
  for (Vec3& point : state.cage.points) point = about + turn * (point - about);
  state.workspace_from_clay = (turn * state.workspace_from_clay).normalized();
  document.commit("Turn", state);
  printLine(options,
            options.file + ": rotated by " + fixed(options.degrees, 1) + " degrees about " + options.axis);
}

void addFile(CLI::App& command, DocumentOptions& options) {
  command.add_option("FILE", options.file, "document, FILE.clay")->type_name("")->required();
}

void addCount(CLI::App& command, DocumentOptions& options, const std::string& verb) {
  command.add_option("--count", options.count, "number of edits to " + verb + " [1]")
      ->check(CLI::Range(1, 1'000'000'000).description(""))
      ->type_name("N");
}

}  // namespace

void addNew(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("new", "create a document, which stores the clay and every edit");
  const auto options = std::make_shared<NewOptions>();
  addFile(*command, *options);
  command
      ->add_option(
          "--clay", options->clay,
          "a preset: tube (default), cube, ball, slab or vase; or a control cage (.obj, .ply, .stl, .gltf, "
          ".glb)")
      ->type_name("PRESET|FILE");
  addCageOptions(*command, options->cage_options);
  addSubdivisionOptions(*command, options->clay_options);
  addSolveOption(*command, options->clay_options);
  addCommonOptions(*command, *options, Uses::kNothing, false);
  command->footer("Example:\n  airclay new pot.clay --clay vase --levels 3");
  command->callback([options] { runNew(*options); });
}

void addHistory(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("history", "list the edits of a document");
  const auto options = std::make_shared<DocumentOptions>();
  addFile(*command, *options);
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer("Example:\n  airclay history pot.clay");
  command->callback([options] { runHistory(*options); });
}

void addUndo(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("undo", "undo edits of a document");
  const auto options = std::make_shared<DocumentOptions>();
  addFile(*command, *options);
  addCount(*command, *options, "undo");
  addCommonOptions(*command, *options, Uses::kNothing, false);
  command->footer("Example:\n  airclay undo pot.clay --count 3");
  command->callback([options] { runUndo(*options); });
}

void addRedo(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("redo", "redo edits of a document");
  const auto options = std::make_shared<DocumentOptions>();
  addFile(*command, *options);
  addCount(*command, *options, "redo");
  addCommonOptions(*command, *options, Uses::kNothing, false);
  command->footer("Example:\n  airclay redo pot.clay --count 3");
  command->callback([options] { runRedo(*options); });
}

void addRefine(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "refine", "refine a document's control cage without changing the surface, to add detail");
  const auto options = std::make_shared<DocumentOptions>();
  addFile(*command, *options);
  addCommonOptions(*command, *options, Uses::kNothing, false);
  command->footer(
      "The points of the first subdivision become the control cage, and the level drops by one. Level 1 "
      "stays 1,\nand the surface becomes one level finer.\n\nExample:\n  airclay refine pot.clay");
  command->callback([options] { runRefine(*options); });
}

void addSet(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "set", "change a document's level, rule or solve method, or replace its control cage");
  const auto options = std::make_shared<SetOptions>();
  addFile(*command, *options);
  command
      ->add_option(
          "--clay", options->clay,
          "a preset: tube, cube, ball, slab or vase; or a control cage (.obj, .ply, .stl, .gltf, .glb)")
      ->type_name("PRESET|FILE");
  addCageOptions(*command, options->cage_options);
  addSubdivisionOptions(*command, options->clay_options, WhenOmitted::kKeep);
  addSolveOption(*command, options->clay_options, WhenOmitted::kKeep);
  addCommonOptions(*command, *options, Uses::kNothing, false);
  command->footer(
      "Settings without an option do not change. The change is an edit that can be undone.\n\nExample:\n  "
      "airclay set pot.clay --levels 3 --solve touched");
  command->callback([options] { runSet(*options); });
}

void addTurn(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("turn", "rotate a document's clay about an axis");
  const auto options = std::make_shared<TurnOptions>();
  addFile(*command, *options);
  command->add_option("--axis", options->axis, "world axis: x, y or z")
      ->required()
      ->check(CLI::IsMember({"x", "y", "z"}).description(""))
      ->type_name("AXIS");
  command->add_option("--degrees", options->degrees, "angle in degrees, right-handed")
      ->required()
      ->check(CLI::Range(-360.0, 360.0).description(""))
      ->type_name("A");
  command
      ->add_option(
          "--about", options->about,
          "point on the axis in the world, metres; the studio uses the workspace's centre [the origin]")
      ->type_name("X,Y,Z");
  addCommonOptions(*command, *options, Uses::kNothing, false);
  command->footer("Example:\n  airclay turn pot.clay --axis z --degrees 90");
  command->callback([options] { runTurn(*options); });
}

}  // namespace airclay
