// SPDX-License-Identifier: MIT
// `airclay board`: makes a calibration board to print, and checks whether the cameras can read it.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/board_options.h"
#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "capture/calibration/board_advice.h"
#include "engine/camera/rig.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

struct BoardCommandOptions : CommonOptions {
  std::string out, page = "a4", resolution, rig, units;
  double dpi = 300, fov_degrees = 60, distance_m = 0;
  BoardOptions board;
};

Page pageOf(const std::string& name) {
  for (const Page page : {Page::kA4, Page::kA3, Page::kLetter})
    if (name == nameOf(page)) return page;
  return Page::kFit;
}

/// The camera in which the board appears smallest.
struct Sight {
  BoardSight sight;
  std::string camera;  ///< "a 640 x 480 camera at 1.1 m"
};

Sight sightFromOptions(const BoardCommandOptions& options) {
  const auto [width, height] = parsePair("--resolution", options.resolution);
  if (!(options.distance_m > 0 && options.distance_m <= 1000))
    throw Error("--distance " + fixed(options.distance_m, 2) + ": expected a distance above 0 metres",
                Fault::kUsage);
  if (!(options.fov_degrees >= 1 && options.fov_degrees <= 170))
    throw Error("--fov " + fixed(options.fov_degrees, 1) + ": expected 1 to 170 degrees", Fault::kUsage);
  return {{focalOf(width, options.fov_degrees), options.distance_m},
          "a " + std::to_string(width) + " x " + std::to_string(height) + " camera with " +
              fixed(options.fov_degrees, 0) + " degrees field of view, " + fixed(options.distance_m, 2) +
              " m away"};
}

/// For a rig, with the board at the center of its workspace.
Sight sightOfRig(const BoardCommandOptions& options) {
  const RigUnits units = options.units == "m"    ? RigUnits::kMetres
                         : options.units == "mm" ? RigUnits::kMillimetres
                                                 : RigUnits::kAsWritten;
  const Rig rig = readRig(options.rig, units);
  std::optional<Sight> smallest;
  for (const Camera& camera : rig.cameras) {
    const double distance_m = (camera.camera_from_world * rig.workspace.center).norm();
    const BoardSight sight{(camera.lens.fx + camera.lens.fy) / 2, distance_m};
    if (smallest && sight.focal_px / distance_m >= smallest->sight.focal_px / smallest->sight.distance_m)
      continue;
    smallest = Sight{
        sight, "camera \"" + camera.name + "\", " + fixed(distance_m, 2) + " m from the workspace's centre"};
  }
  return *smallest;
}

std::optional<Sight> sightOf(const BoardCommandOptions& options) {
  const bool by_options = !options.resolution.empty() || options.distance_m != 0;
  if (!options.rig.empty() && by_options)
    throw Error("--rig sets the cameras' resolution and distance; omit --resolution and --distance",
                Fault::kUsage);
  if (!options.rig.empty()) return sightOfRig(options);
  if (!by_options) return std::nullopt;
  if (options.resolution.empty() || options.distance_m == 0)
    throw Error("--resolution and --distance go together, as in --resolution 640x480 --distance 1.1",
                Fault::kUsage);
  return sightFromOptions(options);
}

/// Whether the cameras can read the board.
struct Verdict {
  double cell_px = 0;
  bool readable = false;
  std::optional<BoardProposal> proposal;  ///< if it is not readable
};

Verdict judge(const Board& board, const Sight& sight, Page page) {
  Verdict verdict;
  verdict.cell_px = cellPixels(board, sight.sight);
  verdict.readable = verdict.cell_px >= minCellPixels(board);
  if (!verdict.readable) verdict.proposal = readableBoard(board, sight.sight, page);
  return verdict;
}

void printVerdict(const BoardCommandOptions& options, const Board& board, const Sight& sight,
                  const Verdict& verdict) {
  const std::string cell = board.chessboard ? "a square" : "a marker's cell";
  const std::string least = fixed(minCellPixels(board), 0);
  printLine(options, "For " + sight.camera + ", " + cell + " is " + fixed(verdict.cell_px, 1) +
                         " pixels wide: " + (verdict.readable ? "readable" : "too small") + " (at least " +
                         least + " are needed, more if the board is tilted).");
  if (verdict.readable) return;
  const double nearer_m = sight.sight.distance_m * verdict.cell_px / minCellPixels(board);
  if (!verdict.proposal) {
    printLine(options, "No board on A3 is readable at that distance. This one is readable within " +
                           fixed(nearer_m, 2) + " m.");
    return;
  }
  printLine(options, "This board is readable, with " + fixed(verdict.proposal->cell_px, 1) +
                         " pixels: --page " + nameOf(verdict.proposal->page) + " " +
                         optionsOf(verdict.proposal->board));
}

