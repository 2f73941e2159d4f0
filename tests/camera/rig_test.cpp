// SPDX-License-Identifier: MIT
// Lenses compared with OpenCV's projection and a dense scan; rig files, valid and
// invalid.
#include "engine/camera/rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <random>

#include "engine/core/error.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

struct NamedLens {
  const char* name;
  Lens lens;
};

Lens makeLens(LensModel model, const std::array<double, 8>& distortion, double focal = 560) {
  Lens lens;
  lens.model = model;
  lens.fx = focal, lens.fy = focal * 1.01, lens.cx = 321.3, lens.cy = 236.9;
  lens.distortion = distortion;
  return withMonotonicRange(lens);
}

/// Every model and number of coefficients; mild, strong, and with a range that ends inside or near the
/// image.
std::vector<NamedLens> lenses() {
  const LensModel plain = LensModel::kPerspective, fish = LensModel::kFisheye;
  return {{"none", makeLens(plain, {})},
          {"four", makeLens(plain, {-0.12, 0.06, 1e-3, -5e-4})},
          {"five", makeLens(plain, {-0.338, 0.0967, -1.35e-3, 3.16e-3, -3.7e-3})},
          {"five, positive", makeLens(plain, {0.192, -0.256, 2.8e-3, -5.2e-3, 0.115})},
          {"barrel that turns", makeLens(plain, {-0.6, 0.05, 2e-3, 1e-3, 0}, 300)},
          {"eight", makeLens(plain, {0.4, 0.05, 8e-4, -3e-4, 0.03, 0.6, 0.02, 0.01})},
          {"eight with a pole", makeLens(plain, {0.1, 0, 0, 0, 0, -0.4, 0, 0}, 300)},
          {"fisheye", makeLens(fish, {-0.03, 0.012, -0.008, 0.0015}, 230)},
          {"fisheye that turns", makeLens(fish, {-0.2, 0.01, -0.01, 0}, 230)}};
}

Vec2 projectByOpenCv(const Lens& lens, const Vec3& point) {
  const cv::Matx33d matrix(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  const std::vector<cv::Point3d> points{{point.x(), point.y(), point.z()}};
  const std::vector<double> none(3, 0.0);
  std::vector<cv::Point2d> pixels;
  if (lens.model == LensModel::kFisheye) {
    const std::vector<double> k(lens.distortion.begin(), lens.distortion.begin() + 4);
    cv::fisheye::projectPoints(points, pixels, none, none, matrix, k);
  } else {
    const std::vector<double> k(lens.distortion.begin(), lens.distortion.end());
    cv::projectPoints(points, none, none, matrix, k, pixels);
  }
  return {pixels[0].x, pixels[0].y};
}

/// A point at `angle` from the axis, rotated by `turn` about it.
Vec3 pointAt(double angle, double turn, double distance) {
  return distance * Vec3(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle));
}

double limitAngle(const Lens& lens) {
  return lens.model == LensModel::kFisheye ? lens.monotonic_limit : std::atan(lens.monotonic_limit);
}

TEST(Lens, ProjectionEqualsOpenCv) {
  for (const auto& [name, lens] : lenses()) {
    int compared = 0;
    for (double angle = 0; angle < std::min(limitAngle(lens), 1.2); angle += 0.01)
      for (double turn = 0; turn < 6.28; turn += 0.37) {
        const Vec3 point = pointAt(angle, turn, 0.8);
        const std::optional<Vec2> ours = projectThroughLens(lens, point);
        ASSERT_TRUE(ours) << name;
        const Vec2 theirs = projectByOpenCv(lens, point);
        // 1e-9 px within the image; far outside, with a wide lens, the error is relative to the
        // distance.
        ASSERT_LE((*ours - theirs).norm(), 1e-9 * std::max(1.0, theirs.norm() / 1000))
            << name << " at " << angle;
        ++compared;
      }
    EXPECT_GT(compared, 500) << name;
  }
}

