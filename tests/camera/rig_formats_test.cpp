// SPDX-License-Identifier: MIT
// Rigs of other programs: files as these programs write them, with known camera positions; and our files,
// read as these programs read them.
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <algorithm>
#include <initializer_list>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "capture/images/image_file.h"
#include "capture/takes/rig_opencv.h"
#include "capture/takes/take.h"
#include "engine/camera/rig_formats.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

// The same two cameras in every file: on the -x and the y axis, 1.2 m from the centre, upright, z up.
// Rotations: by 120 degrees about (1, -1, 1), rows (0 -1 0), (0 0 -1), (1 0 0); and the matrix below.
constexpr const char* kOnMinusX = "1.2091995761561452, -1.2091995761561452, 1.2091995761561452";
constexpr const char* kOnYMatrix = "[[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]]";
constexpr const char* kOnY = "0.0, 2.221441469079183, -2.221441469079183";  // 180 degrees about (0, 1, -1)

/// The cameras are on the two axes and look at the centre.
void expectOnAxes(const Rig& rig) {
  ASSERT_EQ(rig.cameras.size(), 2u);
  const Vec3 places[] = {Vec3(-1.2, 0, 0), Vec3(0, 1.2, 0)};
  for (int i = 0; i < 2; ++i) {
    const Camera& camera = rig.cameras[std::size_t(i)];
    EXPECT_LE((camera.camera_from_world.inverse().translation() - places[i]).norm(), 1e-9) << camera.name;
    const std::optional<Vec2> center = project(camera, Vec3::Zero());
    ASSERT_TRUE(center) << camera.name;
    EXPECT_LE((*center - Vec2(camera.lens.cx, camera.lens.cy)).norm(), 1e-6) << camera.name;
    EXPECT_LT(project(camera, {0, 0, 0.1})->y(), center->y()) << camera.name;  // z is up
  }
}