nlohmann::ordered_json jsonOf(const Board& board, Page page) {
  const auto mm = [](double length_m) { return std::round(1e6 * length_m) / 1e3; };
  nlohmann::ordered_json json{{"squares", {board.squares_x, board.squares_y}},
                              {"square_mm", mm(board.square_m)}};
  if (!board.chessboard) {
    json["marker_mm"] = mm(board.marker_m);
    json["dictionary"] = board.dictionary;
  }
  json["page"] = nameOf(page);
  return json;
}

void printVerdictJson(nlohmann::ordered_json json, const std::optional<Verdict>& verdict) {
  if (verdict) {
    json["cell_px"] = verdict->cell_px;
    json["readable"] = verdict->readable;
    if (verdict->proposal) {
      json["proposal"] = jsonOf(verdict->proposal->board, verdict->proposal->page);
      json["proposal"]["cell_px"] = verdict->proposal->cell_px;
    }
  }
  printJson(json);
}

void runBoard(const BoardCommandOptions& options) {
  const bool is_pdf = options.out.ends_with(".pdf");
  if (!is_pdf && !options.out.ends_with(".png"))
    throw Error("--out " + options.out + ": expected a name that ends in .pdf or .png", Fault::kUsage);
  const Board board = options.board.board();
  const Page page = pageOf(options.page);
  const std::optional<Sight> sight = sightOf(options);
  const BoardSheet sheet = layOut(board, page);
  checkWritable(options.out);
  if (is_pdf)
    writeBoardPdf(options.out, sheet);
  else
    writeBoardPng(options.out, sheet, options.dpi);

  const std::optional<Verdict> verdict = sight ? std::optional(judge(board, *sight, page)) : std::nullopt;
  if (options.json) printVerdictJson(jsonOf(board, page), verdict);
  printLine(options, options.out + ": a board of " + describe(board) + " on a page of " +
                         fixed(1000 * sheet.width_m, 0) + " x " + fixed(1000 * sheet.height_m, 0) + " mm.");
  printLine(options,
            "Print it at 100 % (\"actual size\"). The line below the board must be 100 mm long. If it is "
            "not, measure "
            "a square and pass its edge to calibrate as --check-square-mm.");
  printLine(options, "Glue it to a flat, stiff plate: a bent board makes the calibration inaccurate.");
  if (sight) printVerdict(options, board, *sight, *verdict);
}

void addSightOptions(CLI::App& command, BoardCommandOptions& options) {
  command
      .add_option("--resolution", options.resolution,
                  "image size of the cameras; with --distance, checks whether they can read the board")
      ->type_name("WxH");
  command.add_option("--distance", options.distance_m, "distance from the cameras to the board, metres")
      ->type_name("M");
  command.add_option("--fov", options.fov_degrees, "horizontal field of view of the cameras [60]")
      ->type_name("DEG");
  command
      .add_option("--rig", options.rig, "take image size, field of view and distance from a calibrated rig")
      ->type_name("RIG.toml");
  command.add_option("--units", options.units, "unit of a rig file that states none: m or mm")
      ->check(CLI::IsMember({"m", "mm"}).description(""))
      ->type_name("m|mm");
}

}  // namespace

void addBoard(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "board", "make a calibration board to print, and check whether the cameras can read it");
  const auto options = std::make_shared<BoardCommandOptions>();
  command->add_option("--out", options->out, "output file, .pdf or .png")->type_name("FILE")->required();
  command->add_option("--page", options->page, "paper size [a4]; fit: as large as the board needs")
      ->check(CLI::IsMember({"a4", "a3", "letter", "fit"}).description(""))
      ->type_name("a4|a3|letter|fit");
  command->add_option("--dpi", options->dpi, "resolution of a PNG in pixels per inch [300]")
      ->check(CLI::Range(20.0, 2400.0).description(""))
      ->type_name("N");
  addBoardOptions(*command, options->board);
  addSightOptions(*command, *options);
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay board --out board.pdf --resolution 640x480 --distance 1.1\n"
      "  airclay board --out board.pdf --page a3 --squares 7x5 --square-mm 55\n"
      "  airclay board --out board.png --chessboard --squares 10x7 --square-mm 25");
  command->callback([options] { runBoard(*options); });
}

}  // namespace airclay
