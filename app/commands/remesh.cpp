// SPDX-License-Identifier: MIT
// `airclay remesh`: a new control cage of even quads for the same surface.
#include "engine/clay/remesh.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/cage_options.h"
#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/cli/progress.h"
#include "engine/clay/document.h"
#include "engine/core/error.h"
#include "engine/mesh/mesh_export.h"
#include "engine/mesh/mesh_file.h"

namespace airclay {
namespace {

struct RemeshCommandOptions : CommonOptions {
  std::string input, as, out;
  CageOptions cage_options;
  double edge_mm = 0, thicken_mm = 0;
  int faces = 0;
};

/// The surface to remesh: of a cage, subdivided; of a mesh, itself.
TriangleMesh surfaceOf(const RemeshCommandOptions& options, RemeshOptions& remeshing) {
  if (options.input.ends_with(".clay")) {
    options.cage_options.refuse("a document is in metres");
    if (options.as == "mesh") throw Error("--as mesh: a document contains a cage", Fault::kUsage);
    const ClayState state = Document::open(options.input).state();
    remeshing.rule = state.rule;
    return fineSurface(state.cage, state.rule, remeshing);
  }
  const PolygonMesh read = options.cage_options.load(options.input);
  const bool all_triangles = std::all_of(read.faces.begin(), read.faces.end(),
                                         [](const std::vector<int>& face) { return face.size() == 3; });
  if (options.as == "mesh" || (options.as.empty() && all_triangles)) return {read.points, triangulated(read)};
  return fineSurface(read, remeshing.rule, remeshing);
}

void runRemesh(const RemeshCommandOptions& options) {
  checkWritable(options.out);
  RemeshOptions remeshing;
  remeshing.edge_m = options.edge_mm / 1000;
  remeshing.thicken_m = options.thicken_mm / 1000;
  if (options.faces > 0) remeshing.faces = options.faces;
  // Without a size, a wall is two edges thick.
  if (remeshing.thicken_m > 0 && options.faces == 0 && options.edge_mm == 0)
    remeshing.edge_m = remeshing.thicken_m / 2;
  const Remeshing result = [&] {
    const ProgressTask progress("remeshing", options.printsMessages());
    const TriangleMesh surface = surfaceOf(options, remeshing);
    try {
      return remesh(surface, remeshing);
    } catch (const Error& error) {
      throw Error(options.input + ": " + error.what(), error.fault());
    }
  }();
  writeObj(options.out, result.cage);
  if (result.hausdorff_m > result.edge_m / 4)
    printWarning(oneLine(options.input) + ": the new surface is up to " +
                 fixed(1000 * result.hausdorff_m, 2) +
                 " mm from the old one, more than a quarter of an edge; a smaller --edge-mm keeps sharp "
                 "edges, thin parts and gaps");
  if (result.lost_parts > 0)
    printWarning(oneLine(options.input) + ": " + counted(std::size_t(result.lost_parts), "separate part") +
                 " smaller than an edge left out");
  if (options.json)
    printJson({{"faces", result.cage.faces.size()},
               {"control_points", result.cage.points.size()},
               {"edge_mm", 1000 * result.edge_m},
               {"hausdorff_mm", 1000 * result.hausdorff_m},
               {"volume_cm3", 1e6 * result.volume_m3},
               {"volume_change_percent", result.volumeChangePercent()}});
  printLine(options, std::to_string(result.cage.faces.size()) + " quads of " +
                         fixed(1000 * result.edge_m, 2) + " mm in " + options.out + "; surface within " +
                         fixed(1000 * result.hausdorff_m, 3) + " mm, volume changed by " +
                         fixed(result.volumeChangePercent(), 3) + " %");
}

}  // namespace

void addRemesh(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand(
      "remesh", "make a new, even, closed cage of quads for a cage's or a triangle mesh's surface");
  const auto options = std::make_shared<RemeshCommandOptions>();
  command
      ->add_option("CAGE|MESH", options->input,
                   "surface: a control cage or a triangle mesh (.obj, .ply, .stl, .gltf, .glb); a document, "
                   "FILE.clay; or a preset: tube, cube, ball, slab or vase")
      ->type_name("")
      ->required();
  command->add_option("--out", options->out, "output file for the new control cage")
      ->type_name("CAGE.obj")
      ->required();
  CLI::Option* edge =
      command->add_option("--edge-mm", options->edge_mm, "length of the new cage's edges in millimetres")
          ->check(CLI::PositiveNumber.description(""))
          ->type_name("E");
  command
      ->add_option("--faces", options->faces,
                   "number of the new cage's faces, approximately [1600; with --thicken, edges of half the "
                   "thickness]")
      ->check(CLI::Range(kMinRemeshFaces, kMaxRemeshFaces).description(""))
      ->type_name("N")
      ->excludes(edge);
  command
      ->add_option("--thicken", options->thicken_mm,
                   "make an open surface a wall of this thickness in millimetres, at least two edges")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("MM");
  command
      ->add_option("--as", options->as,
                   "use the file as a control cage, which is subdivided, or as a mesh, whose faces are the "
                   "surface [mesh if all faces are triangles]")
      ->check(CLI::IsMember({"cage", "mesh"}).description(""))
      ->type_name("cage|mesh");
  options->cage_options.is_surface = true;
  addCageOptions(*command, options->cage_options);
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Overlapping lobes and parts become one solid; parts that do not overlap stay separate. The cage's "
      "surface at level\n2 lies within a quarter of an edge of the input, except where parts or gaps are "
      "thinner than an edge.\n\nExamples:\n  airclay remesh scan.stl --faces 1600 --out cage.obj\n"
      "  airclay remesh tube --thicken 10 --out cage.obj\n  airclay remesh pot.clay --edge-mm 5 --out "
      "cage.obj");
  command->callback([options] { runRemesh(*options); });
}

}  // namespace airclay