TEST(RigFormats, ReadsAnipose) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("calibration.toml", std::string(R"([cam_0]
name = "A"
size = [ 1440, 1080,]
matrix = [ [ 1852.4, 0.0, 719.5,], [ 0.0, 1852.4, 539.5,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.0361, 0.0, 0.0, 0.0, 0.0,]
rotation = [ )") + kOnMinusX + R"(,]
translation = [ 0.0, 0.0, 1200.0,]

[cam_1]
name = "B"
size = [ 1440, 1080,]
matrix = [ [ 1935.9, 0.0, 719.5,], [ 0.0, 1935.9, 539.5,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.3133, 0.0, 0.0, 0.0, 0.0,]
rotation = [ )" + kOnY + R"(,]
translation = [ 0.0, 0.0, 1200.0,]

[metadata]
adjusted = true
error = 1.6680509250648916
)");
  EXPECT_NE(messageOf([&] { readRig(file); }).find("units"), std::string::npos);
  const Rig rig = readRig(file, RigUnits::kMillimetres);
  expectOnAxes(rig);
  EXPECT_EQ(rig.cameras[1].name, "B");
  EXPECT_EQ(rig.cameras[1].width, 1440);
}

TEST(RigFormats, ReadsFreeMoCap) {
  const TemporaryFolder folder;
  const auto camera = [](const std::string& table, const std::string& rotation, const std::string& place) {
    return "[" + table + "]\nname = \"" + table +
           "\"\nsize = [ 640.0, 480.0,]\n"
           "matrix = [ [ 560.0, 0.0, 319.5,], [ 0.0, 560.0, 239.5,], [ 0.0, 0.0, 1.0,],]\n"
           "distortions = [ 0.0, 0.0, 0.0, 0.0, 0.0,]\nrotation = [ " +
           rotation +
           ",]\n"
           "translation = [ 0.0, 0.0, 1200.0,]\nworld_position = [ " +
           place +
           ",]\n"
           "world_orientation = [ [ 1.0, 0.0, 0.0,], [ 0.0, 1.0, 0.0,], [ 0.0, 0.0, 1.0,],]\n\n";
  };
  const Rig rig =
      readRig(folder.write("a_camera_calibration.toml",
                           camera("cam_0", kOnMinusX, "-1200.0, 0.0, 0.0") +
                               camera("Camera_001", kOnY, "0.0, 1200.0, 0.0") +
                               "[metadata]\nadjusted = false\nerror = 0.0\ncharuco_square_size = 39.0\n"
                               "charuco_board_object = \"<CharucoBoard>\"\ngroundplane_calibration = true\n"),
              RigUnits::kMillimetres);
  expectOnAxes(rig);
  EXPECT_EQ(rig.cameras[1].name, "Camera_001");
}

TEST(RigFormats, ReadsPose2Sim) {
  const TemporaryFolder folder;
  const auto camera = [](const std::string& table, const std::string& rotation) {
    return "[" + table + "]\nname = \"" + table +
           "\"\nsize = [ 1088.0, 1920.0]\n"
           "matrix = [ [ 1681.2, 0.0, 532.97], [ 0.0, 1681.1, 948.13], [ 0.0, 0.0, 1.0]]\n"
           "distortions = [ -0.0007, 0.0021, 9.5e-06, 1.0e-05]\nrotation = [ " +
           rotation +
           "]\n"
           "translation = [ 0.0, 0.0, 1.2]\nfisheye = false\n\n";
  };
  const Rig rig =
      readRig(folder.write("Calib_scene.toml", camera("int_cam1_img", kOnMinusX) + camera("links", kOnY) +
                                                   "[metadata]\nadjusted = false\nerror = 0.0\n"),
              RigUnits::kMetres);
  expectOnAxes(rig);
  EXPECT_EQ(rig.cameras[0].name, "int_cam1_img");  // table names are arbitrary
  EXPECT_EQ(rig.cameras[0].width, 1088);
  EXPECT_EQ(rig.cameras[0].height, 1920);
  EXPECT_EQ(rig.cameras[1].lens.distortion[1], 0.0021);
}

const std::string kCaliscopeLens =
    "size = [1280, 720]\nmatrix = [[894.5, 0.0, 624.0], [0.0, 896.8, 361.2], [0.0, 0.0, 1.0]]\n"
    "distortions = [-0.338, 0.0967, -0.0013, 0.0031, -0.0037]\ntranslation = [0.0, 0.0, 1.2]\n";

TEST(RigFormats, ReadsCurrentCaliscope) {
  const TemporaryFolder folder;
  const Rig rig = readRig(folder.write(
      "camera_array.toml", "[cameras.0]\ncam_id = 0\nrotation_count = 0\nerror = 0.19\n" + kCaliscopeLens +
                               "rotation = [" + kOnMinusX +
                               "]\nexposure = -7\ngrid_count = 24\nfisheye = false\n"
                               "[cameras.3]\ncam_id = 3\nrotation_count = -1\n" +
                               kCaliscopeLens + "rotation = [" + kOnY +
                               "]\nfisheye = false\n"
                               "[cameras.4]\ncam_id = 4\nsize = [1280, 720]\nrotation = \"null\"\n"
                               "translation = \"null\"\nmatrix = \"null\"\n"));
  expectOnAxes(rig);
  EXPECT_EQ(rig.cameras[1].name, "cam_3");
}

TEST(RigFormats, ReadsOldCaliscope) {
  const TemporaryFolder folder;
  const auto camera = [](const std::string& head, const std::string& rotation) {
    return head + "rotation_count = 0\nignore = false\n" + kCaliscopeLens + "rotation = " + rotation +
           "\nverified_resolutions = [[640, 480], [1280, 720]]\n\n";
  };
  const std::string cameras = camera("[cameras.1]\nport = 1\n", "[" + std::string(kOnMinusX) + "]") +
                              camera("[cameras.2]\nport = 2\n", kOnYMatrix) +
                              "[cameras.7]\nport = 7\nignore = true\nsize = [1280, 720]\n";
  const Rig rig = readRig(folder.write("camera_array.toml", cameras));
  EXPECT_EQ(rig.cameras.at(0).name, "port_1");
  EXPECT_EQ(rig.cameras.at(1).name, "port_2");
  EXPECT_LE((rig.cameras[1].camera_from_world.inverse().translation() - Vec3(0, 1.2, 0)).norm(), 1e-9);

  // Before 2023, config.toml contained the cameras among other tables, without a unit.
  const std::filesystem::path config = folder.write(
      "config.toml", "CreationDate = 2023-05-06T11:12:27.631355\ncamera_count = 0\n" +
                         camera("[cam_1]\ncam_id =1\n", "[" + std::string(kOnMinusX) + "]") +
                         camera("[cam_2]\ncam_id =2\n", kOnYMatrix) + "[capture_volume]\nstage = 2\n" +
                         "[charuco]\ncolumns = 4\nrows = 5\nunits = \"inch\"\n");
  EXPECT_NE(messageOf([&] { readRig(config); }).find("units"), std::string::npos);
  const Rig old = readRig(config, RigUnits::kMetres);
  expectOnAxes(old);
  EXPECT_EQ(old.cameras[1].name, "cam_2");
}

std::string yamlMatrix(const std::string& key, const std::string& shape, const std::string& data) {
  return key + ": !!opencv-matrix\r\n  rows: " + shape.substr(0, 1) + "\r\n  cols: " + shape.substr(2) +
         "\r\n  dt: d\r\n  data: [" + data + "]\r\n";
}

/// As EasyMocap writes them: six digits, CR LF line ends.
void writeEasyMocapFiles(const TemporaryFolder& folder, const std::string& lens_key) {
  const std::string head = "%YAML:1.0\r\n---\r\nnames:\r\n  - \"01\"\r\n  - \"02\"\r\n";
  const std::string k =
      "560.000000, 0.000000, 319.500000, 0.000000, 560.000000, 239.500000, 0.000000, 0.000000, 1.000000";
  std::string intri = head, extri = head;
  for (const std::string name : {"01", "02"})
    intri += yamlMatrix("K_" + name, "3x3", k) +
             yamlMatrix(lens_key + name, "1x5", "0.1, 0.0, 0.0, 0.0, 0.0") + "H_" + name + ": 480\r\nW_" +
             name + ": 640\r\n";
  extri +=
      yamlMatrix("R_01", "3x1", "1.209200, -1.209200, 1.209200") +
      yamlMatrix("T_01", "3x1", "0.000000, 0.000000, 1.200000") +
      yamlMatrix("R_02", "3x1", "0.000000, 2.221441, -2.221441") +
      yamlMatrix(
          "Rot_02", "3x3",
          "-1.000000, 0.000000, 0.000000, 0.000000, 0.000000, -1.000000, 0.000000, -1.000000, 0.000000") +
      yamlMatrix("T_02", "3x1", "0.000000, 0.000000, 1.200000");
  folder.write("intri.yml", intri);
  folder.write("extri.yml", extri);
}

TEST(RigFormats, ReadsEasyMocap) {
  const TemporaryFolder folder;
  for (const std::string lens_key : {"dist_", "D_"}) {
    writeEasyMocapFiles(folder, lens_key);
    const ParsedRig reading = readAnyRig(folder.path(), RigUnits::kAsWritten);
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0].message;
    ASSERT_EQ(reading.rig.cameras.size(), 2u);
    EXPECT_EQ(reading.rig.cameras[0].name, "01");
    EXPECT_EQ(reading.rig.cameras[0].height, 480);
    EXPECT_EQ(reading.rig.cameras[1].lens.distortion[0], 0.1);
    const Vec3 place = reading.rig.cameras[0].camera_from_world.inverse().translation();
    EXPECT_LE((place - Vec3(-1.2, 0, 0)).norm(), 1e-5);  // six digits
    EXPECT_LE((reading.rig.cameras[1].camera_from_world.inverse().translation() - Vec3(0, 1.2, 0)).norm(),
              1e-9);
  }
  EXPECT_EQ(readAnyRig(folder / "extri.yml", RigUnits::kAsWritten).rig.cameras.size(), 2u);
}

TEST(RigFormats, ReadsOpenCvStereoCalibration) {
  const TemporaryFolder folder;
  const cv::Matx33d m1(534.8, 0, 335.7, 0, 534.8, 240.7, 0, 0, 1),
      m2(530.1, 0, 334.6, 0, 530.2, 242.1, 0, 0, 1);
  const cv::Mat d1 = (cv::Mat_<double>(1, 14) << 0.29, -1.03, 0, 0, 0, 0.1, 0.02, 0, 0, 0, 0, 0, 0, 0);
  const cv::Mat d2 = (cv::Mat_<double>(1, 5) << -0.169, -0.112, 1e-3, 2e-3, 0.01);
  const cv::Vec3d turn(0.02, 0.9, 0.03), shift(-0.8, 0.02, 0.35);
  cv::Mat r;
  cv::Rodrigues(turn, r);
  {
    cv::FileStorage intrinsics((folder / "intrinsics.yml").string(), cv::FileStorage::WRITE);
    intrinsics << "M1" << cv::Mat(m1) << "D1" << d1 << "M2" << cv::Mat(m2) << "D2" << d2;
    cv::FileStorage extrinsics((folder / "extrinsics.yml").string(), cv::FileStorage::WRITE);
    extrinsics << "R" << r << "T" << cv::Mat(shift) << "Q" << cv::Mat::eye(4, 4, CV_64F);
  }
  const ParsedRig bare = readAnyRig(folder.path(), RigUnits::kAsWritten);
  ASSERT_EQ(bare.errors.size(), 1u);
  EXPECT_NE(bare.errors[0].message.find("--units"), std::string::npos);
  const ParsedRig reading = readAnyRig(folder / "intrinsics.yml", RigUnits::kMetres);
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0].message;
  ASSERT_EQ(reading.rig.cameras.size(), 2u);
  EXPECT_EQ(reading.rig.cameras[0].width, 0);  // such a file does not contain it

  // A point's pixels equal OpenCV's in both images.
  const cv::Point3d point(0.2, -0.1, 1.3);
  for (const int i : {0, 1}) {
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(std::vector<cv::Point3d>{point}, i ? turn : cv::Vec3d(), i ? shift : cv::Vec3d(),
                      i ? m2 : m1, i ? d2 : d1, pixels);
    const Camera& camera = reading.rig.cameras[std::size_t(i)];
    const std::optional<Vec2> ours =
        projectThroughLens(camera.lens, camera.camera_from_world * Vec3(point.x, point.y, point.z));
    ASSERT_TRUE(ours);
    EXPECT_LE((*ours - Vec2(pixels[0].x, pixels[0].y)).norm(), 1e-6) << camera.name;
  }
  std::filesystem::remove(folder / "extrinsics.yml");
  EXPECT_NE(
      messageOf([&] { readAnyRig(folder / "intrinsics.yml", RigUnits::kMetres); }).find("extrinsics.yml"),
      std::string::npos);
  const auto one_camera = folder.write("camera.yml", "%YAML:1.0\n---\ncamera_matrix: 1\n");
  EXPECT_NE(messageOf([&] { readAnyRig(one_camera, RigUnits::kMetres); }).find("no pose"), std::string::npos);
}

