// SPDX-License-Identifier: MIT
// What the commands share: the options that every one of them takes, and how they print.
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

/// Understood by every command, whether it needs them or not.
struct CommonOptions {
  std::string device;  ///< index or part of a name; empty: the best one
  int voxels = 128;    ///< along the workspace's edge
  bool quiet = false;
  bool json = false;

  /// Whether anything but the result is to be said.
  bool printsMessages() const { return !quiet && !json; }
};

/// Which of the common options mean something to a command; the others are accepted, but not listed.
enum class Uses { kNothing, kDevice, kDeviceAndVoxels };

/// Adds the common options to `command`, `--json` where it prints figures.
void addCommonOptions(CLI::App& command, CommonOptions& options, Uses uses, bool json);

/// The device that the options choose. In a debug build, and wherever AIRCLAY_VALIDATION is 1, the validation
/// layer watches, and what it found is printed at the end.
class CommandGpu : public Gpu {
 public:
  explicit CommandGpu(const CommonOptions& options);
  ~CommandGpu();
};

/// One line on standard output, the result in words: not with --quiet or --json.
void printLine(const CommonOptions& options, const std::string& line);

/// One line on standard error, also with --quiet: the result is not what one would take it for.
void printWarning(const std::string& line);

/// The one object of --json.
void printJson(const nlohmann::ordered_json& object);

/// Columns as wide as their longest cell, the first row being the heads; numbers stand to the right.
void printTable(const std::vector<std::vector<std::string>>& rows);

/// `value` with `digits` after the point.
std::string fixed(double value, int digits);

/// "1 camera", "4 cameras".
std::string counted(std::size_t count, const std::string& thing);

/// X,Y,Z, the value of `option`. \throw Error (Fault::kUsage)
Vec3 parsePoint(const std::string& option, const std::string& text);

/// The words of a message in one line: anything else than printing characters becomes a space.
std::string oneLine(std::string message);

// Each adds its command to the program. The command runs when its words have been read, and sets the exit
// status unless it is 0.
void addDemo(CLI::App& program, int& status);
void addSculpt(CLI::App& program, int& status);
void addTrack(CLI::App& program, int& status);
void addHull(CLI::App& program, int& status);
void addSubdivide(CLI::App& program, int& status);
void addDeform(CLI::App& program, int& status);
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
void addCompare(CLI::App& program, int& status);
void addBench(CLI::App& program, int& status);
void addDevices(CLI::App& program, int& status);
void addReference(CLI::App& program, int& status);

}  // namespace airclay
