// SPDX-License-Identifier: MIT
// Rig diagnostics: a good rig has no findings; each modification is found and named.
#include "engine/camera/rig_diagnostics.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <numbers>

#include "capture/images/image_file.h"
#include "capture/takes/take_inspection.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Rig goodRig() {
  return ringRig(4, 640, 480);
}

std::string shown(const std::vector<RigDiagnostic>& findings) {
  std::string text;
  for (const RigDiagnostic& finding : findings) text += diagnosticMessage(finding, "rig") + "\n";
  return text;
}

/// Rotates and moves a camera's frame: camera_from_world becomes turn * camera_from_world * world.
void change(Camera& camera, const Mat3& turn, const Mat3& world = Mat3::Identity()) {
  camera.camera_from_world.linear() = turn * camera.camera_from_world.linear() * world;
  camera.camera_from_world.translation() = turn * camera.camera_from_world.translation();
}

Mat3 axes(double x, double y, double z) {
  return Vec3(x, y, z).asDiagonal();
}

TEST(RigFaults, ListsAllAndThrowsTheFirst) {
  Rig rig = goodRig();
  EXPECT_EQ(shown(rigErrors(rig)), "");
  rig.cameras[0].name = "a/b";
  rig.cameras[0].width = 8;
  rig.cameras[1].lens.fx = -3;
  rig.cameras[1].camera_from_world.translation().x() = kNaN;
  rig.cameras[2].name = "cam3";
  rig.cameras[3].camera_from_world.translation() = Vec3(0, 0, 0.1);
  const std::vector<RigDiagnostic> faults = rigErrors(rig);
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"a/b", "name"},         {"a/b", "size is 8 x 480"}, {"cam1", "focal lengths"},
      {"cam1", "translation"}, {"", "two cameras"},        {"cam3", "inside"}};
  ASSERT_EQ(faults.size(), expected.size()) << shown(faults);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(faults[i].camera, expected[i].first) << i;
    EXPECT_NE(faults[i].message.find(expected[i].second), std::string::npos) << faults[i].message;
    EXPECT_EQ(faults[i].severity, Severity::kError);
  }
  EXPECT_EQ(messageOf([&] { checkRig(rig, "rig"); }), diagnosticMessage(faults[0], "rig"));
  EXPECT_FALSE(isMeasurable(rig));
  EXPECT_TRUE(isMeasurable(goodRig()));
}

TEST(RigFaults, ListsAllOfAFile) {
  const TemporaryFolder folder;
  const std::string good =
      "matrix = [[560, 0, 320], [0, 560, 240], [0, 0, 1]]\ndistortions = [0, 0, 0, 0]\n"
      "rotation = [0, 0, 0]\n";
  const std::filesystem::path file = folder.write(
      "rig.toml",
      "[one]\n" + good + "translation = [0, 0, 1]\n[two]\n" + good + "translation = [0, 1]\n" +
          "[three]\nmatrix = [[560, 3, 320], [0, 560, 240], [0, 0, 1]]\ndistortions = [0, 0, 0, 0]\n"
          "rotation = [0, 0, 0]\ntranslation = [0, 0, 1]\n[workspace]\nedge = -1\n");
  const ParsedRig reading = parseRig(file);
  EXPECT_EQ(reading.rig.cameras.size(), 1u);
  ASSERT_EQ(reading.errors.size(), 4u) << shown(reading.errors);
  EXPECT_NE(reading.errors[0].message.find("units"), std::string::npos);
  EXPECT_EQ(diagnosticMessage(reading.errors[1], reading.where).find(file.string() + ": [two] translation"),
            0u);
  EXPECT_EQ(reading.errors[2].camera, "three");
  EXPECT_NE(reading.errors[3].message.find("edge"), std::string::npos);
  EXPECT_EQ(messageOf([&] { readRig(file); }), diagnosticMessage(reading.errors[0], file.string()));
}

struct Defect {
  const char* name;
  std::function<void(Rig&)> apply;
  std::vector<std::string>
      expected;  ///< text of one finding, with the camera's name if it concerns one camera
};