TEST(RigFormats, LongDistortionsMustEndInZeros) {
  CameraEntry entry;
  entry.name = "left";
  entry.width = 640, entry.height = 480;
  entry.matrix << 560, 0, 319.5, 0, 560, 239.5, 0, 0, 1;
  entry.rotation = {0, 0, 0};
  for (const std::size_t count : {4, 5, 8, 12, 14}) {
    entry.distortions.assign(count, 0.0);
    entry.distortions[1] = 0.25;
    EXPECT_EQ(cameraFromEntry(entry, "file").lens.distortion[1], 0.25) << count;
  }
  entry.distortions[8] = 1e-5;
  const std::string message = messageOf([&] { cameraFromEntry(entry, "file"); });
  EXPECT_NE(message.find("14 values"), std::string::npos) << message;
  entry.fisheye = true;
  entry.distortions.assign(12, 0.0);
  EXPECT_NE(messageOf([&] { cameraFromEntry(entry, "file"); }).find("fisheye"), std::string::npos);
}

void expectMentions(const std::string& message, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

/// A rig file of two cameras, whose first has these distortions in line 4.
std::string tomlWith(const std::string& distortions) {
  return "[cam_0]\nsize = [640, 480]\nmatrix = [[560, 0, 320], [0, 560, 240], [0, 0, 1]]\ndistortions = [" +
         distortions + "]\nrotation = [" + kOnMinusX +
         "]\ntranslation = [0, 0, 1.2]\n\n[cam_1]\nsize = [640, 480]\n" +
         "matrix = [[560, 0, 320], [0, 560, 240], [0, 0, 1]]\ndistortions = [0, 0, 0, 0]\nrotation = [" +
         kOnY + "]\ntranslation = [0, 0, 1.2]\n";
}

TEST(RigFormats, ThinPrismAndTiltAreReportedWithKeyAndLine) {
  const TemporaryFolder folder;
  const std::string zeros = "0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0";
  const auto file = folder.write("rig.toml", tomlWith(zeros + ", 0, 0"));
  EXPECT_EQ(readRig(file, RigUnits::kMetres).cameras[0].lens.distortion[0], 0.1);
  for (const std::string& tail : {std::string(", 0.001, 0"), std::string(", 0, -0.02")}) {
    folder.write("rig.toml", tomlWith(zeros + tail));
    expectMentions(
        messageOf([&] { readRig(file, RigUnits::kMetres); }),
        {"rig.toml", "\"cam_0\"", "distortions (line 4)", "14 values", "thin prism", "airclay calibrate"});
  }

  writeEasyMocapFiles(folder, "dist_");
  std::string intri = readWhole(folder / "intri.yml", 1 << 20);
  const std::size_t key = intri.find("dist_02:"), data = intri.find("data: [", key);
  const std::size_t shape = intri.find("cols: ", key);
  ASSERT_LT(shape, data);
  intri.replace(data, intri.find(']', data) - data, "data: [" + zeros + ", 0.001, 0.");
  intri.replace(shape, 7, "cols: 14");
  folder.write("intri.yml", intri);
  const std::string line =
      "dist_02 (line " + std::to_string(1 + std::count(intri.begin(), intri.begin() + long(key), '\n')) + ")";
  expectMentions(messageOf([&] { readAnyRig(folder / "intri.yml", RigUnits::kAsWritten).validRig(); }),
                 {"intri.yml", "\"02\"", line.c_str(), "airclay calibrate"});
}

TEST(RigFormats, EmptyMetadataIsAccepted) {
  const TemporaryFolder folder;
  for (const std::string metadata : {"[metadata]\n", "metadata = {}\n"}) {
    const std::string text =
        metadata[0] == '[' ? tomlWith("0, 0, 0, 0") + metadata : metadata + tomlWith("0, 0, 0, 0");
    expectOnAxes(readRig(folder.write("rig.toml", text), RigUnits::kMetres));
    expectMentions(messageOf([&] { readRig(folder / "rig.toml"); }),
                   {"rig.toml", "units is missing", "--units"});
  }
  const std::string camera_array = "[cameras.0]\ncam_id = 0\nrotation = [" + std::string(kOnMinusX) + "]\n" +
                                   kCaliscopeLens + "[cameras.1]\ncam_id = 1\nrotation = [" + kOnY + "]\n" +
                                   kCaliscopeLens + "[metadata]\n";
  expectOnAxes(readRig(folder.write("camera_array.toml", camera_array)));
  writeEasyMocapFiles(folder, "dist_");
  for (const char* metadata : {"metadata:\n", "metadata: {}\n"}) {
    folder.write("intri.yml", readWhole(folder / "intri.yml", 1 << 20) + metadata);
    EXPECT_TRUE(readAnyRig(folder / "intri.yml", RigUnits::kAsWritten).errors.empty()) << metadata;
    writeEasyMocapFiles(folder, "dist_");
  }
  folder.write("rig.toml", tomlWith("0, 0, 0, 0") + "[metadata]\nunits = \"inch\"\n");
  expectMentions(messageOf([&] { readRig(folder / "rig.toml"); }), {"units (line 15)", "\"mm\""});
}

TEST(RigFormats, LoopOfSymbolicLinksIsAnError) {
  const TemporaryFolder folder;
  for (const char* name : {"rig.toml", "loop"}) {
    std::filesystem::create_symlink(name, folder / name);
    const std::string message = messageOf([&] { readAnyRig(folder / name, RigUnits::kMetres); });
    expectMentions(message, {name, "not a readable file"});
  }
  expectMentions(messageOf([&] { readAnyRig(folder.path(), RigUnits::kMetres); }),
                 {"rig.toml", "not a readable file"});
}

TEST(RigFormats, MissingSizeComesFromTheImages) {
  const TemporaryFolder folder;
  const Rig rig = ringRig(2, 64, 48);
  writeRig(folder / "rig.toml", rig);
  std::string text = readWhole(folder / "rig.toml", 1 << 20);
  for (int i = 0; i < 2; ++i) text.erase(text.find("size = [64, 48]\n"), 16);
  folder.write("rig.toml", text);
  const std::string message = messageOf([&] { readRig(folder / "rig.toml"); });
  EXPECT_NE(message.find("size is missing"), std::string::npos) << message;

  for (const Camera& camera : rig.cameras) {
    std::filesystem::create_directories(folder.path() / "silhouettes" / camera.name);
    const std::vector<std::uint8_t> rgba(std::size_t(64) * 48 * 4, 255);
    writePng(folder.path() / "silhouettes" / camera.name / "000000.png", {64, 48}, rgba);
  }
  const Take take(folder.path());
  EXPECT_EQ(take.rig().cameras[1].width, 64);
  EXPECT_EQ(take.rig().cameras[1].height, 48);
}

// --- our writer ---

/// A ring of cameras with every kind of lens, an upside-down one among them, and a workspace off the origin.
Rig variousRig() {
  Rig rig = ringRig(4, 640, 480);
  rig.workspace.center = Vec3(0.01, 1.0 / 3, -0.02);
  rig.workspace.edge_m = 0.45;
  rig.cameras[1].lens.distortion = {0.1, -0.2, 1e-5, -1e-4, 0.03, 0.15, -0.05, 1.0 / 3};
  rig.cameras[1].lens = withMonotonicRange(rig.cameras[1].lens);
  rig.cameras[2].camera_from_world.linear() =
      rotationFromVector({0, 0, std::numbers::pi}) * rig.cameras[2].camera_from_world.linear();
  rig.cameras[2].camera_from_world.translation() =
      rotationFromVector({0, 0, std::numbers::pi}) * rig.cameras[2].camera_from_world.translation();
  for (Camera& camera : rig.cameras)
    camera.camera_from_world.translation() -= camera.camera_from_world.linear() * rig.workspace.center;
  rig.cameras[3].lens.fy *= 1.003;
  return rig;
}

void expectSame(const Rig& a, const Rig& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  EXPECT_LE((a.workspace.center - b.workspace.center).norm(), 1e-12);
  EXPECT_NEAR(a.workspace.edge_m, b.workspace.edge_m, 1e-12);
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const Camera &one = a.cameras[i], &other = b.cameras[i];
    EXPECT_EQ(one.name, other.name);
    EXPECT_EQ(one.width, other.width);
    EXPECT_EQ(one.height, other.height);
    EXPECT_EQ(one.lens.model, other.lens.model);
    EXPECT_EQ(one.lens.distortion, other.lens.distortion);
    EXPECT_EQ(one.lens.fx, other.lens.fx);
    EXPECT_EQ(one.lens.fy, other.lens.fy);
    EXPECT_EQ(one.lens.cx, other.lens.cx);
    EXPECT_EQ(one.lens.cy, other.lens.cy);
    EXPECT_LE((one.camera_from_world.matrix() - other.camera_from_world.matrix()).norm(), 1e-9) << one.name;
  }
}

