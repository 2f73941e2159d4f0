// SPDX-License-Identifier: MIT
// Writes rigs: our own TOML, and other programs' files in the format of their own writers: aniposelib's
// CameraGroup.dump, Caliscope's save_camera_array, Pose2Sim's toml_write, EasyMocap's write_camera.
#include <algorithm>
#include <sstream>

#include "engine/camera/rig_formats.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

/// A stream whose numbers restore every double exactly.
std::ostringstream exactText() {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  return out;
}

std::string quoted(const std::string& name) {
  std::string result = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

/// Only letters, digits, _ and -: valid as a TOML key without quotes, and as part of a YAML key.
bool isPlain(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

bool isRational(const Lens& lens) {
  const std::array<double, 8>& k = lens.distortion;
  return lens.model == LensModel::kPerspective && (k[5] != 0 || k[6] != 0 || k[7] != 0);
}

bool isFisheye(const Camera& camera) {
  return camera.lens.model == LensModel::kFisheye;
}

/// The model's distortion coefficients; k4..k6 only if one of them is not 0.
std::vector<double> writtenDistortions(const Lens& lens) {
  const std::array<double, 8>& k = lens.distortion;
  if (lens.model == LensModel::kFisheye) return {k.begin(), k.begin() + 4};
  return {k.begin(), k.begin() + (isRational(lens) ? 8 : 5)};
}

Vec3 rotationVector(const Camera& camera) {
  const Eigen::AngleAxisd turn(Mat3(camera.camera_from_world.linear()));
  return turn.angle() * turn.axis();
}

Mat3 cameraMatrix(const Lens& lens) {
  Mat3 matrix;
  matrix << lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1;
  return matrix;
}

// --- TOML ---

/// An exact number, always with a decimal point or an exponent: Python's `toml` package, which Anipose and
/// Pose2Sim use, rejects arrays that mix 560 and 319.5.
std::string real(double value) {
  std::ostringstream out = exactText();
  out << value;
  std::string text = out.str();
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

void writeMatrix(std::ostream& out, const char* key, const Mat3& matrix) {
  out << key << " = [";
  for (int row = 0; row < 3; ++row)
    out << (row ? ", [" : "[") << real(matrix(row, 0)) << ", " << real(matrix(row, 1)) << ", "
        << real(matrix(row, 2)) << "]";
  out << "]\n";
}

void writeList(std::ostream& out, const char* key, const std::vector<double>& values) {
  out << key << " = [";
  for (size_t i = 0; i < values.size(); ++i) out << (i ? ", " : "") << real(values[i]);
  out << "]\n";
}

void writeVector(std::ostream& out, const char* key, const Vec3& values) {
  writeList(out, key, {values.begin(), values.end()});
}

void writeLens(std::ostream& out, const Lens& lens) {
  writeMatrix(out, "matrix", cameraMatrix(lens));
  writeList(out, "distortions", writtenDistortions(lens));
}

void writePose(std::ostream& out, const Camera& camera) {
  writeVector(out, "rotation", rotationVector(camera));
  writeVector(out, "translation", camera.camera_from_world.translation());
}

void writeWorkspace(std::ostream& out, const char* table, const Workspace& workspace) {
  out << '[' << table << "]\n";
  writeVector(out, "center", workspace.center);
  out << "edge = " << real(workspace.edge_m) << '\n';
}

/// A camera's table without its pose, in the Airclay and Anipose formats.
void writeCamera(std::ostream& out, size_t index, const Camera& camera) {
  out << "[cam_" << index << "]\nname = " << quoted(camera.name) << "\nsize = [" << camera.width << ", "
      << camera.height << "]\n";
  writeLens(out, camera.lens);
}

/// As aniposelib's CameraGroup.dump; its load treats every table except [metadata] as a camera.
std::string aniposeText(const Rig& rig) {
  std::ostringstream out = exactText();
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    writeCamera(out, i, camera);
    writePose(out, camera);
    if (isFisheye(camera)) out << "fisheye = true\n";
    out << '\n';
  }
  out << "[metadata]\nadjusted = false\nerror = 0.0\nunits = \"m\"\n\n";
  writeWorkspace(out, "metadata.workspace", rig.workspace);
  return out.str();
}

/// As Pose2Sim's toml_write: tables named after the cameras, sizes with a decimal point. Pose2Sim skips only
/// [metadata], [capture_volume], [charuco] and [checkerboard].
std::string pose2SimText(const Rig& rig) {
  std::ostringstream out = exactText();
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    const bool is_taken = camera.name == "metadata" || camera.name == "capture_volume" ||
                          camera.name == "charuco" || camera.name == "checkerboard" ||
                          camera.name == "workspace";
    const std::string& name = camera.name;
    const std::string table = is_taken ? "cam_" + std::to_string(i + 1) : isPlain(name) ? name : quoted(name);
    out << '[' << table << "]\nname = " << quoted(camera.name) << "\nsize = [" << camera.width << ".0, "
        << camera.height << ".0]\n";
    writeLens(out, camera.lens);
    writePose(out, camera);
    out << "fisheye = " << (isFisheye(camera) ? "true" : "false") << "\n\n";
  }
  out << "[metadata]\nadjusted = false\nerror = 0.0\nunits = \"m\"\n\n";
  writeWorkspace(out, "metadata.workspace", rig.workspace);
  return out.str();
}

/// Caliscope identifies cameras by number: N if all names are cam_N, otherwise the camera's index.
std::vector<std::string> caliscopeNumbers(const Rig& rig) {
  std::vector<std::string> of_names, counted;
  for (const Camera& camera : rig.cameras) {
    counted.push_back(std::to_string(counted.size()));
    const std::string number = camera.name.starts_with("cam_") ? camera.name.substr(4) : "";
    const bool is_number = !number.empty() && number.size() <= 6 && (number == "0" || number[0] != '0') &&
                           number.find_first_not_of("0123456789") == std::string::npos;
    if (is_number) of_names.push_back(number);
  }
  return of_names.size() == counted.size() ? of_names : counted;
}

/// As Caliscope's save_camera_array; its load ignores everything outside [cameras].
std::string caliscopeText(const Rig& rig) {
  const std::vector<std::string> numbers = caliscopeNumbers(rig);
  std::ostringstream out = exactText();
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    out << "[cameras." << numbers[i] << "]\ncam_id = " << numbers[i] << "\nname = " << quoted(camera.name)
        << "\nsize = [" << camera.width << ", " << camera.height << "]\nrotation_count = 0\n";
    writeLens(out, camera.lens);
    writePose(out, camera);
    out << "fisheye = " << (isFisheye(camera) ? "true" : "false") << "\nignore = false\n\n";
  }
  writeWorkspace(out, "workspace", rig.workspace);
  return out.str();
}

