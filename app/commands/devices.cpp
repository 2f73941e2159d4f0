// SPDX-License-Identifier: MIT
// `airclay devices`: lists the Vulkan devices of this machine and the features they lack.
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

std::string versionText(std::uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) +
         "." + std::to_string(VK_API_VERSION_PATCH(version));
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "lacks " : ", ") + name;
  return text.empty() ? "usable" : text;
}

void printDevices(const std::vector<DeviceInfo>& devices) {
  std::vector<std::vector<std::string>> rows = {
      {"number", "name", "type", "Vulkan", "memory", "driver", "state"}};
  for (const DeviceInfo& device : devices)
    rows.push_back({std::to_string(rows.size() - 1), device.name, device.type,
                    versionText(device.api_version),
                    fixed(static_cast<double>(device.memory_bytes) / (1 << 30), 1) + " GiB", device.driver,
                    listed(device.missing)});
  printTable(rows);
}

nlohmann::ordered_json asJson(const std::vector<DeviceInfo>& devices) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const DeviceInfo& device : devices)
    list.push_back({{"index", list.size()},
                    {"name", device.name},
                    {"type", device.type},
                    {"driver", device.driver},
                    {"api_version", versionText(device.api_version)},
                    {"memory_bytes", device.memory_bytes},
                    {"usable", device.missing.empty()},
                    {"missing", device.missing}});
  return {{"devices", list}};
}

void runDevices(const CommonOptions& options) {
  const std::vector<DeviceInfo> devices = Gpu::devices();
  if (options.json) printJson(asJson(devices));
  if (devices.empty())
    throw Error("no Vulkan device found; install mesa-vulkan-drivers for the software device",
                Fault::kDevice);
  if (options.printsMessages()) printDevices(devices);
  for (const DeviceInfo& device : devices)
    if (device.missing.empty()) return;
  throw Error("none of the Vulkan devices has the required features; use a driver for Vulkan 1.3",
              Fault::kDevice);
}

}  // namespace

void addDevices(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("devices", "list the Vulkan devices and the features they lack");
  const auto options = std::make_shared<CommonOptions>();
  addCommonOptions(*command, *options, Uses::kNothing, true);
  command->footer(
      "The exit status is 3 if no device is usable. Pass a number or name from this list to --device.");
  command->callback([options] { runDevices(*options); });
}

}  // namespace airclay
