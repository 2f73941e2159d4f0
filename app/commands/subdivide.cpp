// SPDX-License-Identifier: MIT
// `airclay subdivide` and `airclay deform`: eq. (5) and eq. (6)-(8) in double precision on the CPU.
#include "engine/clay/subdivide.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/cage_options.h"
#include "app/cli/clay_options.h"
#include "app/cli/command.h"
#include "engine/clay/solve.h"
#include "engine/mesh/mesh_file.h"

namespace airclay {
namespace {

struct SubdivideOptions : CommonOptions {
  std::string cage, out;
  CageOptions cage_options;
  ClayOptions clay;
};

struct DeformOptions : SubdivideOptions {
  std::string moves, cage_out;
};

void runSubdivide(const SubdivideOptions& options) {
  const PolygonMesh cage = options.cage_options.load(options.cage);
  const Subdivision subdivision = subdivide(cage, options.clay.levels, options.clay.subdivisionRule());
  const PolygonMesh surface = surfaceMesh(subdivision, cage.points);
  writeObj(options.out, surface);
  if (options.json)
    printJson({{"control_points", cage.points.size()}, {"data_points", surface.points.size()}});
  printLine(options, std::to_string(cage.points.size()) + " control points, " +
                         std::to_string(surface.points.size()) + " data points in " + options.out);
}

void runDeform(const DeformOptions& options) {
  PolygonMesh cage = options.cage_options.load(options.cage);
  const Subdivision subdivision = subdivide(cage, options.clay.levels, options.clay.subdivisionRule());
  const std::vector<Move> moves = readMoves(options.moves, static_cast<int>(subdivision.matrix.rows()));
  cage.points = solveControlPoints(subdivision.matrix, cage.points, moves, options.clay.solveMethod());
  const PolygonMesh surface = surfaceMesh(subdivision, cage.points);
  double farthest_m = 0;
  for (const Move& move : moves)
    farthest_m =
        std::max(farthest_m, (surface.points[static_cast<std::size_t>(move.index)] - move.target).norm());
  writeObj(options.cage_out, cage);
  writeObj(options.out, surface);
  if (options.json)
    printJson({{"moves", moves.size()},
               {"control_points", cage.points.size()},
               {"data_points", surface.points.size()},
               {"farthest_from_target_m", farthest_m}});
  printLine(options, std::to_string(moves.size()) + " moved data points; largest distance from the target " +
                         fixed(1000 * farthest_m, 3) + " mm; control points in " + options.cage_out +
                         ", surface in " + options.out);
}

void addCage(CLI::App& command, SubdivideOptions& options) {
  command
      .add_option(
          "CAGE", options.cage,
          "control cage: a file (.obj, .ply, .stl, .gltf, .glb), or a preset: tube, cube, ball, slab or "
          "vase")
      ->type_name("")
      ->required();
  command.add_option("--out", options.out, "output file for the surface")
      ->type_name("SURFACE.obj")
      ->required();
  addCageOptions(command, options.cage_options);
  addSubdivisionOptions(command, options.clay);
}

}  // namespace

bool ClayOptions::levelsGiven() const {
  return levels_option && levels_option->count() > 0;
}

void ClayOptions::applyTo(ClayState& state) const {
  if (levelsGiven()) state.levels = levels;
  if (rule_option && rule_option->count() > 0) state.rule = subdivisionRule();
  if (solve_option && solve_option->count() > 0) state.solve = solveMethod();
}

void addSubdivisionOptions(CLI::App& command, ClayOptions& options, WhenOmitted otherwise) {
  const bool marked = otherwise == WhenOmitted::kDefault;
  options.levels_option =
      command
          .add_option("--levels", options.levels,
                      std::string("number of subdivisions of the cage") + (marked ? " [2]" : ""))
          ->type_name("N");
  options.rule_option =
      command
          .add_option("--rule", options.rule,
                      std::string("rule for vertex points: catmull-clark") + (marked ? " (default)" : "") +
                          ", or printed: eq. (4) exactly as the paper prints it")
          ->check(CLI::IsMember({"catmull-clark", "printed"}).description(""))
          ->type_name("RULE");
}

void addSolveOption(CLI::App& command, ClayOptions& options, WhenOmitted otherwise) {
  std::vector<std::string> ids;
  std::string help = "solve method:";
  for (const SolveMethod* method : solveMethods()) {
    const bool is_default = ids.empty() && otherwise == WhenOmitted::kDefault;
    help += (ids.empty() ? " " : ". ") + std::string(method->id) + (is_default ? " (default) " : " ") +
            method->description;
    ids.push_back(method->id);
  }
  options.solve_option = command.add_option("--solve", options.solve, help)
                             ->check(CLI::IsMember(ids).description(""))
                             ->type_name("METHOD");
}

void addSubdivide(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("subdivide", "subdivide a control cage into a surface, eq. (5)");
  const auto options = std::make_shared<SubdivideOptions>();
  addCage(*command, *options);
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay subdivide tube --out surface.obj\n"
      "  airclay subdivide cage.obj --levels 3 --rule printed --out surface.obj");
  command->callback([options] { runSubdivide(*options); });
}

void addDeform(CLI::App& program, int&) {
  CLI::App* command =
      program.add_subcommand("deform", "move surface points and solve for the control cage, eq. (6)-(8)");
  const auto options = std::make_shared<DeformOptions>();
  addCage(*command, *options);
  addSolveOption(*command, options->clay);
  command
      ->add_option("--moves", options->moves,
                   "CSV with header index,x,y,z: a data point (0-based, in the order that `airclay "
                   "subdivide` writes) and its target position, metres")
      ->type_name("MOVES.csv")
      ->required();
  command->add_option("--cage-out", options->cage_out, "output file for the new control cage")
      ->type_name("CAGE.obj")
      ->required();
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer("Example:\n  airclay deform tube --moves moves.csv --out surface.obj --cage-out cage.obj");
  command->callback([options] { runDeform(*options); });
}

}  // namespace airclay
