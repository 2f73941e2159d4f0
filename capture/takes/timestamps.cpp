// SPDX-License-Identifier: MIT
// Reads timestamps.csv. Columns other than cam_id and frame_time are ignored.
#include "capture/takes/timestamps.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>

#include "engine/core/error.h"

namespace airclay {
namespace {

std::vector<std::string> splitRow(const std::string& line) {
  std::vector<std::string> cells;
  for (size_t at = 0; at <= line.size();) {
    const size_t comma = std::min(line.find(',', at), line.size());
    std::string cell = line.substr(at, comma - at);
    const size_t first = cell.find_first_not_of(" \t\r\""), last = cell.find_last_not_of(" \t\r\"");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    at = comma + 1;
  }
  return cells;
}

template <class Number>
std::optional<Number> parsed(const std::string& cell) {
  Number value{};
  const char* const end = cell.data() + cell.size();
  const std::from_chars_result result = std::from_chars(cell.data(), end, value);
  return result.ec == std::errc() && result.ptr == end ? std::optional(value) : std::nullopt;
}

/// The number at the end of a name, without leading zeros; "" if there is none.
std::string trailingNumber(const std::string& name) {
  const std::string digits =
      name.substr(name.find_last_not_of("0123456789") + 1);  // npos + 1 is 0: all of it
  const size_t significant = digits.find_first_not_of('0');
  return significant == std::string::npos ? digits.substr(0, 1) : digits.substr(significant);
}

/// All valid cam_id values, with the camera's index in the rig. A number at the end of two names is ambiguous
/// and omitted.
std::map<std::string, size_t> cameraIds(const std::vector<std::string>& names) {
  std::map<std::string, std::vector<size_t>> owners;
  for (size_t i = 0; i < names.size(); ++i)
    if (const std::string number = trailingNumber(names[i]); !number.empty()) owners[number].push_back(i);
  if (owners.empty())
    for (size_t i = 0; i < names.size(); ++i) owners[std::to_string(i)] = {i};
  std::map<std::string, size_t> ids;
  for (const auto& [number, places] : owners)
    if (places.size() == 1) ids[number] = places.front();
  for (size_t i = 0; i < names.size(); ++i)
    ids[names[i]] = i;  // a name takes precedence over another's number
  return ids;
}

struct Columns {
  size_t camera, time, count;
};

Columns readHeader(std::istream& in, const std::string& file) {
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> cells = splitRow(line);
  const auto camera = std::find(cells.begin(), cells.end(), "cam_id");
  const auto time = std::find(cells.begin(), cells.end(), "frame_time");
  if (camera == cells.end() || time == cells.end())
    throw Error(file + ":1: the header must name the columns cam_id and frame_time");
  return {static_cast<size_t>(camera - cells.begin()), static_cast<size_t>(time - cells.begin()),
          cells.size()};
}

}  // namespace

std::vector<std::vector<double>> readFrameTimes(const std::filesystem::path& file,
                                                const std::vector<std::string>& camera_names, int frame_count,
                                                bool unfinished) {
  std::ifstream in(file);
  if (!in) throw Error(file.string() + ": the timestamps cannot be opened for reading");
  const Columns columns = readHeader(in, file.string());
  const std::map<std::string, size_t> ids = cameraIds(camera_names);
  std::vector<std::vector<double>> times(camera_names.size());
  std::string line;
  for (int number = 2; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (unfinished && in.eof()) break;
    const std::string where = file.string() + ":" + std::to_string(number) + ": ";
    const std::vector<std::string> cells = splitRow(line);
    if (cells.size() != columns.count)
      throw Error(where + "the row has " + std::to_string(cells.size()) + " cells; expected " +
                  std::to_string(columns.count) + ", as in the header");
    const auto id = ids.find(cells[columns.camera]);
    if (id == ids.end())
      throw Error(where + "cam_id \"" + cells[columns.camera] +
                  "\" is not a camera of the rig; expected a camera's name or number");
    const std::optional<double> time = parsed<double>(cells[columns.time]);
    if (!time || !std::isfinite(*time)) throw Error(where + "frame_time must be a finite number of seconds");
    std::vector<double>& of_camera = times[id->second];
    if (!of_camera.empty() && *time <= of_camera.back())
      throw Error(where + "frame_time is not after the camera's previous row; expected increasing times");
    of_camera.push_back(*time);
  }

  auto frames = static_cast<size_t>(frame_count);
  for (size_t i = 0; i < times.size(); ++i) {
    if (times[i].size() >= frames) continue;
    if (!unfinished)
      throw Error(file.string() + ": camera \"" + camera_names[i] + "\" has " +
                  std::to_string(times[i].size()) + " rows; expected one for each of the " +
                  std::to_string(frame_count) + " frames");
    frames = times[i].size();
  }
  std::vector<std::vector<double>> of_frames(frames);
  for (size_t frame = 0; frame < frames; ++frame)
    for (const std::vector<double>& of_camera : times) of_frames[frame].push_back(of_camera[frame]);
  return of_frames;
}

}  // namespace airclay
