// SPDX-License-Identifier: MIT
// What all commands share: common options, and how to print results.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/core/math.h"
#include "engine/gpu/gpu.h"

namespace CLI {
class App;
}

namespace airclay {

/// Every command accepts these, whether it needs them or not.
struct CommonOptions {
  std::string device;  ///< index or part of a name; empty: the best one
  int voxels = 128;    ///< along an edge of the workspace
  bool quiet = false;
  bool json = false;

  /// False if only the result is printed.
  bool printsMessages() const { return !quiet && !json; }
};

/// The common options that a command uses; it accepts the others, but does not list them.
enum class Uses { kNothing, kDevice, kDeviceAndVoxels };

/// Adds the common options to `command`; `--json` only if it prints results.
void addCommonOptions(CLI::App& command, CommonOptions& options, Uses uses, bool json);

/// Keeps a renamed option's former name working: it is in no help text or completion, and prints one line
/// that names `option`, then acts as `option`. Call it after `option` was added.
void addDeprecatedName(CLI::App& command, const std::string& former_name, const std::string& option);

/// The device that the options choose. Debug builds, and AIRCLAY_VALIDATION=1, enable the validation layer;
/// the destructor prints its messages.
class CommandGpu : public Gpu {
 public:
  explicit CommandGpu(const CommonOptions& options);
  ~CommandGpu();
};

/// Prints one line on standard output, unless --quiet or --json is given.
void printLine(const CommonOptions& options, const std::string& line);

/// Prints one line on standard error, also with --quiet.
void printWarning(const std::string& line);

/// Prints the result of --json.
void printJson(const nlohmann::ordered_json& object);

/// Prints aligned columns; the first row is the header. Numbers align right.
void printTable(const std::vector<std::vector<std::string>>& rows);

/// `value` with `digits` decimals.
std::string fixed(double value, int digits);

/// "1 camera", "4 cameras".
std::string counted(std::size_t count, const std::string& thing);

/// Parses X,Y,Z, the value of `option`. \throw Error (Fault::kUsage)
Vec3 parsePoint(const std::string& option, const std::string& text);

/// `message` in one line: control characters become spaces.
std::string oneLine(std::string message);

// Each adds one command to the program. The command runs after its options are parsed, and sets `status` if
// the exit status is not 0.
void addDemo(CLI::App& program, int& status);
void addSculpt(CLI::App& program, int& status);
void addTrack(CLI::App& program, int& status);
void addEvaluate(CLI::App& program, int& status);
void addHull(CLI::App& program, int& status);
void addSubdivide(CLI::App& program, int& status);
void addDeform(CLI::App& program, int& status);
void addRemesh(CLI::App& program, int& status);
void addExport(CLI::App& program, int& status);
void addNew(CLI::App& program, int& status);
void addHistory(CLI::App& program, int& status);
void addUndo(CLI::App& program, int& status);
void addRedo(CLI::App& program, int& status);
void addRefine(CLI::App& program, int& status);
void addSet(CLI::App& program, int& status);
void addTurn(CLI::App& program, int& status);
void addFigures(CLI::App& program, int& status);
void addBoard(CLI::App& program, int& status);
void addCalibrate(CLI::App& program, int& status);
void addRecalibrate(CLI::App& program, int& status);
void addCameras(CLI::App& program, int& status);
void addOffsets(CLI::App& program, int& status);
void addRecord(CLI::App& program, int& status);
void addServe(CLI::App& program, int& status);
void addRig(CLI::App& program, int& status);
void addCheck(CLI::App& program, int& status);
void addCompare(CLI::App& program, int& status);
void addBench(CLI::App& program, int& status);
void addDevices(CLI::App& program, int& status);
void addReference(CLI::App& program, int& status);

}  // namespace airclay
