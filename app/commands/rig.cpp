// SPDX-License-Identifier: MIT
// `airclay rig convert` and `airclay rig check`: convert a rig from and to other programs' formats, and
// report its problems.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/cli/command.h"
#include "app/cli/output_paths.h"
#include "app/cli/progress.h"
#include "app/session/take_options.h"
#include "capture/takes/player.h"
#include "capture/takes/rig_opencv.h"
#include "capture/takes/take_inspection.h"
#include "engine/camera/rig_formats.h"
#include "engine/core/error.h"
#include "engine/mesh/mesh_file.h"
#include "engine/silhouette/silhouette.h"

namespace airclay {
namespace {

using nlohmann::ordered_json;

struct RigOptions : CommonOptions {
  std::string rig, units, up, center, take;
  double edge_m = 0;  ///< 0: the rig's
};

struct ConvertOptions : RigOptions {
  std::string to, out;
};

struct CheckOptions : RigOptions {
  int background_frames = 10;
};

/// Applies --center and --edge.
void moveWorkspace(const RigOptions& options, ParsedRig& reading) {
  if (options.edge_m > 0) reading.rig.workspace.edge_m = options.edge_m;
  if (options.center.empty()) return;
  if (options.center != "auto") {
    reading.rig.workspace.center = parsePoint("--center", options.center);
    return;
  }
  const std::optional<Vec3> meet = axesIntersection(reading.rig);
  if (!meet)
    throw Error(reading.where + ": the cameras' axes do not intersect in front of them; use --center X,Y,Z");
  reading.rig.workspace.center = *meet;
}

ParsedRig readTheRig(const RigOptions& options) {
  if (!options.center.empty() && options.center != "auto") parsePoint("--center", options.center);
  ParsedRig reading = readAnyRig(options.rig, parseUnits(options.units));
  if (!options.up.empty()) reading.rig = withUpAxis(reading.rig, *axisNamed(options.up));
  moveWorkspace(options, reading);
  return reading;
}

// --- convert ---

/// The folder with the recordings of a rig without image sizes.
std::filesystem::path recordingsOf(const ConvertOptions& options) {
  if (!options.take.empty()) return options.take;
  if (std::filesystem::is_directory(options.rig)) return options.rig;
  const std::filesystem::path folder = std::filesystem::path(options.rig).parent_path();
  return folder.empty() ? "." : folder;
}

void runConvert(const ConvertOptions& options) {
  const RigFormat form = *rigFormatNamed(options.to);
  if (form == RigFormat::kEasyMocap && std::filesystem::path(options.out).has_extension())
    throw Error("--out " + options.out + ": EasyMocap's rig is two files; expected the name of a folder",
                Fault::kUsage);
  ParsedRig reading = readTheRig(options);
  Rig rig = reading.validRig();
  const bool lacks_sizes = std::any_of(rig.cameras.begin(), rig.cameras.end(),
                                       [](const Camera& camera) { return camera.width == 0; });
  if (lacks_sizes) inspectTake(recordingsOf(options), rig, {.instants = 0});
  checkRig(rig, reading.where);
  if (form == RigFormat::kEasyMocap)
    makeFolder(options.out);
  else
    checkWritable(options.out);
  writeRigAs(form, options.out, rig);
  for (const std::string& note : rigFormatNotes(form, rig)) printWarning(note);
  if (options.json) printJson({{"cameras", rig.cameras.size()}, {"form", options.to}});
  printLine(options, counted(rig.cameras.size(), "camera") + ", in " + options.out);
}

// --- check ---

/// Everything known about a rig.
struct RigReport {
  std::string where;
  std::optional<RigMetrics> figures;           ///< nullopt if the rig cannot be measured
  std::vector<SilhouetteAgreement> agreement;  ///< one per camera; empty without silhouettes
  std::vector<RigDiagnostic> findings;