// --- OpenCV's YAML ---

void writeYamlMatrix(std::ostream& out, const std::string& key, const Eigen::MatrixXd& matrix) {
  out << key << ": !!opencv-matrix\n  rows: " << matrix.rows() << "\n  cols: " << matrix.cols()
      << "\n  dt: d\n  data: [";
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      out << (row + column ? ", " : "") << matrix(row, column);
  out << "]\n";
}

void writeYamlNames(std::ostream& out, const Rig& rig) {
  out << "%YAML:1.0\n---\nnames:\n";
  for (const Camera& camera : rig.cameras) out << "  - " << quoted(camera.name) << '\n';
}

/// As EasyMocap's write_camera: R_ is the rotation vector, Rot_ the matrix.
void writeEasyMocap(const std::filesystem::path& folder, const Rig& rig) {
  for (const Camera& camera : rig.cameras) {
    if (isFisheye(camera))
      throw Error(folder.string() + ": camera \"" + camera.name +
                  "\" has a fisheye lens, which EasyMocap's files cannot express; use another format");
    if (!isPlain(camera.name))
      throw Error(
          folder.string() + ": camera \"" + camera.name +
          "\" has a name that EasyMocap's files cannot contain; expected letters, digits, _ and - only");
  }
  std::ostringstream intri = exactText(), extri = exactText();
  writeYamlNames(intri, rig);
  writeYamlNames(extri, rig);
  for (const Camera& camera : rig.cameras) {
    const std::vector<double> k = writtenDistortions(camera.lens);
    writeYamlMatrix(intri, "K_" + camera.name, cameraMatrix(camera.lens));
    writeYamlMatrix(intri, "dist_" + camera.name,
                    Eigen::Map<const Eigen::RowVectorXd>(k.data(), static_cast<Eigen::Index>(k.size())));
    intri << "H_" << camera.name << ": " << camera.height << "\nW_" << camera.name << ": " << camera.width
          << '\n';
    writeYamlMatrix(extri, "R_" + camera.name, rotationVector(camera));
    writeYamlMatrix(extri, "Rot_" + camera.name, camera.camera_from_world.linear());
    writeYamlMatrix(extri, "T_" + camera.name, camera.camera_from_world.translation());
  }
  writeYamlMatrix(extri, "workspace_center", rig.workspace.center);
  extri << "workspace_edge: " << rig.workspace.edge_m << '\n';
  writeWhole(folder / "intri.yml", intri.str());
  writeWhole(folder / "extri.yml", extri.str());
}

}  // namespace

