// SPDX-License-Identifier: MIT
// Reads intri.yml and extri.yml, intrinsics.yml and extrinsics.yml through cv::FileStorage.
#include "capture/takes/rig_opencv.h"

#include <algorithm>
#include <fstream>
#include <opencv2/core.hpp>

#include "capture/images/quiet_opencv.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 4 << 20;  // 32 cameras take about 20 kB

class YamlFile {
 public:
  explicit YamlFile(const std::filesystem::path& file) : path_(file.string()) {
    std::error_code status;
    const std::uintmax_t size = std::filesystem::file_size(file, status);
    if (status) throw Error(path_ + ": the rig file is missing or is not a readable file");
    if (size > kMaxFileBytes) throw Error(path_ + ": the file is larger than 4 MB; expected a rig in YAML");
    try {
      storage_.open(path_, cv::FileStorage::READ);
    } catch (const cv::Exception& error) {
      std::string reason = error.err;
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      throw Error(path_ + ": " + reason + "; expected OpenCV's YAML");
    }
    if (!storage_.isOpened()) throw Error(path_ + ": it cannot be read; expected OpenCV's YAML");
  }

  cv::FileNode operator[](const std::string& key) const { return storage_[key]; }
  bool has(const std::string& key) const { return !storage_[key].empty(); }
  const std::string& path() const { return path_; }

  /// "FILE: KEY (line N)", for messages about a key's values.
  std::string placeOf(const std::string& key) const {
    const std::string name = std::filesystem::path(path_).filename().string();
    std::ifstream in(path_, std::ios::binary);
    std::string text;
    for (int line = 1; std::getline(in, text); ++line) {
      const std::size_t at = text.find_first_not_of(" \t<\"");
      if (at != std::string::npos && text.compare(at, key.size(), key) == 0 &&
          std::string(":>\" ").find(text.substr(at + key.size(), 1)) != std::string::npos)
        return name + ": " + key + " (line " + std::to_string(line) + ")";
    }
    return name + ": " + key;
  }

  /// A matrix's values, row by row.
  std::vector<double> matrix(const std::string& key, const std::string& expected) const {
    const std::string message =
        path_ + ": " + key + (has(key) ? " must be " : " is missing; it must be ") + expected;
    if (!has(key)) throw Error(message);
    cv::Mat values, doubles;
    try {
      storage_[key] >> values;
      values.convertTo(doubles, CV_64F);
    } catch (const cv::Exception&) {
      throw Error(message);
    }
    if (doubles.empty() || doubles.channels() != 1) throw Error(message);
    return std::vector<double>(doubles.begin<double>(), doubles.end<double>());
  }

 private:
  std::string path_;
  cv::FileStorage storage_;
};

Mat3 matrix3(const YamlFile& file, const std::string& key) {
  const std::vector<double> values = file.matrix(key, "a 3 x 3 matrix");
  if (values.size() != 9) throw Error(file.path() + ": " + key + " must be a 3 x 3 matrix");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
}

Vec3 vector3(const YamlFile& file, const std::string& key) {
  const std::vector<double> values = file.matrix(key, "3 values");
  if (values.size() != 3) throw Error(file.path() + ": " + key + " must be 3 values");
  return {values[0], values[1], values[2]};
}

std::vector<std::string> cameraNames(const YamlFile& intri) {
  const cv::FileNode names = intri["names"];
  if (!names.isSeq() || names.size() == 0 || names.size() > kMaxCameras)
    throw Error(intri.path() + ": names must list the cameras, 2 to " + std::to_string(kMaxCameras));
  std::vector<std::string> result;
  for (const cv::FileNode& name : names) {
    if (!name.isString() && !name.isInt()) throw Error(intri.path() + ": names must be strings");
    result.push_back(name.isString() ? name.string() : std::to_string(static_cast<int>(name)));
  }
  return result;
}

/// H_NAME or W_NAME; 0 if the file has none.
int side(const YamlFile& intri, const std::string& key) {
  const cv::FileNode node = intri[key];
  if (node.empty()) return 0;
  if (!node.isInt() && !node.isReal())
    throw Error(intri.path() + ": " + key + " must be a whole number of pixels");
  const double value = node.real();
  if (!(value >= kMinImageSide && value <= kMaxImageSide))
    throw Error(intri.path() + ": " + key + " must be 16 to 16384 pixels");
  return static_cast<int>(value);
}

/// The workspace that Airclay stores next to the poses; not part of EasyMocap's format.
Workspace readWorkspace(const YamlFile& extri) {
  Workspace workspace;
  if (extri.has("workspace_center")) workspace.center = vector3(extri, "workspace_center");
  if (!extri.has("workspace_edge")) return workspace;
  const cv::FileNode edge = extri["workspace_edge"];
  if (!(edge.isInt() || edge.isReal()) || !(edge.real() > 0))
    throw Error(extri.path() + ": workspace_edge must be a length in metres, above 0");
  workspace.edge_m = edge.real();
  return workspace;
}