constexpr const char* kForms[] = {"airclay", "anipose", "caliscope", "pose2sim", "easymocap"};

/// Writes and reads back; a folder for EasyMocap.
Rig throughForm(const TemporaryFolder& folder, const std::string& form, const Rig& rig) {
  const std::filesystem::path out = folder / (form == "easymocap" ? form : form + ".toml");
  if (form == "easymocap") std::filesystem::create_directories(out);
  writeRigAs(*rigFormatNamed(form), out, rig);
  return readAnyRig(out, RigUnits::kAsWritten).validRig();
}

TEST(RigFormats, EveryFormatRoundTrips) {
  const TemporaryFolder folder;
  Rig rig = variousRig();
  for (const std::string form : kForms) {
    SCOPED_TRACE(form);
    expectSame(rig, throughForm(folder, form, rig));
  }
  rig.cameras[0].lens.model = LensModel::kFisheye;
  rig.cameras[0].lens.distortion = {-0.02, 0.003, 0.001, -0.0005, 0, 0, 0, 0};
  rig.cameras[0].lens = withMonotonicRange(rig.cameras[0].lens);
  rig.cameras[1].name = "metadata";  // the name of another table
  rig.cameras[2].name = "the \"left\" one.1";
  for (const std::string form : {"airclay", "anipose", "caliscope", "pose2sim"}) {
    SCOPED_TRACE(form);
    expectSame(rig, throughForm(folder, form, rig));
  }
  EXPECT_FALSE(rigFormatNamed("matlab"));
}