TEST(RigSuspicions, NameTheLikelyCause) {
  EXPECT_EQ(shown(rigWarnings(goodRig())), "");
  const auto each = [](const std::function<void(Camera&)>& apply) {
    return [apply](Rig& rig) { std::for_each(rig.cameras.begin(), rig.cameras.end(), apply); };
  };
  const auto scaled = [&](double factor) {
    return each([factor](Camera& camera) { camera.camera_from_world.translation() *= factor; });
  };
  const std::vector<Defect> defects = {
      {"millimetres", scaled(1000), {"millimetres"}},
      {"centimetres", scaled(100), {"centimetres"}},
      {"metres taken for mm", scaled(1e-3), {"probably in metres"}},
      {"inverse",
       each([](Camera& c) { c.camera_from_world = c.camera_from_world.inverse(); }),
       {"if the poses are world_from_camera;"}},
      {"OpenGL", each([](Camera& c) { change(c, axes(1, -1, -1)); }), {"if the poses are those of OpenGL"}},
      {"Blender",
       each([](Camera& c) {
         change(c, axes(1, -1, -1));
         c.camera_from_world = c.camera_from_world.inverse();
       }),
       {"if the poses are world_from_camera of OpenGL"}},
      {"z down", each([](Camera& c) { change(c, Mat3::Identity(), axes(1, -1, -1)); }), {"z points down"}},
      {"world upside down and mirrored cameras",
       each([](Camera& c) { change(c, axes(-1, -1, 1)); }),
       {"upside down on average"}},
      {"principal point", [](Rig& rig) { rig.cameras[2].lens.cx += 150; }, {"cam2", "principal point"}},
      {"sides exchanged",
       [](Rig& rig) { std::swap(rig.cameras[1].width, rig.cameras[1].height); },
       {"cam1", "width and height swapped"}},
      {"matrix of an image half as large",
       [](Rig& rig) {
         Lens& lens = rig.cameras[1].lens;
         for (double* value : {&lens.fx, &lens.fy, &lens.cx, &lens.cy}) *value *= 0.5;
       },
       {"cam1", "0.5 times as large"}},
      {"focal lengths", [](Rig& rig) { rig.cameras[3].lens.fy *= 1.05; }, {"cam3", "focal lengths differ"}},
      {"lens that ends",
       [](Rig& rig) {
         rig.cameras[0].lens.distortion = {-0.9, 0, 0, 0, 0, 0, 0, 0};
         rig.cameras[0].lens = withMonotonicRange(rig.cameras[0].lens);
       },
       {"cam0", "ends inside the image"}},
      {"cube elsewhere",
       [](Rig& rig) { rig.workspace.center = Vec3(0, 0, -0.9); },
       {"intersect near 0,0,0;"}},
      {"telephoto lenses",
       each([](Camera& c) { c.lens.fx *= 4, c.lens.fy *= 4; }),
       {"of the cube is seen by two"}},
      {"far away", scaled(8), {"mm at the cube's centre"}},
  };
  for (const Defect& defect : defects) {
    Rig rig = goodRig();
    defect.apply(rig);
    const std::vector<RigDiagnostic> findings = rigWarnings(rig);
    const bool is_found = std::any_of(findings.begin(), findings.end(), [&](const RigDiagnostic& finding) {
      const std::string line = diagnosticMessage(finding, "rig");
      return std::all_of(defect.expected.begin(), defect.expected.end(),
                         [&](const std::string& text) { return line.find(text) != std::string::npos; });
    });
    EXPECT_TRUE(is_found) << defect.name << ": " << shown(findings);
    for (const RigDiagnostic& finding : findings) {
      EXPECT_EQ(finding.severity, Severity::kWarning);
      EXPECT_EQ(finding.message.find('\n'), std::string::npos);
    }
  }
}

TEST(RigSuspicions, NameTheUpAxis) {
  // The axis of the changed world that was z, by the axis that becomes z.
  const std::pair<const char*, const char*> cases[] = {
      {"y", "-y"}, {"-y", "y"}, {"x", "-x"}, {"-x", "x"}, {"-z", "-z"}};
  Rig good = goodRig();
  good.workspace.center = Vec3(0.02, -0.03, 0.01);
  for (const auto& [to_z, was_z] : cases) {
    const Rig rig = withUpAxis(good, *axisNamed(to_z));
    const std::string findings = shown(rigWarnings(rig));
    EXPECT_NE(findings.find(std::string("`airclay rig convert --up=") + was_z + "`"), std::string::npos)
        << to_z << ": " << findings;
    EXPECT_EQ(findings.find("y-down") != std::string::npos, was_z == std::string("-y")) << findings;
    const Rig converted = withUpAxis(rig, *axisNamed(was_z));
    EXPECT_EQ(shown(rigWarnings(converted)), "");
    EXPECT_LE((converted.workspace.center.z() - good.workspace.center.z()), 1e-12);
  }
  EXPECT_FALSE(axisNamed("w"));
  EXPECT_FALSE(axisNamed(""));
}

