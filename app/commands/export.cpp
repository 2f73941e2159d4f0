// SPDX-License-Identifier: MIT
// `airclay export`: writes the cage or the surface for other programs, and reports whether it can be
// 3D-printed.
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/cage_options.h"
#include "app/cli/clay_options.h"
#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/cli/progress.h"
#include "engine/clay/document.h"
#include "engine/core/error.h"
#include "engine/mesh/mesh_export.h"

namespace airclay {
namespace {

struct ExportOptions : CommonOptions {
  std::string clay, out, what = "surface";
  CageOptions cage_options;
  ClayOptions clay_options;
};

/// The clay to export. A document's level and rule apply unless the options override them.
ClayState clayOf(const ExportOptions& options) {
  ClayState clay;
  if (options.clay.ends_with(".clay")) {
    options.cage_options.refuse("a document is in metres");
    clay = Document::open(options.clay).state();
  } else {
    clay.cage = options.cage_options.load(options.clay);
  }
  options.clay_options.applyTo(clay);
  return clay;
}

std::string describePrintability(const MeshExport& written) {
  if (!written.watertight()) return std::to_string(written.open_edges) + " open edges: cannot be 3D-printed";
  if (written.volume_m3 < 0) return "watertight, but inside out: the faces are clockwise";
  return "watertight, " + fixed(1e6 * written.volume_m3, 1) + " cm3";
}

std::string sizeOf(const MeshExport& written) {
  const Vec3 size_mm = 1000 * written.size_m;
  return fixed(size_mm.x(), 1) + " x " + fixed(size_mm.y(), 1) + " x " + fixed(size_mm.z(), 1) + " mm";
}

void runExport(const ExportOptions& options) {
  const bool cage_alone = options.what == "cage";
  if (cage_alone && options.clay_options.levelsGiven())
    throw Error("--levels subdivides the surface; omit it with --what cage", Fault::kUsage);
  meshFormatOf(options.out);
  checkWritable(options.out);
  const MeshExport written = [&] {
    const ProgressTask progress("exporting", options.printsMessages());
    const ClayState clay = clayOf(options);
    return exportMesh(options.out, meshAtLevel(clay.cage, cage_alone ? 0 : clay.levels, clay.rule));
  }();
  if (options.json)
    printJson({{"vertices", written.vertices},
               {"faces", written.faces},
               {"triangles", written.triangles},
               {"watertight", written.watertight()},
               {"open_edges", written.open_edges},
               {"volume_cm3", 1e6 * written.volume_m3}});
  printLine(options, std::to_string(written.faces) +
                         (written.faces == written.triangles ? " triangles, " : " faces, ") +
                         sizeOf(written) + ", in " + options.out + "; " + describePrintability(written));
}

}  // namespace

void addExport(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("export", "export clay as OBJ, PLY, STL or glTF binary");
  const auto options = std::make_shared<ExportOptions>();
  command
      ->add_option(
          "CLAY", options->clay,
          "clay to export: a document, FILE.clay; a control cage (.obj, .ply, .stl, .gltf, .glb); or a "
          "preset: tube, cube, ball, slab or vase")
      ->type_name("")
      ->required();
  command
      ->add_option("--out", options->out,
                   "output file; the extension selects the format: .obj or .ply (polygons, metres, z up), "
                   ".stl (triangles, millimetres, z up) or .glb (triangles, metres, y up)")
      ->type_name("FILE")
      ->required();
  command->add_option("--what", options->what, "export the surface (default) or the control cage")
      ->check(CLI::IsMember({"surface", "cage"}).description(""))
      ->type_name("surface|cage");
  addCageOptions(*command, options->cage_options);
  addSubdivisionOptions(*command, options->clay_options);
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay export ball --levels 4 --out ball.stl\n"
      "  airclay export cage.obj --out clay.glb\n  airclay export pot.clay --out pot.stl");
  command->callback([options] { runExport(*options); });
}

}  // namespace airclay