/// A table as the Python programs read it: the keys that they use must exist in the expected shape.
void expectCameraTable(const toml::table& table, const Camera& camera) {
  const toml::array* matrix = table["matrix"].as_array();
  ASSERT_TRUE(matrix && matrix->size() == 3 && matrix->get(0)->as_array()->size() == 3);
  EXPECT_EQ(matrix->get(1)->as_array()->get(2)->value<double>(), camera.lens.cy);
  for (const char* key : {"rotation", "translation"})
    ASSERT_TRUE(table[key].is_array() && table[key].as_array()->size() == 3) << key;
  cv::Vec3d turn;
  for (int i = 0; i < 3; ++i) turn[i] = *table["rotation"][std::size_t(i)].value<double>();
  cv::Mat turned;
  cv::Rodrigues(turn, turned);
  for (int i = 0; i < 9; ++i)
    EXPECT_NEAR(turned.at<double>(i / 3, i % 3), camera.camera_from_world.linear()(i / 3, i % 3), 1e-9);
  EXPECT_EQ(table["size"][0].value<double>(), camera.width);
  // Python's older TOML reader accepts no array that mixes integers and floats.
  EXPECT_TRUE(table["distortions"].as_array()->is_homogeneous<double>());
  for (const toml::node& row : *matrix) EXPECT_TRUE(row.as_array()->is_homogeneous<double>());
  EXPECT_TRUE(table["translation"].as_array()->is_homogeneous<double>());
}