TEST(RigSuspicions, AllowCamerasThatLookStraightDown) {
  Rig rig = goodRig();
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    Camera& camera = rig.cameras[i];
    camera.camera_from_world.linear() = axes(1, -1, -1);  // upright along y
    const Vec3 eye(0.3 * static_cast<double>(i % 2) - 0.15, 0.3 * static_cast<double>(i / 2) - 0.15, 1.2);
    camera.camera_from_world.translation() = camera.camera_from_world.linear() * -eye;
  }
  EXPECT_EQ(shown(rigWarnings(rig)).find("--up"), std::string::npos) << shown(rigWarnings(rig));
}

TEST(RigSuspicions, ReportAdjacentCameras) {
  Rig rig = ringRig(2, 640, 480);
  rig.cameras[1] = rig.cameras[0];
  rig.cameras[1].name = "beside";
  rig.cameras[1].camera_from_world.translation().x() += 0.1;  // 5 degrees at 1.06 m
  EXPECT_NE(shown(rigWarnings(rig)).find("leaves depth uncertain"), std::string::npos);
  rig.cameras[1].camera_from_world.translation().x() += 0.2;  // 16 degrees
  EXPECT_EQ(shown(rigWarnings(rig)).find("leaves depth uncertain"), std::string::npos);
}

TEST(RigMetrics, EqualKnownValues) {
  // Two cameras 10 m away on the x and the y axis; the second one sees only half of the workspace.
  Rig rig;
  for (int i = 0; i < 2; ++i) {
    Camera camera;
    camera.name = i ? "half" : "whole";
    camera.width = 1000, camera.height = 800;
    camera.lens.fx = camera.lens.fy = 10000, camera.lens.cx = 499.5, camera.lens.cy = 399.5;
    if (i) camera.lens.cx = -0.5;  // its axis is the image's left border
    camera.lens = withMonotonicRange(camera.lens);
    Mat3 turn;
    if (i)
      turn << -1, 0, 0, 0, 0, -1, 0, -1, 0;
    else
      turn << 0, 1, 0, 0, 0, -1, -1, 0, 0;
    camera.camera_from_world.linear() = turn;
    camera.camera_from_world.translation() = Vec3(0, 0, 10);
    rig.cameras.push_back(camera);
  }
  const RigMetrics figures = measureRig(rig);
  for (const CameraMetrics& camera : figures.cameras) {
    EXPECT_NEAR(camera.distance_m, 10, 1e-9);
    EXPECT_NEAR(camera.pixels_per_mm, 1, 1e-9);
  }
  EXPECT_NEAR(figures.cameras[0].view_deg, 2 * std::atan(0.05) * 180 / std::numbers::pi, 1e-9);
  EXPECT_NEAR(figures.cameras[1].view_deg, std::atan(0.1) * 180 / std::numbers::pi, 1e-9);
  EXPECT_EQ(figures.cameras[0].seen_fraction, 1);
  EXPECT_NEAR(figures.cameras[1].seen_fraction, 0.5, 1e-9);
  EXPECT_NEAR(figures.seen_by_two_fraction, 0.5, 1e-9);
}

TEST(RigMetrics, AxesMeetWhereTheCamerasLook) {
  Rig rig = goodRig();
  const Vec3 shift(0.3, -0.2, 1.7);
  for (Camera& camera : rig.cameras)
    camera.camera_from_world.translation() -= camera.camera_from_world.linear() * shift;
  const std::optional<Vec3> meet = axesIntersection(rig);
  ASSERT_TRUE(meet);
  EXPECT_LE((*meet - shift).norm(), 1e-9);
  for (Camera& camera : rig.cameras) change(camera, axes(1, -1, -1));  // the cube is behind them
  EXPECT_FALSE(axesIntersection(rig));
  Rig parallel = ringRig(2);
  parallel.cameras[1] = parallel.cameras[0];
  parallel.cameras[1].camera_from_world.translation().x() += 0.2;
  EXPECT_FALSE(axesIntersection(parallel));
}