/// The end of the range by walking along the curve: where the distorted radius first decreases, or jumps at a
/// pole.
double scannedLimit(const Lens& lens, double end, double step) {
  Lens radial = lens;  // only the radial part, read off the x axis
  if (lens.model == LensModel::kPerspective) radial.distortion[2] = radial.distortion[3] = 0;
  radial.monotonic_limit = std::numeric_limits<double>::infinity();
  double before = 0;
  for (double at = step; at < end; at += step) {
    const double x = lens.model == LensModel::kFisheye ? std::tan(at) : at;
    const double bent = (projectByOpenCv(radial, {x, 0, 1}).x() - lens.cx) / lens.fx;
    if (bent < before) return at;
    before = bent;
  }
  return end;
}

TEST(Lens, MonotonicRangeEqualsADenseScan) {
  const double step = 1e-4;
  int finite = 0;
  for (const auto& [name, lens] : lenses()) {
    const double end = lens.model == LensModel::kFisheye ? std::numbers::pi / 2 : 6.0;
    const double scanned = scannedLimit(lens, end, step);
    if (scanned == end) {
      EXPECT_GE(lens.monotonic_limit, end - 1e-12) << name;
      continue;
    }
    // The scan detects the maximum within two steps; near a flat maximum it is no finer.
    EXPECT_NEAR(lens.monotonic_limit, scanned, 2 * step) << name;
    ++finite;
  }
  EXPECT_GE(finite, 4);
}

TEST(Lens, MonotonicRangeOfRandomCoefficients) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-0.6, 0.6);
  int turning = 0;
  for (int i = 0; i < 60; ++i) {
    std::array<double, 8> k{};
    for (double& value : k) value = any(random);
    const Lens lens = makeLens(i % 2 ? LensModel::kFisheye : LensModel::kPerspective, k);
    const double end = i % 2 ? std::numbers::pi / 2 : 3.0, step = 1e-3;
    const double scanned = scannedLimit(lens, end, step);
    if (scanned < end) ++turning;
    if (scanned < end) {
      EXPECT_NEAR(lens.monotonic_limit, scanned, 2 * step) << i;
    } else {
      EXPECT_GE(lens.monotonic_limit, end - step) << i;
    }
  }
  EXPECT_GT(turning, 20);
}

TEST(Lens, ProjectsNothingBehindOrBeyondItsRange) {
  const Lens barrel = makeLens(LensModel::kPerspective, {-0.6, 0.05, 2e-3, 1e-3, 0}, 300);
  const double limit = barrel.monotonic_limit;
  EXPECT_TRUE(projectThroughLens(barrel, {0.999 * limit, 0, 1}));
  EXPECT_FALSE(projectThroughLens(barrel, {1.001 * limit, 0, 1}));
  for (const auto& [name, lens] : lenses()) {
    EXPECT_FALSE(projectThroughLens(lens, {0, 0, -1})) << name;
    EXPECT_FALSE(projectThroughLens(lens, {0.1, 0, 0})) << name;
    EXPECT_FALSE(projectThroughLens(lens, {0, 0, std::nan("")})) << name;
  }
}

TEST(Lens, RayThroughPixelInvertsProjection) {
  for (const auto& [name, lens] : lenses()) {
    // Up to 0.5% before the end of the range, where the curve is flat and its inverse loses all digits.
    const double end = std::min(0.995 * limitAngle(lens), 1.3);
    for (double angle = 0; angle < end; angle += 0.013)
      for (double turn = 0; turn < 6.28; turn += 0.41) {
        const Vec3 direction = pointAt(angle, turn, 1);
        const std::optional<Vec2> pixel = projectThroughLens(lens, direction);
        ASSERT_TRUE(pixel) << name;
        const std::optional<Vec3> ray = rayThroughPixel(lens, *pixel);
        const bool near_end = lens.distortion[2] != 0 && angle > 0.95 * limitAngle(lens);
        if (near_end && !ray) continue;  // tangential terms may fold over at the edge
        ASSERT_TRUE(ray) << name << " at " << angle << ", " << turn;
        EXPECT_NEAR(ray->norm(), 1, 1e-14);
        EXPECT_LE((*projectThroughLens(lens, *ray) - *pixel).norm(), 1e-7) << name << " at " << angle;
        if (near_end) continue;
        EXPECT_LE((*ray - direction).norm(), 1e-10) << name << " at " << angle << ", " << turn;
      }
  }
}