TEST(RigFormats, AniposeAndPose2SimFindOnlyCameras) {
  const TemporaryFolder folder;
  const Rig rig = variousRig();
  for (const std::string form : {"anipose", "pose2sim"}) {
    SCOPED_TRACE(form);
    throughForm(folder, form, rig);
    const toml::table root = toml::parse_file((folder / (form + ".toml")).string());
    EXPECT_EQ(root.size(), rig.cameras.size() + 1);
    EXPECT_TRUE(root["metadata"]["error"].is_floating_point());
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
      const std::string key = form == "anipose" ? "cam_" + std::to_string(i) : rig.cameras[i].name;
      ASSERT_TRUE(root[key].is_table()) << key;
      expectCameraTable(*root[key].as_table(), rig.cameras[i]);
      EXPECT_EQ(root[key]["name"].value<std::string>(), rig.cameras[i].name);
      EXPECT_EQ(root[key]["size"][1].is_floating_point(), form == "pose2sim");
    }
  }
}

TEST(RigFormats, CaliscopeFindsNumberedCameras) {
  const TemporaryFolder folder;
  Rig rig = variousRig();
  for (const bool are_numbered : {false, true}) {
    for (std::size_t i = 0; are_numbered && i < 4; ++i)
      rig.cameras[i].name = "cam_" + std::to_string(9 - 2 * i);
    throughForm(folder, "caliscope", rig);
    const toml::table root = toml::parse_file((folder / "caliscope.toml").string());
    for (std::size_t i = 0; i < 4; ++i) {
      const int number = static_cast<int>(are_numbered ? 9 - 2 * i : i);
      const auto camera = root["cameras"][std::to_string(number)];
      ASSERT_TRUE(camera.is_table()) << number;
      EXPECT_EQ(camera["cam_id"].value<int>(), number);
      EXPECT_EQ(camera["fisheye"].value<bool>(), false);
      expectCameraTable(*camera.as_table(), rig.cameras[i]);
    }
    // Without numbers in their names, the videos must be renamed; and 8 coefficients are noted.
    EXPECT_EQ(rigFormatNotes(RigFormat::kCaliscope, rig).size(), are_numbered ? 1u : 5u);
  }
}