// --- against silhouettes ---

/// A sphere off the centre, in front of a ring of cameras. The rig changes, the silhouettes stay.
struct Scene {
  Rig rig = ringRig(4);
  std::vector<SilhouetteSet> instants = {sphereMasks(rig, Vec3(0.08, -0.05, 0.06), 0.07),
                                         sphereMasks(rig, Vec3(-0.06, 0.03, -0.02), 0.05)};

  std::vector<RigDiagnostic> findings() const {
    return silhouetteDiagnostics(rig, instants, silhouetteAgreement(rig, instants));
  }
};

TEST(RigAgreement, TrueRigExplainsItsSilhouettes) {
  const Scene scene;
  for (const SilhouetteAgreement& camera : silhouetteAgreement(scene.rig, scene.instants)) {
    EXPECT_GT(camera.pixels, 500u);
    EXPECT_EQ(camera.in_cube, camera.pixels);
    EXPECT_GE(camera.explainedFraction(), 0.99);
  }
  EXPECT_EQ(shown(scene.findings()), "");
}

TEST(RigAgreement, DetectsAWrongRigAndItsCause) {
  const auto each = [](const std::function<void(Camera&)>& apply) {
    return [apply](Rig& rig) { std::for_each(rig.cameras.begin(), rig.cameras.end(), apply); };
  };
  const std::vector<Defect> defects = {
      {"millimetres", each([](Camera& c) { c.camera_from_world.translation() *= 1000; }), {"in millimetres"}},
      {"inverse",
       each([](Camera& c) { c.camera_from_world = c.camera_from_world.inverse(); }),
       {"poses that are world_from_camera;"}},
      {"OpenGL", each([](Camera& c) { change(c, axes(1, -1, -1)); }), {"poses that are those of OpenGL"}},
      {"left-handed",
       each([](Camera& c) { change(c, axes(-1, 1, 1), axes(1, -1, 1)); }),
       {"mirrored rig", "left to right"}},
      {"exchanged",
       [](Rig& rig) { std::swap(rig.cameras[0].camera_from_world, rig.cameras[1].camera_from_world); },
       {"\"cam0\" and \"cam1\" swapped"}},
      {"moved",
       [](Rig& rig) {
         change(rig.cameras[3], rotationFromVector({0, 0.12, 0}));
       },
       {"camera \"cam3\"", "without it"}},
  };
  for (const Defect& defect : defects) {
    Scene scene;
    defect.apply(scene.rig);
    const std::vector<RigDiagnostic> findings = scene.findings();
    ASSERT_EQ(findings.size(), 1u) << defect.name;
    for (const std::string& text : defect.expected)
      EXPECT_NE(diagnosticMessage(findings[0], "rig").find(text), std::string::npos)
          << defect.name << ": " << shown(findings);
    EXPECT_EQ(findings[0].severity, findings[0].camera.empty() ? Severity::kError : Severity::kWarning);
  }
}

TEST(RigAgreement, ReportsUnexplainedDisagreement) {
  Scene scene;
  for (std::size_t i = 0; i < 4; ++i)  // the images of no two cameras are simultaneous
    scene.instants[0][i] = sphereMasks(
        scene.rig, 0.2 * Vec3(std::cos(1.6 * double(i)), std::sin(1.6 * double(i)), i % 2 ? 0.8 : -0.8),
        0.04)[i];
  scene.instants.pop_back();
  const std::vector<SilhouetteAgreement> agreement = silhouetteAgreement(scene.rig, scene.instants);
  const auto findings = [&](SilhouetteSource trust) {
    return silhouetteDiagnostics(scene.rig, scene.instants, agreement, trust);
  };
  ASSERT_EQ(findings(SilhouetteSource::kKnown).size(), 1u);
  EXPECT_EQ(findings(SilhouetteSource::kKnown)[0].severity, Severity::kError);
  EXPECT_NE(findings(SilhouetteSource::kKnown)[0].message.find("contradict"), std::string::npos);
  EXPECT_EQ(findings(SilhouetteSource::kAssumed)[0].severity, Severity::kWarning);

  Scene elsewhere;
  elsewhere.rig.workspace.center = Vec3(0, 0, 0.6);
  elsewhere.rig.workspace.edge_m = 0.3;
  const std::vector<RigDiagnostic> beside = elsewhere.findings();
  ASSERT_EQ(beside.size(), 1u);
  EXPECT_NE(beside[0].message.find("look into the cube"), std::string::npos) << beside[0].message;
}

