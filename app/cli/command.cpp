// SPDX-License-Identifier: MIT
#include "app/cli/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

GpuOptions gpuOptions(const CommonOptions& options) {
  GpuOptions gpu;
  gpu.device = options.device;
  const char* validation = std::getenv("AIRCLAY_VALIDATION");
  gpu.validation = validation && std::string_view(validation) == "1";
#ifndef NDEBUG
  gpu.validation = true;
#endif
  return gpu;
}

bool isNumber(const std::string& cell) {
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell[0])) || cell[0] == '-');
}

}  // namespace

void addCommonOptions(CLI::App& command, CommonOptions& options, Uses uses, bool json) {
  const auto listedIf = [](CLI::Option* option, bool listed) {
    if (!listed) option->group("");
  };
  listedIf(command
               .add_option("--device", options.device,
                           "Vulkan device: a number from `airclay devices`, or part of a name [the fastest]")
               ->type_name("N|NAME"),
           uses != Uses::kNothing);
  listedIf(
      command
          .add_option("--voxels", options.voxels, "voxels along an edge of the workspace, 32 to 512 [128]")
          ->type_name("N"),
      uses == Uses::kDeviceAndVoxels);
  command.add_flag("--quiet", options.quiet, "print only warnings and errors");
  if (json) command.add_flag("--json", options.json, "print the results as one JSON object");
}

void addDeprecatedName(CLI::App& command, const std::string& former_name, const std::string& option) {
  CLI::Option* current = command.get_option(option);
  const auto forward = [=](const std::string& value) {
    printWarning(former_name + " is deprecated; use " + option);
    current->add_result(value);
    current->run_callback();  // CLI11 ran it before this one, without a value
  };
  const bool is_flag = current->get_items_expected_max() == 0;
  CLI::Option* former = is_flag ? command.add_flag_callback(former_name, [forward] { forward("true"); })
                                : command.add_option_function<std::string>(former_name, forward);
  former->group("");
}

CommandGpu::CommandGpu(const CommonOptions& options) : Gpu(gpuOptions(options)) {}

CommandGpu::~CommandGpu() {
  for (const std::string& message : validationMessages()) printWarning("validation: " + message);
}

void printLine(const CommonOptions& options, const std::string& line) {
  if (options.printsMessages()) std::puts(line.c_str());
}

void printWarning(const std::string& line) {
  std::fprintf(stderr, "airclay: %s\n", oneLine(line).c_str());
}

void printJson(const nlohmann::ordered_json& object) {
  std::puts(object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

void printTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const std::vector<std::string>& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::string line;
    for (std::size_t i = 0; i < rows[r].size(); ++i) {
      const std::string& cell = rows[r][i];
      const std::string padding(widths[i] - cell.size(), ' ');
      // A header aligns as the first cell below it.
      const bool right = isNumber(r == 0 && rows.size() > 1 ? rows[1][i] : cell);
      line += (i ? "  " : "") + (right ? padding + cell : cell + padding);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    std::puts(line.c_str());
  }
}

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string counted(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

Vec3 parsePoint(const std::string& option, const std::string& text) {
  std::vector<double> values;
  std::size_t start = 0;
  while (start <= text.size()) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    const std::optional<double> value = parseNumber(std::string_view(text).substr(start, end - start));
    if (!value) break;
    values.push_back(*value);
    start = end + 1;
  }
  if (values.size() != 3 || start <= text.size())
    throw Error(option + " " + printable(text) + " is not a position; expected X,Y,Z in metres: " + option +
                    " 0,0,0.05",
                Fault::kUsage);
  return {values[0], values[1], values[2]};
}

std::string oneLine(std::string message) {
  for (char& c : message)
    if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
  return message;
}

}  // namespace airclay
