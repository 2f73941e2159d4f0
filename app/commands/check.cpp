// SPDX-License-Identifier: MIT
// `airclay check`: what the other commands would read from a take, a rig or a cage, before any work starts.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/cage_options.h"
#include "app/cli/command.h"
#include "app/session/take_options.h"
#include "capture/images/video_index.h"
#include "capture/images/video_reader.h"
#include "capture/takes/rig_opencv.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

using nlohmann::ordered_json;

struct CheckInputOptions : CommonOptions {
  TakeInputOptions input;
  CageOptions cage;  ///< its --units is also the rig's
};

/// What a check finds, in the order of the file.
struct Findings {
  ordered_json facts;                                  ///< what would be read
  std::vector<std::vector<std::string>> table;         ///< the cameras, or the cage
  std::vector<std::string> repairs, errors, warnings;  ///< each in one line

  /// Runs one part of the check; its Error becomes an entry of the list, and the others still run.
  template <class Part>
  void collect(Part part) {
    try {
      part();
    } catch (const Error& error) {
      if (error.fault() == Fault::kUsage) throw;
      addError(error.what());
    }
  }
  void addError(const std::string& error) {
    if (std::find(errors.begin(), errors.end(), error) == errors.end()) errors.push_back(error);
  }
};

std::string sizeText(int width, int height) {
  return width > 0 ? std::to_string(width) + " x " + std::to_string(height) : "not written";
}

/// The rig's cameras and everything that is wrong with them.
Rig checkRigFile(const std::filesystem::path& file, RigUnits units, Findings& findings) {
  const ParsedRig reading = readAnyRig(file, units);
  for (const RigDiagnostic& fault : reading.errors)
    findings.addError(diagnosticMessage(fault, reading.where));
  findings.facts["rig"] = reading.where;
  return reading.rig;
}

/// The checks that need every camera's size.
void checkGeometry(const Rig& rig, const std::filesystem::path& file, Findings& findings) {
  for (const Camera& camera : rig.cameras)
    if (camera.width <= 0 || camera.height <= 0) return;
  for (const RigDiagnostic& fault : rigErrors(rig))
    findings.addError(diagnosticMessage(fault, file.string()));
  if (!isMeasurable(rig)) return;
  for (const RigDiagnostic& warning : rigWarnings(rig))
    findings.warnings.push_back(diagnosticMessage(warning, file.string()));
}

void checkRigAlone(const CheckInputOptions& options, Findings& findings) {
  const Rig rig = checkRigFile(options.input.folder, parseUnits(options.input.units), findings);
  checkGeometry(rig, options.input.folder, findings);
  findings.table.push_back({"camera", "size"});
  for (const Camera& camera : rig.cameras) {
    findings.table.push_back({camera.name, sizeText(camera.width, camera.height)});
    findings.facts["cameras"].push_back(
        {{"name", camera.name}, {"width", camera.width}, {"height", camera.height}});
  }
}

void checkFrames(const std::filesystem::path& folder, Camera& camera, Findings& findings) {
  ordered_json facts{{"name", camera.name}};
  std::vector<std::string> row{camera.name, "none", "", "", "", ""};
  findings.collect([&] {
    const std::unique_ptr<FrameSource> source = openFrames(folder, camera.name);
    if (!source) return;
    const ImageSize size = source->size();
    facts.update({{"width", size.width},
                  {"height", size.height},
                  {"frames", source->frameCount()},
                  {"rate_hz", source->rateHz()},
                  {"pixels", source->pixelFormat()}});
    if (!source->timesS().empty()) facts["missing_frames"] = missingFrames(source->timesS());
    row = {camera.name,
           sizeText(size.width, size.height),
           std::to_string(source->frameCount()),
           fixed(source->rateHz(), 2),
           source->pixelFormat(),
           source->timesS().empty() ? "" : std::to_string(missingFrames(source->timesS()))};
    if (camera.width <= 0 || camera.height <= 0) camera.width = size.width, camera.height = size.height;
  });
  findings.facts["cameras"].push_back(facts);
  findings.table.push_back(row);
}

void checkTake(const CheckInputOptions& options, Findings& findings) {
  const TakeOptions take_options = options.input.takeOptions();  // may reject the options
  const std::filesystem::path folder = options.input.folder;
  const std::optional<std::filesystem::path> file = rigFileIn(folder);
  if (file) {
    findings.table.push_back({"camera", "size", "frames", "Hz", "pixels", "missing"});
    findings.collect([&] {
      Rig rig = checkRigFile(*file, parseUnits(options.input.units), findings);
      for (Camera& camera : rig.cameras) checkFrames(folder, camera, findings);
      checkGeometry(rig, *file, findings);
    });
  }
  // The last say is that of the reader itself.
  findings.collect([&] {
    const Take take(folder, take_options);
    if (take.note()) findings.warnings.push_back(*take.note());
    findings.facts.update({{"frames", take.frameCount()},
                           {"rate_hz", take.rateHz()},
                           {"has_images", take.hasImages()},
                           {"has_silhouettes", take.hasSilhouettes()},
                           {"has_background", take.hasBackground()},
                           {"background_frames", take.backgroundFrames()},
                           {"has_timestamps", !take.cameraTimesOf(0).empty()},
                           {"has_truth", take.truth().has_value()}});
    if (take.hasImages() && take.backgroundFrames() >= take.frameCount())
      findings.addError(
          folder.string() + ": it has " + counted(static_cast<std::size_t>(take.frameCount()), "frame") +
          ", all of which --background takes for the empty workspace; expected more frames, or " +
          "background/NAME.png");
  });
}