TEST(RigFormats, EasyMocapFindsItsKeys) {
  const TemporaryFolder folder;
  const Rig rig = variousRig();
  throughForm(folder, "easymocap", rig);
  const cv::FileStorage intri((folder.path() / "easymocap" / "intri.yml").string(), cv::FileStorage::READ);
  const cv::FileStorage extri((folder.path() / "easymocap" / "extri.yml").string(), cv::FileStorage::READ);
  ASSERT_EQ(intri["names"].size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const Camera& camera = rig.cameras[i];
    EXPECT_EQ(intri["names"][int(i)].string(), camera.name);
    EXPECT_EQ(int(intri["H_" + camera.name]), 480);
    cv::Mat k, dist, turn, turned, shift;
    intri["K_" + camera.name] >> k;
    intri["dist_" + camera.name] >> dist;
    extri["R_" + camera.name] >> turn;
    extri["T_" + camera.name] >> shift;
    cv::Rodrigues(turn, turned);
    ASSERT_EQ(shift.size(), cv::Size(1, 3));
    // A point's projection is the same with that program's conventions.
    std::vector<cv::Point2d> pixels;
    const Vec3 point = rig.workspace.center + Vec3(0.05, -0.04, 0.03);
    cv::projectPoints(std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}}, turn, shift, k, dist,
                      pixels);
    const std::optional<Vec2> ours = project(camera, point);
    ASSERT_TRUE(ours);
    EXPECT_LE((*ours - Vec2(pixels[0].x, pixels[0].y)).norm(), 1e-6) << camera.name;
  }
}