TEST(Lens, NoRayForUnreachablePixels) {
  const Lens barrel = makeLens(LensModel::kPerspective, {-0.6, 0.05, 0, 0, 0}, 300);
  const double reach =
      projectThroughLens(barrel, {barrel.monotonic_limit * (1 - 1e-9), 0, 1})->x() - barrel.cx;
  EXPECT_TRUE(rayThroughPixel(barrel, {barrel.cx + 0.999 * reach, barrel.cy}));
  EXPECT_FALSE(rayThroughPixel(barrel, {barrel.cx + 1.001 * reach, barrel.cy}));
  const Lens fisheye = makeLens(LensModel::kFisheye, {-0.03, 0.012, -0.008, 0.0015}, 230);
  EXPECT_FALSE(rayThroughPixel(fisheye, {fisheye.cx + 3 * fisheye.fx, fisheye.cy}));
}

TEST(Camera, ImageExtendsHalfAPixelBeyondPixelCentres) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.lens.fx = camera.lens.fy = 512, camera.lens.cx = 320, camera.lens.cy = 240;
  camera.lens = withMonotonicRange(camera.lens);
  const auto at = [](double u, double v) { return Vec3((u - 320) / 512, (v - 240) / 512, 1); };
  EXPECT_TRUE(project(camera, at(-0.5, -0.5)));
  EXPECT_FALSE(project(camera, at(-0.5 - 1e-9, 0)));
  EXPECT_FALSE(project(camera, at(0, -0.5 - 1e-9)));
  EXPECT_TRUE(project(camera, at(639.5 - 1e-9, 479.5 - 1e-9)));
  EXPECT_FALSE(project(camera, at(639.5, 0)));
  EXPECT_FALSE(project(camera, at(0, 479.5)));
  camera.camera_from_world.linear() = rotationFromVector({0, std::numbers::pi / 2, 0});
  camera.camera_from_world.translation() = Vec3(0, 0, 2);
  // The world's -x axis points forward: camera z = 2 - x.
  const std::optional<Vec2> pixel = project(camera, {-2, 0.5, 1});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 320 + 512 * 1.0 / 4, 1e-9);
  EXPECT_NEAR(pixel->y(), 240 + 512 * 0.5 / 4, 1e-9);
}

// Two cameras, on the x and the y axis, 1.2 m from the centre, upright.
const char kRig[] = R"([cam_0]
name = "left"
size = [640, 480]
matrix = [[560.0, 0, 319.5], [0, 561.0, 239.5], [0, 0, 1]]
distortions = [-0.1, 0.03, 0.001, -0.002, 0.004]
rotation = [1.2091995761561452, -1.2091995761561452, 1.2091995761561452]
translation = [0.0, 0.0, 1.2]

[cam_1]
name = "right"
size = [800, 600]
matrix = [[500, 0, 400], [0, 500, 300], [0, 0, 1]]
distortions = [-0.02, 0.003, 0.001, -0.0005]
fisheye = true
rotation = [[-1, 0, 0], [0, 0, -1], [0, -1, 0]]
translation = [0, 0, 1.2]

[workspace]
center = [0.01, 0.02, 0.03]
edge = 0.5

[metadata]
units = "m"
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the test's rig has no " + from);
  return text.replace(at, from.size(), to);
}

TEST(RigFile, ReadsWrittenValues) {
  const TemporaryFolder folder;
  const Rig rig = readRig(folder.write("rig.toml", kRig));
  ASSERT_EQ(rig.cameras.size(), 2u);
  const Camera &left = rig.cameras[0], &right = rig.cameras[1];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.width, 640);
  EXPECT_EQ(left.height, 480);
  EXPECT_EQ(left.lens.fy, 561.0);
  EXPECT_EQ(left.lens.model, LensModel::kPerspective);
  EXPECT_EQ(left.lens.distortion, (std::array<double, 8>{-0.1, 0.03, 0.001, -0.002, 0.004, 0, 0, 0}));
  // 120 degrees about (1, -1, 1) map x to -y, y to -z, z to x.
  Mat3 expected;
  expected << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const bool is_it = left.camera_from_world.linear().isApprox(expected, 1e-12) ||
                     left.camera_from_world.linear().isApprox(expected.transpose(), 1e-12);
  EXPECT_TRUE(is_it) << left.camera_from_world.linear();
  EXPECT_EQ(right.lens.model, LensModel::kFisheye);
  EXPECT_TRUE(right.camera_from_world.inverse().translation().isApprox(Vec3(0, 1.2, 0), 1e-12));
  EXPECT_EQ(rig.workspace.edge_m, 0.5);
  EXPECT_EQ(rig.workspace.center, Vec3(0.01, 0.02, 0.03));
}

