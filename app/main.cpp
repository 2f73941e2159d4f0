// SPDX-License-Identifier: MIT
// The program `airclay`; its first argument is the command. Exit status: 0 success, 1 bad input or a failed
// comparison, 2 wrong usage, 3 no usable Vulkan device, 128 + N if signal N interrupted it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>

#include "app/cli/command.h"
#include "app/cli/progress.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

constexpr const char* kExamples =
    R"(  test                      build and run every test; only as ./airclay test in the source tree

Examples:
  airclay demo              sculpt with synthetic cameras and a scripted hand; results in out/demo
  airclay sculpt            sculpt with the mouse
  airclay sculpt TAKE       sculpt with the hand of a recording; results in out/sculpt

`airclay COMMAND --help` describes a command.)";

/// Removes the additional blank line that CLI11 prints if the last group of options is hidden.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = CLI::Formatter::make_help(command, name, mode);
    if (const std::size_t blank = text.find("\n\n\n"); blank != std::string::npos) text.erase(blank, 1);
    return text;
  }
};

/// Reports an unknown command by its name; CLI11 would only report an unexpected argument.
void checkCommand(const CLI::App& program, int argc, char** argv) {
  if (argc < 2)
    throw Error("no command given; try `airclay demo`, or `airclay --help` for the list", Fault::kUsage);
  const std::string name = argv[1];
  if (name == "-h" || name == "--help" || name == "--version") return;
  if (name.starts_with("-"))
    throw Error("the command comes before its options: airclay COMMAND " + name, Fault::kUsage);
  if (name == "test")
    throw Error("`test` is a command of the ./airclay script: run ./airclay test in the source tree",
                Fault::kUsage);
  const auto commands = program.get_subcommands([](const CLI::App*) { return true; });
  if (std::none_of(commands.begin(), commands.end(),
                   [&](const CLI::App* c) { return c->get_name() == name; }))
    throw Error("unknown command '" + name + "'; `airclay --help` lists the commands", Fault::kUsage);
}

int run(int argc, char** argv) {
  CLI::App program("Sculpt virtual clay with a bare hand, seen by a few ordinary cameras.", "airclay");
  program.set_version_flag("--version", AIRCLAY_VERSION, "show the version");
  program.set_help_flag("-h,--help", "show this help");
  program.require_subcommand(1);
  program.formatter(std::make_shared<HelpFormatter>());
  program.get_formatter()->column_width(28);
  int status = 0;
  addDemo(program, status);
  addSculpt(program, status);
  addTrack(program, status);
  addEvaluate(program, status);
  addHull(program, status);
  addSubdivide(program, status);
  addDeform(program, status);
  addRemesh(program, status);
  addExport(program, status);
  addNew(program, status);
  addHistory(program, status);
  addUndo(program, status);
  addRedo(program, status);
  addRefine(program, status);
  addSet(program, status);
  addTurn(program, status);
  addFigures(program, status);
  addBoard(program, status);
  addCalibrate(program, status);
  addRecalibrate(program, status);
  addCameras(program, status);
  addOffsets(program, status);
  addRecord(program, status);
  addServe(program, status);
  addRig(program, status);
  addCheck(program, status);
  addCompare(program, status);
  addBench(program, status);
  addDevices(program, status);
  addReference(program, status);
  program.footer(kExamples);  // last, because commands inherit it
  try {
    checkCommand(program, argc, argv);
    program.parse(argc, argv);
    return status;
  } catch (const CLI::Success& help_or_version) {
    return program.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    printWarning(error.what() + std::string("; `airclay ") + argv[1] + " --help` lists the options");
    return static_cast<int>(Fault::kUsage);
  }
}

}  // namespace
}  // namespace airclay

int main(int argc, char** argv) {
  try {
    const int status = airclay::run(argc, argv);
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
    throw airclay::Error(std::string("cannot write to standard output: ") + std::strerror(errno));
  } catch (const airclay::Interrupted& interrupted) {
    airclay::printWarning("interrupted");
    return 128 + interrupted.signal;
  } catch (const airclay::Error& error) {
    airclay::printWarning(error.what());
    return static_cast<int>(error.fault());
  } catch (const std::bad_alloc&) {
    airclay::printWarning("out of memory; fewer voxels, a lower level or a smaller file need less");
  } catch (const std::exception& error) {
    airclay::printWarning(error.what());
  }
  return static_cast<int>(airclay::Fault::kInput);
}