Camera easyMocapCamera(const YamlFile& intri, const YamlFile& extri, const std::string& name, double metres) {
  CameraEntry camera;
  camera.name = name;
  camera.width = side(intri, "W_" + name);
  camera.height = side(intri, "H_" + name);
  camera.matrix = matrix3(intri, "K_" + name);
  const bool has_other_name = !intri.has("dist_" + name) && intri.has("D_" + name);
  const std::string distortions_key = (has_other_name ? "D_" : "dist_") + name;
  camera.distortions = intri.matrix(distortions_key, "4, 5 or 8 values");
  const std::string folder = std::filesystem::path(intri.path()).parent_path().string();
  checkDistortions(camera, intri.placeOf(distortions_key), folder);
  const std::string rotation_key = (extri.has("Rot_" + name) ? "Rot_" : "R_") + name;
  camera.rotation = extri.matrix(rotation_key, "3 values (Rodrigues) or a 3 x 3 matrix");
  camera.translation_m = metres * vector3(extri, "T_" + name);
  return cameraFromEntry(camera, folder);
}

/// Runs `read`; an Error becomes an entry of the rig's errors, so that it does not hide others.
template <class Read>
void collectError(ParsedRig& reading, Read read) {
  try {
    read();
  } catch (const Error& error) {
    reading.errors.push_back(diagnosticFromError(error, reading.where));
  }
}

ParsedRig readEasyMocap(const std::filesystem::path& folder, RigUnits units) {
  const YamlFile intri(folder / "intri.yml"), extri(folder / "extri.yml");
  const double metres = units == RigUnits::kMillimetres ? 1e-3 : 1;
  ParsedRig reading;
  reading.where = folder.string();
  for (const std::string& name : cameraNames(intri))
    collectError(reading,
                 [&] { reading.rig.cameras.push_back(easyMocapCamera(intri, extri, name, metres)); });
  collectError(reading, [&] { reading.rig.workspace = readWorkspace(extri); });
  return reading;
}

/// `extri` is the same object as `intri` if one file contains both.
ParsedRig readStereo(const YamlFile& intri, const YamlFile& extri, RigUnits units) {
  const std::filesystem::path file = intri.path(), folder = file.parent_path();
  ParsedRig reading;
  reading.where = &intri == &extri ? file.string() : folder.string();
  if (units == RigUnits::kAsWritten)
    reading.errors.push_back(
        {Severity::kError, "", "the file does not state the unit of T; expected --units m or mm"});
  const double metres = units == RigUnits::kMillimetres ? 1e-3 : 1;
  for (const bool is_right : {false, true})
    collectError(reading, [&] {
      const std::string number = is_right ? "2" : "1";
      CameraEntry camera;
      camera.name = is_right ? "right" : "left";
      camera.matrix = matrix3(intri, "M" + number);
      camera.distortions = intri.matrix("D" + number, "4, 5 or 8 values");
      checkDistortions(camera, intri.placeOf("D" + number), reading.where);
      camera.rotation = is_right ? extri.matrix("R", "3 values (Rodrigues) or a 3 x 3 matrix")
                                 : std::vector<double>{0, 0, 0};
      if (is_right) camera.translation_m = metres * vector3(extri, "T");
      for (const bool is_height : {false, true})
        (is_height ? camera.height : camera.width) = side(intri, is_height ? "image_height" : "image_width");
      reading.rig.cameras.push_back(cameraFromEntry(camera, reading.where));
    });
  return reading;
}

}  // namespace

ParsedRig readOpenCvRig(const std::filesystem::path& file, RigUnits units) {
  quietOpenCv();
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const std::string name = file.filename().string();
  if (name == "intri.yml" || name == "extri.yml") return readEasyMocap(folder, units);
  if (name == "intrinsics.yml" && !std::filesystem::exists(folder / "extrinsics.yml"))
    throw Error(file.string() +
                ": it has lenses but no poses; expected extrinsics.yml with R and T next to it");
  if (name == "intrinsics.yml" || name == "extrinsics.yml")
    return readStereo(YamlFile(folder / "intrinsics.yml"), YamlFile(folder / "extrinsics.yml"), units);
  const YamlFile one(file);
  if (one.has("M1")) return readStereo(one, one, units);
  throw Error(one.path() +
              (one.has("camera_matrix") ? ": it has one camera's lens and no pose; "
                                        : ": it has no key M1 of OpenCV's stereo calibration; ") +
              "expected a rig of at least two cameras");
}

std::optional<std::filesystem::path> rigFileIn(const std::filesystem::path& folder) {
  // Our own format first. intrinsics.yml alone has only lenses, so the other file of the pair counts.
  for (const char* name :
       {"rig.toml", "camera_array.toml", "calibration.toml", "Calib.toml", "intri.yml", "extrinsics.yml"})
    // Of a symbolic link itself, so that the reader reports a broken one.
    if (std::error_code unreadable;
        std::filesystem::exists(std::filesystem::symlink_status(folder / name, unreadable)))
      return folder / name;
  return std::nullopt;
}

ParsedRig readAnyRig(const std::filesystem::path& rig, RigUnits units) {
  std::filesystem::path file = rig;
  if (std::error_code unreadable; std::filesystem::is_directory(rig, unreadable)) {
    const std::optional<std::filesystem::path> found = rigFileIn(rig);
    if (!found)
      throw Error(
          rig.string() +
          ": the folder has no rig; expected rig.toml, camera_array.toml, calibration.toml, Calib.toml, "
          "intri.yml with extri.yml, or intrinsics.yml with extrinsics.yml");
    file = *found;
  }
  const std::string extension = file.extension().string();
  const bool is_storage =
      extension == ".yml" || extension == ".yaml" || extension == ".xml" || extension == ".json";
  return is_storage ? readOpenCvRig(file, units) : parseRig(file, units);
}

}  // namespace airclay