TEST(RigFile, RodriguesEqualsOpenCv) {
  const TemporaryFolder folder;
  const Rig rig = readRig(folder.write("rig.toml", kRig));
  cv::Mat matrix;
  const double a = 1.2091995761561452;
  cv::Rodrigues(std::vector<double>{a, -a, a}, matrix);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(rig.cameras[0].camera_from_world.linear()(r, c), matrix.at<double>(r, c), 1e-14);
}

TEST(RigFile, UnitsScaleOnlyTranslations) {
  const TemporaryFolder folder;
  std::string text = replaced(kRig, "translation = [0.0, 0.0, 1.2]", "translation = [0.0, 0.0, 1200.0]");
  text = replaced(text, "translation = [0, 0, 1.2]", "translation = [0, 0, 1200]");
  const Rig written = readRig(folder.write("mm.toml", replaced(text, "\"m\"", "\"mm\"")));
  EXPECT_NEAR(written.cameras[0].camera_from_world.translation().z(), 1.2, 1e-12);
  EXPECT_EQ(written.workspace.edge_m, 0.5);

  const std::string bare = replaced(text, "[metadata]\nunits = \"m\"\n", "");
  const std::filesystem::path file = folder.write("bare.toml", bare);
  EXPECT_NE(messageOf([&] { readRig(file); }).find("units"), std::string::npos);
  EXPECT_NEAR(readRig(file, RigUnits::kMillimetres).cameras[1].camera_from_world.translation().z(), 1.2,
              1e-12);
}

TEST(RigFile, AcceptsFilesPathsAndNumbersAsNames) {
  const TemporaryFolder folder;
  const auto nameOf = [&](const std::string& written) {
    return readRig(folder.write("rig.toml", replaced(kRig, "\"left\"", written))).cameras[0].name;
  };
  EXPECT_EQ(nameOf("\"cam0.mp4\""), "cam0");
  EXPECT_EQ(nameOf("\"CAM0.MOV\""), "CAM0");
  EXPECT_EQ(nameOf("\"/data/my takes/cam0.avi\""), "cam0");
  EXPECT_EQ(nameOf("'C:\\takes\\cam0.avi'"), "cam0");
  EXPECT_EQ(nameOf("\"left.front\""), "left.front");
  EXPECT_EQ(nameOf("0"), "0");
}

TEST(RigFile, RejectsDuplicateNameWithItsLine) {
  const TemporaryFolder folder;
  const std::string fault = messageOf(
      [&] { readRig(folder.write("rig.toml", replaced(kRig, "name = \"right\"", "name = \"left.mp4\""))); });
  for (const char* part : {"[cam_1] name (line 10)", "\"left\"", "line 2"})
    EXPECT_NE(fault.find(part), std::string::npos) << fault;
}

TEST(RigFile, ReadsWindowsFiles) {
  const TemporaryFolder folder;
  std::string text = "\xef\xbb\xbf";
  for (const char c : std::string(kRig)) text += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_EQ(readRig(folder.write("rig.toml", text)).cameras.size(), 2u);
}

TEST(RigFile, CamerasKeepFileOrder) {
  const TemporaryFolder folder;
  const std::string text = replaced(replaced(kRig, "[cam_0]\nname = \"left\"", "[cam_2]"),
                                    "[cam_1]\nname = \"right\"", "[cam_10]");
  const Rig rig = readRig(folder.write("rig.toml", text));
  EXPECT_EQ(rig.cameras[0].name, "cam_2");  // the table's name replaces a missing one
  EXPECT_EQ(rig.cameras[1].name, "cam_10");
}