  void add(const std::vector<RigDiagnostic>& more) {
    findings.insert(findings.end(), more.begin(), more.end());
  }
  std::size_t faults() const {
    return std::size_t(std::count_if(findings.begin(), findings.end(), [](const RigDiagnostic& finding) {
      return finding.severity == Severity::kError;
    }));
  }
};

/// A file that cannot be read yields one error.
RigReport reportOn(const CheckOptions& options) {
  RigReport report;
  report.where = options.rig;
  ParsedRig reading;
  try {
    reading = readTheRig(options);
  } catch (const Error& error) {
    if (error.fault() == Fault::kUsage) throw;
    // The error may name the other file of a pair.
    if (!std::string(error.what()).starts_with(report.where))
      report.where = std::filesystem::path(options.rig).parent_path().string();
    report.findings.push_back(diagnosticFromError(error, report.where));
    return report;
  }
  report.where = reading.where;
  report.add(reading.errors);
  TakeInspection take;
  if (!options.take.empty()) {
    const ProgressTask progress("reading the recording", options.printsMessages());
    take = inspectTake(options.take, reading.rig, {.background_frames = options.background_frames});
    report.add(take.findings);
  }
  const std::vector<RigDiagnostic> faults = rigErrors(reading.rig);
  report.add(faults);
  if (!isMeasurable(reading.rig)) return report;
  report.figures = measureRig(reading.rig);
  report.add(rigWarnings(reading.rig));
  const bool fits = take.findings.empty() && reading.errors.empty() && reading.rig.cameras.size() >= 2;
  if (!fits || take.instants.empty()) return report;
  const ProgressTask progress("carving", options.printsMessages());
  report.agreement = silhouetteAgreement(reading.rig, take.instants);
  report.add(silhouetteDiagnostics(reading.rig, take.instants, report.agreement, take.source));
  return report;
}

ordered_json jsonOf(const RigReport& report) {
  ordered_json cameras = ordered_json::array(), findings = ordered_json::array();
  for (std::size_t i = 0; report.figures && i < report.figures->cameras.size(); ++i) {
    const CameraMetrics& figures = report.figures->cameras[i];
    ordered_json camera = {{"name", figures.name},
                           {"size", {figures.width, figures.height}},
                           {"view_deg", figures.view_deg},
                           {"distance_m", figures.distance_m},
                           {"pixels_per_mm", figures.pixels_per_mm},
                           {"seen", figures.seen_fraction}};
    if (!report.agreement.empty()) camera["explained"] = report.agreement[i].explainedFraction();
    cameras.push_back(camera);
  }
  for (const RigDiagnostic& finding : report.findings)
    findings.push_back({{"camera", finding.camera},
                        {"severity", finding.severity == Severity::kError ? "fault" : "suspicion"},
                        {"what", finding.message}});
  ordered_json object = {{"cameras", cameras}};
  if (report.figures) object["seen_by_two"] = report.figures->seen_by_two_fraction;
  object["findings"] = findings;
  object["ok"] = report.faults() == 0;
  return object;
}

std::string percent(double fraction) {
  return fixed(100 * fraction, 0) + " %";
}

void printReport(const RigReport& report) {
  if (report.figures) {
    std::vector<std::vector<std::string>> rows = {
        {"camera", "size", "field of view", "distance", "pixels/mm", "workspace seen"}};
    if (!report.agreement.empty()) rows[0].push_back("silhouette explained");
    for (std::size_t i = 0; i < report.figures->cameras.size(); ++i) {
      const CameraMetrics& camera = report.figures->cameras[i];
      rows.push_back({camera.name, std::to_string(camera.width) + " x " + std::to_string(camera.height),
                      fixed(camera.view_deg, 1) + " deg", fixed(camera.distance_m, 3) + " m",
                      fixed(camera.pixels_per_mm, 2), percent(camera.seen_fraction)});
      if (!report.agreement.empty()) rows.back().push_back(percent(report.agreement[i].explainedFraction()));
    }
    printTable(rows);
    std::puts(
        ("at least two cameras see " + percent(report.figures->seen_by_two_fraction) + " of the workspace")
            .c_str());
  }
  for (const RigDiagnostic& finding : report.findings) {
    const std::string whose = finding.camera.empty() ? "" : "camera \"" + finding.camera + "\": ";
    const std::string line =
        (finding.severity == Severity::kError ? "error: " : "warning: ") + whose + finding.message;
    std::puts(oneLine(line).c_str());
  }
  if (report.findings.empty()) std::puts("no problems found");
}

void runCheck(const CheckOptions& options, int& status) {
  const RigReport report = reportOn(options);
  if (options.json) printJson(jsonOf(report));
  if (options.printsMessages()) printReport(report);
  const std::size_t faults = report.faults();
  if (faults == 0) return;
  const auto first =
      std::find_if(report.findings.begin(), report.findings.end(),
                   [](const RigDiagnostic& finding) { return finding.severity == Severity::kError; });
  printWarning(diagnosticMessage(*first, report.where) +
               (faults > 1 ? " (and " + counted(faults - 1, "more error") + ")" : ""));
  status = static_cast<int>(Fault::kInput);
}

void addRigOptions(CLI::App& command, RigOptions& options) {
  command
      .add_option("RIG", options.rig,
                  "rig file: TOML of Airclay, Anipose, FreeMoCap, Pose2Sim or Caliscope; OpenCV YAML of "
                  "EasyMocap or of a stereo calibration; or a folder that contains one")
      ->type_name("")
      ->required();
  command.add_option("--units", options.units, "unit of a rig file that states none: m or mm")
      ->check(CLI::IsMember({"m", "mm"}).description(""))
      ->type_name("m|mm");
  command.add_option("--up", options.up, "up axis of the rig's world, as --up=-y; the output is z up [z]")
      ->check(CLI::IsMember({"x", "y", "z", "-x", "-y", "-z"}).description(""))
      ->type_name("AXIS");
  command
      .add_option("--center", options.center,
                  "centre of the workspace in the rig's world, metres; auto: the point the cameras look at "
                  "[from the rig]")
      ->type_name("X,Y,Z|auto");
  command.add_option("--edge", options.edge_m, "edge of the workspace, metres [from the rig, otherwise 0.6]")
      ->check(CLI::Range(1e-3, 1e4).description(""))
      ->type_name("M");
}

void addConvert(CLI::App& rig) {
  CLI::App* command = rig.add_subcommand("convert", "convert a rig to another program's format, or from one");
  const auto options = std::make_shared<ConvertOptions>();
  addRigOptions(*command, *options);
  command
      ->add_option("--to", options->to,
                   "output format: airclay, anipose (also FreeMoCap), caliscope, pose2sim or easymocap")
      ->check(CLI::IsMember({"airclay", "anipose", "caliscope", "pose2sim", "easymocap"}).description(""))
      ->type_name("FORMAT")
      ->required();
  command->add_option("--out", options->out, "output file, in metres; for easymocap an output folder")
      ->type_name("FILE|FOLDER")
      ->required();
  command
      ->add_option("--take", options->take,
                   "recording to read image sizes from, for a rig without sizes [the rig's folder]")
      ->type_name("TAKE");
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "Examples:\n  airclay rig convert camera_array.toml --to airclay --center auto --out rig.toml\n"
      "  airclay rig convert calibration.toml --units mm --to airclay --out rig.toml\n"
      "  airclay rig convert rig.toml --to easymocap --out for_easymocap");
  command->callback([options] { runConvert(*options); });
}

void addRigCheck(CLI::App& rig, int& status) {
  CLI::App* command =
      rig.add_subcommand("check", "report all problems of a rig, or of a rig and a recording");
  const auto options = std::make_shared<CheckOptions>();
  addRigOptions(*command, *options);
  command
      ->add_option("TAKE", options->take,
                   "recording with this rig: check image sizes, names, and agreement of the silhouettes")
      ->type_name("");
  command
      ->add_option(
          "--background", options->background_frames,
          "number of frames at the start that show the empty workspace, 1 to 256; ignored if the take "
          "has a folder background/ [10]")
      ->check(CLI::Range(1, static_cast<int>(kMaxLearnFrames)).description(""))
      ->type_name("N");
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "The exit status is 1 if the rig has errors; warnings do not change it.\n\nExamples:\n  airclay rig "
      "check rig.toml\n  airclay rig check rig.toml TAKE --json");
  command->callback([options, &status] { runCheck(*options, status); });
}

}  // namespace

void addRig(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("rig", "check a rig, or convert it from or to other programs' formats");
  command->require_subcommand(1);
  addConvert(*command);
  addRigCheck(*command, status);
}

}  // namespace airclay