void checkCageFile(const CheckInputOptions& options, Findings& findings) {
  const std::string& file = options.input.folder;
  const CageReading reading = inspectCage(file, options.cage.reading());
  const auto count = [&](auto matches) {
    return std::count_if(reading.cage.faces.begin(), reading.cage.faces.end(),
                         [&](const std::vector<int>& face) { return matches(face.size()); });
  };
  const auto triangles = count([](std::size_t corners) { return corners == 3; });
  const auto quads = count([](std::size_t corners) { return corners == 4; });
  const auto polygons = count([](std::size_t corners) { return corners > 4; });
  Eigen::AlignedBox3d box;
  for (const Vec3& point : reading.cage.points) box.extend(point);
  const Vec3 size_m = box.sizes();
  findings.facts.update({{"format", reading.format},
                         {"vertices", reading.cage.points.size()},
                         {"faces", reading.cage.faces.size()},
                         {"triangles", triangles},
                         {"quads", quads},
                         {"larger_polygons", polygons},
                         {"size_m", {size_m.x(), size_m.y(), size_m.z()}},
                         {"closed", reading.is_closed},
                         {"repairs", reading.repairs}});
  findings.table = {
      {"format", "vertices", "faces", "triangles", "quads", "larger", "size, mm", "surface"},
      {reading.format, std::to_string(reading.cage.points.size()), std::to_string(reading.cage.faces.size()),
       std::to_string(triangles), std::to_string(quads), std::to_string(polygons),
       fixed(1000 * size_m.x(), 1) + " x " + fixed(1000 * size_m.y(), 1) + " x " +
           fixed(1000 * size_m.z(), 1),
       reading.is_closed ? "closed" : "open"}};
  findings.repairs = reading.repairs;
  findings.warnings = reading.hints;
  for (const std::string& problem : reading.problems) findings.addError(file + ": " + problem);
}

/// Cages have units and axes that rigs have not.
void checkOptionsOfRig(const CheckInputOptions& options) {
  const std::string& units = options.cage.units;
  if (!units.empty() && units != "m" && units != "mm")
    throw Error("--units " + units + " applies to a cage's file; the unit of a rig is m or mm",
                Fault::kUsage);
  if (!options.cage.up.empty()) throw Error("--up applies to a cage's file", Fault::kUsage);
}

void runCheck(const CheckInputOptions& options, int& status) {
  Findings findings;
  const bool is_take = std::filesystem::is_directory(options.input.folder);
  const bool is_cage = !is_take && isCageFile(options.input.folder);
  if (!is_cage) checkOptionsOfRig(options);
  findings.facts = {{"input", options.input.folder}, {"kind", is_take ? "take" : is_cage ? "cage" : "rig"}};
  findings.collect([&] {
    if (is_take)
      checkTake(options, findings);
    else if (is_cage)
      checkCageFile(options, findings);
    else
      checkRigAlone(options, findings);
  });
  const bool is_usable = findings.errors.empty();
  if (options.json) {
    findings.facts.update(
        {{"usable", is_usable}, {"errors", findings.errors}, {"warnings", findings.warnings}});
    printJson(findings.facts);
  } else {
    if (!options.quiet && findings.table.size() > 1) printTable(findings.table);
    for (const std::string& repair : findings.repairs) printWarning("repair: " + oneLine(repair));
    for (const std::string& warning : findings.warnings) printWarning("warning: " + oneLine(warning));
    for (const std::string& error : findings.errors) printWarning(oneLine(error));
    if (is_usable) printLine(options, options.input.folder + ": usable");
  }
  if (!is_usable) status = static_cast<int>(Fault::kInput);
}

}  // namespace

void addCheck(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "check", "report what Airclay reads from a take, a rig or a cage, what it repairs and what is missing");
  const auto options = std::make_shared<CheckInputOptions>();
  command
      ->add_option("PATH", options->input.folder,
                   "take, rig file or control cage (.obj, .ply, .stl, .gltf, .glb)")
      ->type_name("")
      ->required();
  addTakeReadingOptions(*command, options->input);
  command->remove_option(command->get_option("--units"));
  addCageOptions(*command, options->cage);
  command->get_option("--units")->description(
      "unit of a cage's file: m, cm, mm or in [m; STL: mm]; or of a rig file that states none: m "
      "or mm");
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay check TAKE --json\n  airclay check rig.toml\n  airclay check cage.obj --units "
      "mm");
  command->callback([options, &status] {
    options->input.units = options->cage.units;
    runCheck(*options, status);
  });
}

}  // namespace airclay
