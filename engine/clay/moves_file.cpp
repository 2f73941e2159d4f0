// SPDX-License-Identifier: MIT
// Reads the moves of `deform`: CSV with the header index,x,y,z and one line per data point.
#include <charconv>
#include <vector>

#include "engine/clay/solve.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

constexpr size_t kMaxMovesBytes = size_t(1) << 30;  // kMaxDataPoints points with all their digits

std::string_view trimmed(std::string_view text) {
  const size_t begin = std::min(text.find_first_not_of(" \t\r"), text.size());
  const size_t end = std::min(text.find_last_not_of(" \t\r"), text.size() - 1);
  return text.substr(begin, end + 1 - begin);
}

std::vector<std::string_view> fields(std::string_view line) {
  std::vector<std::string_view> found;
  while (true) {
    const size_t comma = line.find(',');
    found.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos || found.size() > 4) return found;
    line.remove_prefix(comma + 1);
  }
}

/// A line `index,x,y,z`; `where` is file:line.
Move parseMove(std::string_view line, int data_point_count, const std::string& where) {
  const std::vector<std::string_view> values = fields(line);
  if (values.size() != 4) throw Error(where + ": '" + printable(line) + "' must be four values, index,x,y,z");
  const std::string range = "0 to " + std::to_string(data_point_count - 1);
  Move move;
  const std::string_view index = values[0];
  const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), move.index);
  if (index.empty() || end != index.data() + index.size() || error == std::errc::invalid_argument)
    throw Error(where + ": index '" + printable(index) + "' must be a whole number, " + range);
  if (error != std::errc() || move.index < 0 || move.index >= data_point_count)
    throw Error(where + ": data point " + printable(index) + " does not exist; expected " + range);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view value = values[size_t(axis + 1)];
    const std::optional<double> number = parseNumber(value);
    if (!number) throw Error(where + ": coordinate '" + printable(value) + "' is not a finite number");
    move.target[axis] = *number;
  }
  return move;
}

}  // namespace

std::vector<Move> readMoves(const std::filesystem::path& file, int data_point_count) {
  const std::string text = readWhole(file, kMaxMovesBytes);
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // a byte-order mark
  std::vector<Move> moves;
  std::vector<long> line_of_point(size_t(data_point_count), 0);
  bool has_header = false;
  for (long line_number = 1; !rest.empty(); ++line_number) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.empty()) continue;
    const std::string where = file.string() + ":" + std::to_string(line_number);
    if (!has_header) {
      if (fields(line) != std::vector<std::string_view>{"index", "x", "y", "z"})
        throw Error(where + ": '" + printable(line) + "' must be the header, index,x,y,z");
      has_header = true;
      continue;
    }
    moves.push_back(parseMove(line, data_point_count, where));
    long& first = line_of_point[size_t(moves.back().index)];
    if (first > 0)
      throw Error(where + ": data point " + std::to_string(moves.back().index) +
                  " is already moved in line " + std::to_string(first) + "; expected each point once");
    first = line_number;
  }
  if (!has_header) throw Error(file.string() + ": is empty; it must begin with the header index,x,y,z");
  return moves;
}

}  // namespace airclay