TEST(RigFile, ReadsCaliscopeCameraArray) {
  const TemporaryFolder folder;
  const std::string camera =
      "size = [640, 480]\nmatrix = [[560, 0, 319.5], [0, 560, 239.5], [0, 0, 1]]\n"
      "distortions = [0, 0, 0, 0, 0]\ntranslation = [0, 0, 1.2]\n";
  const Rig rig = readRig(
      folder.write("camera_array.toml", "[cameras.5]\ncam_id = 5\nignore = false\n" + camera +
                                            "rotation = [[-1, 0, 0], [0, 0, -1], [0, -1, 0]]\n"
                                            "[cameras.7]\ncam_id = 7\nignore = true\nsize = [1, 1]\n"
                                            "[cameras.8]\ncam_id = 8\nsize = [640, 480]\n"
                                            "[cameras.12]\ncam_id = 12\n" +
                                            camera + "rotation = [[0, 1, 0], [0, 0, -1], [-1, 0, 0]]\n"));
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.cameras[0].name, "cam_5");
  EXPECT_EQ(rig.cameras[1].name, "cam_12");
  EXPECT_TRUE(rig.cameras[1].camera_from_world.inverse().translation().isApprox(Vec3(1.2, 0, 0), 1e-12));
  EXPECT_EQ(rig.workspace.edge_m, 0.6);
}

TEST(RigFile, RoundTripIsExact) {
  const TemporaryFolder folder;
  Rig rig = readRig(folder.write("rig.toml", kRig));
  rig.cameras[0].name = "a \"quoted\" name";
  rig.cameras[0].lens.distortion = {0.1, -0.2, 1e-5, -1e-4, 0.03, 0.15, -0.05, 1.0 / 3};
  const std::filesystem::path file = folder / "again.toml";
  writeRig(file, rig);
  const Rig again = readRig(file);
  ASSERT_EQ(again.cameras.size(), rig.cameras.size());
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera &a = rig.cameras[i], &b = again.cameras[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.lens.model, b.lens.model);
    EXPECT_EQ(a.lens.distortion, b.lens.distortion);
    EXPECT_EQ(a.lens.fx, b.lens.fx);
    EXPECT_EQ(a.lens.cy, b.lens.cy);
    EXPECT_LE((a.camera_from_world.matrix() - b.camera_from_world.matrix()).norm(), 1e-14);
  }
  EXPECT_EQ(again.workspace.center, rig.workspace.center);
  EXPECT_EQ(again.workspace.edge_m, rig.workspace.edge_m);
}

TEST(RigFile, RoundedMatrixBecomesARotation) {
  const TemporaryFolder folder;
  const std::string few = replaced(kRig, "[[-1, 0, 0], [0, 0, -1], [0, -1, 0]]",
                                   "[[-0.9998, 0.0174, 0], [0, 0, -1], [-0.0174, -0.9998, 0]]");
  const Mat3 turn = readRig(folder.write("rig.toml", few)).cameras[1].camera_from_world.linear();
  EXPECT_LE((turn * turn.transpose() - Mat3::Identity()).norm(), 1e-14);
  EXPECT_NEAR(turn(0, 1), 0.0174, 1e-3);
}

struct BadRig {
  const char *from, *to;              // replacement in kRig
  std::vector<const char*> mentions;  // required in the message besides the file
};

