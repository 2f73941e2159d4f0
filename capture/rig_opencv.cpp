// SPDX-License-Identifier: MIT
// Reads intri.yml and extri.yml through cv::FileStorage.
#include "capture/rig_opencv.h"

#include <algorithm>
#include <opencv2/core.hpp>

#include "capture/quiet.h"
#include "engine/error.h"

namespace airclay {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 4 << 20;  // 32 cameras take some 20 kB

class YamlFile {
 public:
  explicit YamlFile(const std::filesystem::path& file) : path_(file.string()) {
    std::error_code fault;
    const std::uintmax_t size = std::filesystem::file_size(file, fault);
    if (fault) throw Error(path_ + ": the rig's file is missing or no readable file");
    if (size > kMaxFileBytes) throw Error(path_ + ": it is larger than 4 MB; a rig in YAML would be right");
    try {
      storage_.open(path_, cv::FileStorage::READ);
    } catch (const cv::Exception& error) {
      std::string reason = error.err;
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      throw Error(path_ + ": " + reason + "; OpenCV's YAML would be right");
    }
    if (!storage_.isOpened()) throw Error(path_ + ": it cannot be read; OpenCV's YAML would be right");
  }

  cv::FileNode operator[](const std::string& key) const { return storage_[key]; }
  bool has(const std::string& key) const { return !storage_[key].empty(); }
  const std::string& path() const { return path_; }

  /// A matrix's values, row by row.
  std::vector<double> matrix(const std::string& key, const std::string& right) const {
    const std::string fault =
        path_ + ": " + key + (has(key) ? " must be " : " is missing; it must be ") + right;
    if (!has(key)) throw Error(fault);
    cv::Mat values, doubles;
    try {
      storage_[key] >> values;
      values.convertTo(doubles, CV_64F);
    } catch (const cv::Exception&) {
      throw Error(fault);
    }
    if (doubles.empty() || doubles.channels() != 1) throw Error(fault);
    return std::vector<double>(doubles.begin<double>(), doubles.end<double>());
  }

 private:
  std::string path_;
  cv::FileStorage storage_;
};

std::vector<std::string> cameraNames(const YamlFile& intri) {
  const cv::FileNode names = intri["names"];
  if (!names.isSeq() || names.size() == 0 || names.size() > kMaxCameras)
    throw Error(intri.path() + ": names must list the cameras, 2 to " + std::to_string(kMaxCameras));
  std::vector<std::string> result;
  for (const cv::FileNode& name : names) {
    if (!name.isString() && !name.isInt()) throw Error(intri.path() + ": names must be texts");
    result.push_back(name.isString() ? name.string() : std::to_string(static_cast<int>(name)));
  }
  return result;
}

/// H_NAME or W_NAME; 0 when the file leaves it out.
int side(const YamlFile& intri, const std::string& key) {
  const cv::FileNode node = intri[key];
  if (node.empty()) return 0;
  if (!node.isInt() && !node.isReal())
    throw Error(intri.path() + ": " + key + " must be a whole number of pixels");
  const double value = node.real();
  if (!(value >= kMinPictureSide && value <= kMaxPictureSide))
    throw Error(intri.path() + ": " + key + " must be 16 to 16384 pixels");
  return static_cast<int>(value);
}

}  // namespace

Rig readOpenCvRig(const std::filesystem::path& folder, RigUnits units) {
  quietOpenCv();
  const YamlFile intri(folder / "intri.yml"), extri(folder / "extri.yml");
  const double metres = units == RigUnits::kMillimetres ? 1e-3 : 1;
  Rig rig;
  for (const std::string& name : cameraNames(intri)) {
    CameraEntry camera;
    camera.name = name;
    camera.width = side(intri, "W_" + name);
    camera.height = side(intri, "H_" + name);
    const std::vector<double> matrix = intri.matrix("K_" + name, "a 3 x 3 matrix");
    if (matrix.size() != 9) throw Error(intri.path() + ": K_" + name + " must be a 3 x 3 matrix");
    camera.matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.data());
    camera.distortions = intri.matrix("dist_" + name, "4, 5 or 8 values");
    const std::string rotation_key = (extri.has("Rot_" + name) ? "Rot_" : "R_") + name;
    camera.rotation = extri.matrix(rotation_key, "3 values (Rodrigues) or a 3 x 3 matrix");
    const std::vector<double> translation = extri.matrix("T_" + name, "3 values");
    if (translation.size() != 3) throw Error(extri.path() + ": T_" + name + " must be 3 values");
    camera.translation_m = metres * Vec3(translation[0], translation[1], translation[2]);
    rig.cameras.push_back(cameraFromEntry(camera, folder.string()));
  }
  return rig;
}

}  // namespace airclay