TEST(RigFormats, UnsupportedLensesAreRejectedOrNoted) {
  const TemporaryFolder folder;
  Rig rig = variousRig();
  rig.cameras[1].name = "left.front";
  EXPECT_NE(messageOf([&] { throughForm(folder, "easymocap", rig); }).find("left.front"), std::string::npos);
  rig.cameras[1].name = "left";
  rig.cameras[2].lens.model = LensModel::kFisheye;
  rig.cameras[2].lens.distortion = {};
  const std::string message = messageOf([&] { throughForm(folder, "easymocap", rig); });
  EXPECT_NE(message.find("fisheye"), std::string::npos) << message;
  ASSERT_EQ(rigFormatNotes(RigFormat::kPose2Sim, rig).size(), 1u);
  EXPECT_NE(rigFormatNotes(RigFormat::kPose2Sim, rig)[0].find("cam2"), std::string::npos);
  EXPECT_TRUE(rigFormatNotes(RigFormat::kAnipose, rig).empty());
}

TEST(RigFormats, ListsAllEasyMocapErrors) {
  const TemporaryFolder folder;
  writeEasyMocapFiles(folder, "dist_");
  std::string extri = readWhole(folder / "extri.yml", 1 << 20);
  extri.replace(extri.find("T_01"), 4, "X_01");
  extri.replace(extri.find("-1.000000"), 9, "-3.000000");
  folder.write("extri.yml", extri);
  const ParsedRig reading = readAnyRig(folder.path(), RigUnits::kAsWritten);
  ASSERT_EQ(reading.errors.size(), 2u);
  const std::string first = diagnosticMessage(reading.errors[0], reading.where);
  EXPECT_EQ(first.find((folder / "extri.yml").string() + ": T_01 is missing"), 0u) << first;
  EXPECT_EQ(reading.errors[1].camera, "02");
  EXPECT_NE(reading.errors[1].message.find("rotation"), std::string::npos);
}

}  // namespace
}  // namespace airclay