TEST(RigFile, RejectsMalformedAndImplausibleRigs) {
  const std::vector<BadRig> cases{
      {"560.0", "nan", {"cam_0", "matrix"}},
      {"560.0", "-560.0", {"left", "matrix"}},
      {"560.0, 0,", "560.0, 3,", {"left", "matrix", "skew"}},
      {", [0, 0, 1]]", "]", {"cam_0", "matrix"}},
      {"matrix = [[560", "intrinsics = [[560", {"cam_0", "matrix", "missing"}},
      {"-0.1, 0.03", "inf, 0.03", {"cam_0", "distortions"}},
      {"0.03, 0.001, -0.002, 0.004]", "0.03, 0.001]", {"left", "distortions", "3 values"}},
      {"0.001, -0.0005]", "0.001, -0.0005, 0]", {"right", "distortions", "5 values", "fisheye"}},
      {"fisheye = true", "fisheye = 1", {"cam_1", "fisheye"}},
      {"[[-1, 0, 0], [0, 0, -1], [0, -1, 0]]", "[[1, 0, 0], [0, 0, -1], [0, -1, 0]]", {"right", "rotation"}},
      {"[[-1, 0, 0], [0, 0, -1], [0, -1, 0]]",
       "[[-1.01, 0, 0], [0, 0, -1], [0, -1, 0]]",
       {"right", "rotation"}},
      {"[[-1, 0, 0], [0, 0, -1], [0, -1, 0]]", "[[-1, 0, 0], [0, 0, -1]]", {"right", "rotation", "6 values"}},
      {"[0.0, 0.0, 1.2]", "[0.0, nan, 1.2]", {"cam_0", "translation"}},
      {"[0.0, 0.0, 1.2]", "[0.0, 1.2]", {"cam_0", "translation"}},
      {"[0.0, 0.0, 1.2]", "[0.0, \"x\", 1.2]", {"cam_0", "translation", "line 7"}},
      {"[0.0, 0.0, 1.2]", "[0.0, 0.0, 0.2]", {"left", "inside"}},
      {"[0.0, 0.0, 1.2]", "[0.0, 0.0, -1.2]", {"left", "nothing"}},
      {"[0.0, 0.0, 1.2]", "[0.0, 0.0, 1200]", {"left", "1,000 edges"}},
      {"[640, 480]", "[640, 15]", {"cam_0", "size"}},
      {"[640, 480]", "[640, 16385]", {"cam_0", "size"}},
      {"[640, 480]", "[640.5, 480]", {"cam_0", "size"}},
      {"[640, 480]", "[640]", {"cam_0", "size"}},
      {"[640, 480]", "[6400000000000000000, 480]", {"cam_0", "size"}},
      {"\"right\"", "\"left\"", {"left", "two cameras"}},
      {"\"right\"", "\"../right\"", {"right", "name"}},
      {"\"right\"", "true", {"cam_1", "name"}},
      {"edge = 0.5", "edge = 0", {"workspace", "edge"}},
      {"[0.01, 0.02, 0.03]", "[0.01, 0.02, inf]", {"workspace", "center"}},
      {"units = \"m\"", "units = \"cm\"", {"units"}},
      {"units = \"m\"", "", {"units"}},
      {"[cam_1]", "[cam_1", {":9:"}},
      {"[cam_1]", "[cam_1]\nignore = true", {"1 camera"}},
  };
  const TemporaryFolder folder;
  for (const BadRig& bad : cases) {
    const std::filesystem::path file = folder.write("rig.toml", replaced(kRig, bad.from, bad.to));
    const std::string message = messageOf([&] { readRig(file); });
    EXPECT_EQ(message.find(file.string()), 0u) << bad.to << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const char* mention : bad.mentions)
      EXPECT_NE(message.find(mention), std::string::npos) << bad.to << ": " << message;
  }
  EXPECT_NE(messageOf([&] { readRig(folder / "none.toml"); }).find("none.toml"), std::string::npos);
  EXPECT_NE(messageOf([&] { readRig(folder.write("empty.toml", "")); }).find("no camera"), std::string::npos);
}

TEST(RigFile, RejectsTooManyAndCoincidentCameras) {
  const TemporaryFolder folder;
  const Rig rig = readRig(folder.write("rig.toml", kRig));
  const auto faultOf = [&](const Rig& changed) { return messageOf([&] { checkRig(changed, "a.toml"); }); };
  EXPECT_EQ(faultOf(rig), "");
  Rig close = rig;
  close.cameras.push_back(rig.cameras[0]);
  close.cameras[2].name = "third";
  close.cameras[2].camera_from_world.translation() += Vec3(0.0049, 0, 0);  // edge / 100 is 5 mm
  EXPECT_NE(faultOf(close).find("third"), std::string::npos) << faultOf(close);
  close.cameras[2].camera_from_world.translation() += Vec3(0.0002, 0, 0);
  EXPECT_EQ(faultOf(close), "");
  Rig many = rig;
  for (int i = 2; i <= kMaxCameras; ++i) {
    many.cameras.push_back(rig.cameras[0]);
    many.cameras.back().name = std::to_string(i);
    many.cameras.back().camera_from_world.translation() += Vec3(0.006 * i, 0, 0);
  }
  EXPECT_NE(faultOf(many).find("33 cameras"), std::string::npos) << faultOf(many);
  many.cameras.pop_back();
  EXPECT_EQ(faultOf(many), "");
}

}  // namespace
}  // namespace airclay
