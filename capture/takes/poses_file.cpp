// SPDX-License-Identifier: MIT
// Reads and writes the TUM trajectory format, independent of the locale.
#include "capture/takes/poses_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

/// Reads the line's eight numbers; false if there are not exactly eight finite numbers.
bool readNumbers(const std::string& line, std::array<double, 8>& numbers) {
  const char *at = line.data(), *const end = at + line.size();
  const auto skipBlanks = [&] {
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
  };
  for (double& number : numbers) {
    skipBlanks();
    if (at < end && *at == '+') ++at;
    const std::from_chars_result result = std::from_chars(at, end, number);
    if (result.ec != std::errc() || !std::isfinite(number)) return false;
    at = result.ptr;
    if (at < end && *at != ' ' && *at != '\t' && *at != '\r') return false;
  }
  skipBlanks();
  return at == end;
}

}  // namespace

std::vector<TimedPose> readPoses(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file))
    throw Error(file.string() + ": the poses cannot be opened; expected a TUM trajectory");
  std::vector<TimedPose> poses;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::string where = file.string() + ":" + std::to_string(number) + ": ";
    std::array<double, 8> v{};
    if (!readNumbers(line, v))
      throw Error(where + "a pose must be eight finite numbers: timestamp tx ty tz qx qy qz qw");
    const Eigen::Quaterniond rotation(v[7], v[4], v[5], v[6]);
    // Files with three decimals are off by about 1e-3; more is not a rotation.
    if (std::abs(rotation.norm() - 1) > 1e-3)
      throw Error(where + "the quaternion qx qy qz qw has the length " + std::to_string(rotation.norm()) +
                  "; expected 1");
    if (!poses.empty() && v[0] <= poses.back().time_s)
      throw Error(where + "the timestamp is not after the previous one; expected increasing times");
    TimedPose pose{v[0], Pose::Identity()};
    pose.world_from_hand.linear() = rotation.normalized().toRotationMatrix();
    pose.world_from_hand.translation() = Vec3(v[1], v[2], v[3]);
    poses.push_back(pose);
  }
  if (poses.empty()) throw Error(file.string() + ": it contains no pose; expected a TUM trajectory");
  return poses;
}

void writePoses(const std::filesystem::path& file, const std::vector<TimedPose>& poses) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.setf(std::ios::fixed);
  for (const TimedPose& pose : poses) {
    Eigen::Quaterniond rotation(Mat3(pose.world_from_hand.linear()));
    rotation.normalize();
    if (rotation.w() < 0) rotation.coeffs() = -rotation.coeffs();
    const Vec3 position = pose.world_from_hand.translation();
    out.precision(6);
    out << pose.time_s;
    out.precision(7);  // a tenth of a micrometre
    for (const double value : {position.x(), position.y(), position.z()}) out << ' ' << value;
    out.precision(9);
    for (const double value : {rotation.x(), rotation.y(), rotation.z(), rotation.w()}) out << ' ' << value;
    out << '\n';
  }
  writeWhole(file, out.str());
}

}  // namespace airclay