void writeRig(const std::filesystem::path& file, const Rig& rig, RotationFormat rotations) {
  std::ostringstream out = exactText();
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    writeCamera(out, i, camera);
    if (isFisheye(camera)) out << "fisheye = true\n";
    if (rotations == RotationFormat::kMatrices) {
      writeMatrix(out, "rotation", camera.camera_from_world.linear());
      writeVector(out, "translation", camera.camera_from_world.translation());
    } else {
      writePose(out, camera);
    }
    out << '\n';
  }
  writeWorkspace(out, "workspace", rig.workspace);
  out << "\n[metadata]\nunits = \"m\"\n";
  writeWhole(file, out.str());
}

std::optional<RigFormat> rigFormatNamed(std::string_view name) {
  if (name == "airclay") return RigFormat::kAirclay;
  if (name == "anipose") return RigFormat::kAnipose;
  if (name == "caliscope") return RigFormat::kCaliscope;
  if (name == "pose2sim") return RigFormat::kPose2Sim;
  if (name == "easymocap") return RigFormat::kEasyMocap;
  return std::nullopt;
}

void writeRigAs(RigFormat format, const std::filesystem::path& file, const Rig& rig) {
  switch (format) {
    case RigFormat::kAirclay:
      return writeRig(file, rig);
    case RigFormat::kAnipose:
      return writeWhole(file, aniposeText(rig));
    case RigFormat::kCaliscope:
      return writeWhole(file, caliscopeText(rig));
    case RigFormat::kPose2Sim:
      return writeWhole(file, pose2SimText(rig));
    case RigFormat::kEasyMocap:
      return writeEasyMocap(file, rig);
  }
}

std::vector<std::string> rigFormatNotes(RigFormat format, const Rig& rig) {
  std::vector<std::string> notes;
  const std::vector<std::string> numbers = caliscopeNumbers(rig);
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    const std::string named = "camera \"" + camera.name + "\"";
    if (format == RigFormat::kPose2Sim && isFisheye(camera))
      notes.push_back(named + " has a fisheye lens; Pose2Sim treats every lens as perspective");
    if (format == RigFormat::kCaliscope && isRational(camera.lens))
      notes.push_back(
          named + " has 8 distortion coefficients; Caliscope itself uses 5, and does not show the others");
    if (format == RigFormat::kCaliscope && camera.name != "cam_" + numbers[i])
      notes.push_back(named + " is number " + numbers[i] + " in Caliscope, which expects its video as cam_" +
                      numbers[i] + ".mp4");
  }
  return notes;
}

}  // namespace airclay
