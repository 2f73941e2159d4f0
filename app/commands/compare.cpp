// SPDX-License-Identifier: MIT
// `airclay compare`: checks every GPU kernel against its CPU reference on this machine's devices.
#include "engine/validation/compare.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

/// The chosen device, or all usable devices.
std::vector<std::string> chosenDevices(const CommonOptions& options) {
  if (!options.device.empty()) return {options.device};
  std::vector<std::string> indices;
  const std::vector<DeviceInfo> devices = Gpu::devices();
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (devices[i].missing.empty()) indices.push_back(std::to_string(i));
  if (indices.empty()) indices.emplace_back();  // Gpu's constructor reports the problem
  return indices;
}

std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2e", value);
  return text;
}

void runCompare(const CommonOptions& options, int& status) {
  std::vector<KernelComparison> kernels;
  for (const std::string& device : chosenDevices(options)) {
    CommonOptions one = options;
    one.device = device;
    CommandGpu gpu(one);
    for (KernelComparison& kernel : compareKernels(gpu)) kernels.push_back(std::move(kernel));
  }
  std::vector<std::vector<std::string>> rows = {{"kernel", "device", "error", "tolerance", ""}};
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  int failed = 0;
  for (const KernelComparison& kernel : kernels) {
    failed += !kernel.pass;
    rows.push_back({kernel.name, kernel.device, scientific(kernel.error), scientific(kernel.tolerance),
                    kernel.pass ? "equal" : "DIFFERS"});
    list.push_back({{"name", kernel.name},
                    {"device", kernel.device},
                    {"error", kernel.error},
                    {"tolerance", kernel.tolerance},
                    {"pass", kernel.pass}});
  }
  if (options.json) printJson({{"kernels", list}});
  if (options.printsMessages()) printTable(rows);
  if (failed == 0) return;
  printWarning(std::to_string(failed) + " of " + std::to_string(kernels.size()) +
               " kernels differ from their reference by more than the tolerance");
  status = static_cast<int>(Fault::kInput);
}

}  // namespace

void addCompare(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("compare", "check every GPU kernel against its CPU reference");
  const auto options = std::make_shared<CommonOptions>();
  addCommonOptions(*command, *options, Uses::kDevice, true);
  command->footer(
      "Runs on every usable device, or on the one that --device names. The exit status is 1 if an error "
      "exceeds its tolerance.");
  command->callback([options, &status] { runCompare(*options, status); });
}

}  // namespace airclay