// --- against a recording ---

void writeMasks(const TemporaryFolder& folder, const Rig& rig, const SilhouetteSet& masks) {
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const Camera& camera = rig.cameras[i];
    const std::filesystem::path of_camera = folder.path() / "silhouettes" / camera.name;
    std::filesystem::create_directories(of_camera);
    std::vector<std::uint8_t> rgba;
    for (const std::uint8_t pixel : masks[i].pixels) rgba.insert(rgba.end(), {pixel, pixel, pixel, 255});
    writePng(of_camera / "000003.png", {camera.width, camera.height}, rgba);
  }
}

TEST(TakeInspection, FindsSilhouettesSizesAndMissingFiles) {
  const TemporaryFolder folder;
  const Scene scene;
  writeMasks(folder, scene.rig, scene.instants[0]);
  Rig rig = scene.rig;
  rig.cameras[1].width = rig.cameras[1].height = 0;
  const TakeInspection take = inspectTake(folder.path(), rig);
  EXPECT_EQ(shown(take.findings), "");
  EXPECT_EQ(rig.cameras[1].width, 320);
  ASSERT_EQ(take.instants.size(), 1u);
  EXPECT_EQ(take.instants[0][2].pixels, scene.instants[0][2].pixels);
  EXPECT_EQ(take.source, SilhouetteSource::kKnown);

  rig.cameras[0].width = 640;
  rig.cameras[3].name = "other";
  const std::string findings = shown(inspectTake(folder.path(), rig).findings);
  EXPECT_NE(findings.find("camera \"cam0\": it recorded 320 x 240 pixels; expected the rig's 640 x 240"),
            std::string::npos)
      << findings;
  EXPECT_NE(findings.find("silhouettes/other"), std::string::npos) << findings;
  EXPECT_NE(messageOf([&] { inspectTake(folder / "none", rig); }).find("no such take"), std::string::npos);
}

TEST(TakeInspection, SegmentsImagesWithAKnownBackground) {
  const TemporaryFolder folder;
  Rig rig = ringRig(3);
  const SilhouetteSet masks = sphereMasks(rig, Vec3(0.03, 0.02, -0.04), 0.09);
  const auto write = [](const std::filesystem::path& file,
                        const Silhouette& mask) {  // dark in front of a light wall
    std::vector<std::uint8_t> rgba;
    for (const std::uint8_t pixel : mask.pixels) {
      const std::uint8_t grey = pixel ? 40 : 190;
      rgba.insert(rgba.end(), {grey, std::uint8_t(grey / 2), grey, 255});
    }
    std::filesystem::create_directories(file.parent_path());
    writePng(file, {mask.width, mask.height}, rgba);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    Silhouette empty = masks[i];
    std::fill(empty.pixels.begin(), empty.pixels.end(), std::uint8_t{0});
    write(folder.path() / rig.cameras[i].name / "000000.png", empty);
    write(folder.path() / rig.cameras[i].name / "000001.png", masks[i]);
    write(folder.path() / "background" / (rig.cameras[i].name + ".png"), empty);
  }
  const TakeInspection take = inspectTake(folder.path(), rig);
  EXPECT_EQ(shown(take.findings), "");
  ASSERT_EQ(take.instants.size(), 1u);  // the empty one carries no information
  const std::vector<SilhouetteAgreement> agreement = silhouetteAgreement(rig, take.instants);
  for (const SilhouetteAgreement& camera : agreement) EXPECT_GE(camera.explainedFraction(), 0.99);

  std::filesystem::remove_all(folder.path() / "cam1");
  const std::string findings = shown(inspectTake(folder.path(), rig).findings);
  EXPECT_NE(findings.find("camera \"cam1\": the take has no frames of it"), std::string::npos) << findings;
  std::filesystem::create_directories(folder.path() / "cam1");
  EXPECT_NE(shown(inspectTake(folder.path(), rig).findings).find("contains no image"), std::string::npos);
}

}  // namespace
}  // namespace airclay
