// SPDX-License-Identifier: MIT
// `cmake --install` into an empty folder: programs find and use the library there, every header compiles on
// its own, and the program runs with its man page, completions and desktop entry.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include "capture/takes/poses_file.h"
#include "engine/clay/presets.h"
#include "engine/clay/subdivide.h"
#include "engine/core/file_io.h"
#include "engine/core/median.h"
#include "engine/mesh/mesh_file.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/small_take.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;

/// An installed tree, shared by the tests of one process.
class Install : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (AIRCLAY_SANITIZED) return;
    folder_ = std::make_unique<TemporaryFolder>();
    // A staged install, as packagers make it, then moved: nothing may depend on the original location.
    const fs::path stage = *folder_ / "stage";
    const RunResult result = runProgram({"cmake", "--install", AIRCLAY_BUILD, "--prefix", "/opt/airclay"},
                                        {{"DESTDIR", stage.string()}});
    ASSERT_EQ(result.status, 0) << result.output << result.errors;
    fs::rename(stage / "opt/airclay", prefix());
    EXPECT_FALSE(fs::exists("/opt/airclay"));
  }
  static void TearDownTestSuite() { folder_.reset(); }
  void SetUp() override {
    if (AIRCLAY_SANITIZED) GTEST_SKIP() << "programs outside the build would need the sanitizer's run time";
    ASSERT_TRUE(fs::exists(prefix() / "bin/airclay"));
  }

  static fs::path prefix() { return *folder_ / "moved"; }
  static fs::path scratch(const std::string& name) { return *folder_ / name; }
  /// The folder of airclay.pc: lib or, below /usr, lib/TRIPLET.
  static fs::path libraries() {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(prefix()))
      if (entry.path().filename() == "airclay.pc") return entry.path().parent_path().parent_path();
    ADD_FAILURE() << "airclay.pc is not installed";
    return prefix() / "lib";
  }

  static std::unique_ptr<TemporaryFolder> folder_;
};
std::unique_ptr<TemporaryFolder> Install::folder_;

void expectSuccess(const std::vector<std::string>& arguments,
                   const std::map<std::string, std::string>& environment = {}) {
  const RunResult result = runProgram(arguments, environment);
  EXPECT_EQ(result.status, 0) << arguments.front() << ": " << result.output << result.errors;
}

// ------------------------------------------------------------------------------------------------- examples

/// Silhouettes of a sphere as a take: visible in frame 3, earlier frames are empty.
void writeSphereTake(const fs::path& folder, const Rig& rig, const Vec3& centre, double radius_m) {
  fs::create_directories(folder);
  writeRig(folder / "rig.toml", rig, RotationFormat::kMatrices);
  const std::vector<Silhouette> masks = sphereMasks(rig, centre, radius_m);
  for (std::size_t c = 0; c < masks.size(); ++c) {
    Silhouette mask = masks[c];
    const fs::path file = folder / "silhouettes" / rig.cameras[c].name / "000003.png";
    fs::create_directories(file.parent_path());
    ASSERT_TRUE(cv::imwrite(file, cv::Mat(mask.height, mask.width, CV_8UC1, mask.pixels.data())));
  }
}

/// The volume of the intersection of the cones that touch the sphere, one per camera, by counting points.
double coneHullVolume(const Rig& rig, const Vec3& centre, double radius_m) {
  constexpr int kSteps = 160;
  const double edge_m = 4 * radius_m, step_m = edge_m / kSteps;
  std::vector<Vec3> eyes;
  for (const Camera& camera : rig.cameras) eyes.push_back(camera.camera_from_world.inverse().translation());
  std::size_t inside = 0;
  for (int z = 0; z < kSteps; ++z)
    for (int y = 0; y < kSteps; ++y)
      for (int x = 0; x < kSteps; ++x) {
        const Vec3 point = centre + step_m * Vec3(x + 0.5, y + 0.5, z + 0.5) - Vec3::Constant(edge_m / 2);
        inside += std::all_of(eyes.begin(), eyes.end(), [&](const Vec3& eye) {
          return (point - eye).normalized().cross(centre - eye).norm() <= radius_m;
        });
      }
  return std::pow(step_m, 3) * static_cast<double>(inside);
}

/// Reads an OBJ of triangles, manifold or not: voxels may touch along an edge.
TriangleMesh readTriangles(const fs::path& file) {
  TriangleMesh mesh;
  std::istringstream content(contentOf(file));
  for (std::string kind; content >> kind;) {
    if (kind == "v") {
      Vec3& vertex = mesh.vertices.emplace_back();
      content >> vertex.x() >> vertex.y() >> vertex.z();
    } else {
      auto& [a, b, c] = mesh.triangles.emplace_back();
      content >> a >> b >> c;
      --a, --b, --c;
    }
  }
  return mesh;
}

void checkHullExample(const fs::path& program, const fs::path& folder) {
  const Rig rig = ringRig(6);
  const Vec3 centre(0.05, -0.03, 0.02);
  writeSphereTake(folder / "sphere", rig, centre, 0.08);
  expectSuccess({program, folder / "sphere", "3", folder / "hull.obj"});
  const double expected_m3 = coneHullVolume(rig, centre, 0.08);
  EXPECT_GT(expected_m3, 4.0 / 3 * M_PI * std::pow(0.08, 3));
  EXPECT_NEAR(massProperties(readTriangles(folder / "hull.obj")).volume_m3 / expected_m3, 1,
              0.03);  // a pixel is 3 mm, a voxel 5 mm

  const RunResult missing = runProgram({program, folder / "sphere", "4", folder / "none.obj"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.errors.find("frame 4"), std::string::npos) << missing.errors;
}

void checkPosesExample(const fs::path& program, const fs::path& folder) {
  const int frames = writeSmallTake(folder / "take");
  expectSuccess({program, folder / "take", folder / "poses.tum"});
  const std::vector<TimedPose> poses = readPoses(folder / "poses.tum");
  EXPECT_GE(poses.size(), static_cast<std::size_t>(frames - 10) * 9 / 10);
  const HandScript truth = smallTakeScript();
  std::vector<double> errors_m;
  for (const TimedPose& pose : poses)
    errors_m.push_back((pose.world_from_hand.translation() - truth.at(pose.time_s)->translation()).norm());
  EXPECT_LT(median(errors_m), 0.004);
}

/// Data points determine a cage, and subdivision is invariant under affine maps: moving the data points by an
/// affine map must move the cage and the surface by the same map.
void checkSurfaceExample(const fs::path& program, const fs::path& folder,
                         const std::map<std::string, std::string>& environment = {}) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  map.linear() << 1.1, 0.2, 0, -0.1, 0.9, 0.05, 0, 0.1, 1.2;
  map.translation() = Vec3(0.01, -0.02, 0.03);
  const PolygonMesh cage = presetCage("tube");
  const PolygonMesh surface = meshAtLevel(cage, 2, SubdivisionRule::kCatmullClark);
  std::string moves = "index,x,y,z\n";
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Vec3 target = map * surface.points[i];
    moves += std::to_string(i);
    for (int axis = 0; axis < 3; ++axis) moves += "," + exactNumber(target[axis]);
    moves += "\n";
  }
  writeWhole(folder / "moves.csv", moves);
  expectSuccess({program, "tube", folder / "moves.csv", folder / "cage.obj", folder / "surface.obj"},
                environment);
  const PolygonMesh new_cage = readObj(folder / "cage.obj"), new_surface = readObj(folder / "surface.obj");
  ASSERT_EQ(new_cage.points.size(), cage.points.size());
  ASSERT_EQ(new_surface.points.size(), surface.points.size());
  for (std::size_t i = 0; i < cage.points.size(); ++i)
    EXPECT_LT((new_cage.points[i] - map * cage.points[i]).norm(), 1e-7) << "control point " << i;
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    EXPECT_LT((new_surface.points[i] - map * surface.points[i]).norm(), 1e-7) << "data point " << i;
  EXPECT_EQ(new_surface.faces, surface.faces);
}

TEST_F(Install, ExamplesBuildAndComputeCorrectResults) {
  const fs::path build = scratch("build");
  expectSuccess({"cmake", "-G", "Ninja", "-S", std::string(AIRCLAY_SOURCE) + "/app/examples", "-B", build,
                 "-DCMAKE_PREFIX_PATH=" + prefix().string(), "-DCMAKE_CXX_COMPILER=" AIRCLAY_CXX,
                 "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror"});
  expectSuccess({"cmake", "--build", build});
  ASSERT_FALSE(HasFailure());
  const fs::path folder = scratch("examples");
  fs::create_directories(folder);
  checkHullExample(build / "masks_to_hull", folder);
  checkPosesExample(build / "take_to_poses", folder);
  checkSurfaceExample(build / "moves_to_surface", folder);
}

TEST_F(Install, PkgConfigBuildsAProgram) {
  const fs::path program = scratch("moves_to_surface");
  const std::string source = std::string(AIRCLAY_SOURCE) + "/app/examples/moves_to_surface.cpp";
  expectSuccess(
      {"sh", "-ec",
       AIRCLAY_CXX " " + source + " -o " + program.string() + " $(pkg-config --cflags --libs airclay)"},
      {{"PKG_CONFIG_PATH", libraries() / "pkgconfig"}});
  fs::create_directories(scratch("pkgconfig"));
  checkSurfaceExample(program, scratch("pkgconfig"), {{"LD_LIBRARY_PATH", libraries()}});
}

TEST_F(Install, ExamplesAreShort) {
  for (const fs::directory_entry& entry :
       fs::directory_iterator(std::string(AIRCLAY_SOURCE) + "/app/examples")) {
    std::istringstream lines(contentOf(entry.path()));
    int count = 0;
    for (std::string line; std::getline(lines, line);) ++count;
    EXPECT_LE(count, 60) << entry.path();
  }
}

// -------------------------------------------------------------------------------------------------- headers

/// Every installed header in the form that programs include it: "engine/pipeline.h".
std::vector<std::string> headersBelow(const fs::path& include) {
  std::vector<std::string> headers;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(include))
    if (entry.path().extension() == ".h")
      headers.push_back(entry.path().lexically_relative(include).generic_string());
  std::sort(headers.begin(), headers.end());
  return headers;
}

std::vector<std::string> includesOf(const fs::path& header) {
  static const std::regex kInclude(
      R"re(^\s*#\s*include\s+["<]((?:shaders|engine|capture|app)/[^">]+)[">])re");
  std::vector<std::string> includes;
  std::istringstream lines(contentOf(header));
  for (std::string line; std::getline(lines, line);)
    if (std::smatch match; std::regex_search(line, match, kInclude)) includes.push_back(match[1]);
  return includes;
}

bool reaches(const fs::path& include, const std::string& from, const std::string& to,
             std::set<std::string>& seen) {
  if (from == to) return true;
  if (!seen.insert(from).second) return false;
  const std::vector<std::string> includes = includesOf(include / from);
  return std::any_of(includes.begin(), includes.end(),
                     [&](const std::string& next) { return reaches(include, next, to, seen); });
}

TEST_F(Install, NoPublicHeaderIncludesAnInternalOne) {
  const fs::path include = prefix() / "include/airclay";
  const std::vector<std::string> headers = headersBelow(include);
  EXPECT_GE(headers.size(), 80u);
  for (const std::string& header : headers)
    for (const std::string& included : includesOf(include / header))
      EXPECT_TRUE(fs::exists(include / included))
          << header << " includes " << included << ", which is internal";
  EXPECT_FALSE(fs::exists(include / "capture/calibration/calibration_parts.h"));
}

// Headers that include Eigen, which takes most of the time: they are precompiled for the headers that include
// them, directly or not. In this order, because math.h includes more.
const std::string kPrecompiled[] = {"engine/core/math.h", "shaders/core/io.h"};

/// A source file that checks several headers: each includes all headers before it, directly or not, so each
/// compiles only if it compiles on its own.
struct HeaderChain {
  std::string precompiled;  ///< one of kPrecompiled that all headers include; or empty
  std::vector<std::string> headers;
};

std::vector<HeaderChain> chainsOf(const fs::path& include, std::vector<std::string> headers) {
  std::map<std::string, std::set<std::string>> included;  // directly or not, and the header itself
  for (const std::string& header : headers)
    for (const std::string& other : headers)
      if (std::set<std::string> seen; reaches(include, header, other, seen)) included[header].insert(other);
  std::stable_sort(headers.begin(), headers.end(), [&](const std::string& a, const std::string& b) {
    return included[a].size() < included[b].size();
  });
  std::vector<HeaderChain> chains;
  for (const std::string& header : headers) {
    HeaderChain alone{"", {header}};
    for (const std::string& precompiled : kPrecompiled)
      if (alone.precompiled.empty() && header != precompiled && included[header].count(precompiled))
        alone.precompiled = precompiled;
    HeaderChain* longest = nullptr;
    for (HeaderChain& chain : chains)
      if (chain.precompiled == alone.precompiled && included[header].count(chain.headers.back()) &&
          (!longest || included[chain.headers.back()].size() > included[longest->headers.back()].size()))
        longest = &chain;
    if (longest)
      longest->headers.push_back(header);
    else
      chains.push_back(alone);
  }
  return chains;
}

TEST_F(Install, EveryHeaderCompilesOnItsOwn) {
  const fs::path include = prefix() / "include/airclay", scratch_folder = scratch("headers");
  const std::vector<std::string> headers = headersBelow(include);
  const std::string flags =
      " -std=c++20 -w -I" + include.string() + " $(pkg-config --cflags-only-I eigen3 vulkan) ";
  for (const std::string& header : kPrecompiled) {
    fs::create_directories((scratch_folder / header).parent_path());
    expectSuccess({"sh", "-ec",
                   AIRCLAY_CXX + flags + "-x c++-header " + (include / header).string() + " -o " +
                       (scratch_folder / header).string() + ".gch"});
  }
  std::string commands;
  std::size_t checked = 0;
  for (const HeaderChain& chain : chainsOf(include, headers)) {
    std::string source;
    for (const std::string& header : chain.headers) source += "#include \"" + header + "\"\n";
    const fs::path file = scratch_folder / (std::to_string(checked) + ".cpp");
    writeWhole(file, source);
    commands +=
        AIRCLAY_CXX + flags + "-fsyntax-only " +
        (chain.precompiled.empty() ? "" : "-include " + (scratch_folder / chain.precompiled).string() + " ") +
        file.string() + " || echo FAILED " + file.string() + "\n";
    checked += chain.headers.size();
  }
  EXPECT_EQ(checked, headers.size());
  const fs::path list = scratch_folder / "commands";
  writeWhole(list, commands);
  const RunResult result =
      runProgram({"sh", "-c",
                  "xargs -d '\\n' -P " + std::to_string(std::thread::hardware_concurrency()) +
                      " -I{} sh -c '{}' < '" + list.string() + "'"});
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output + result.errors, "");
}

// ------------------------------------------------------------------------------------- program and desktop

TEST_F(Install, ProgramRunsFromAnyPrefix) {
  const RunResult version = runProgram({prefix() / "bin/airclay", "--version"}, {{"LD_LIBRARY_PATH", ""}});
  EXPECT_EQ(version.status, 0) << version.errors;
  EXPECT_TRUE(std::regex_match(version.output, std::regex(R"(\d+\.\d+\.\d+\n)"))) << version.output;
  // Its own libraries, not those of the build.
  const RunResult libraries = runProgram({"ldd", prefix() / "bin/airclay"}, {{"LD_LIBRARY_PATH", ""}});
  std::istringstream lines(libraries.output);
  int found = 0;
  for (std::string line; std::getline(lines, line);)
    if (line.find("libairclay_") != std::string::npos) {
      ++found;
      EXPECT_NE(line.find(prefix().string()), std::string::npos) << line;
    }
  EXPECT_EQ(found, 2) << libraries.output;
}

TEST_F(Install, ManPageRenders) {
  const fs::path page = prefix() / "share/man/man1/airclay.1";
  const std::string source = contentOf(page);
  for (const char* part : {".TH AIRCLAY 1", ".SH NAME", ".SH SYNOPSIS", ".SH COMMANDS", ".SH EXIT STATUS"})
    EXPECT_NE(source.find(part), std::string::npos) << part;
  if (runProgram({"sh", "-c", "command -v groff"}).status != 0) return;
  const RunResult rendered = runProgram({"groff", "-man", "-Tascii", "-ww", page});
  EXPECT_EQ(rendered.status, 0);
  EXPECT_EQ(rendered.errors, "");
  EXPECT_NE(rendered.output.find("--poses"), std::string::npos);
}

/// The completions that bash offers at the end of a command line.
std::string completed(const fs::path& completion, const std::vector<std::string>& arguments) {
  std::string script = "source '" + completion.string() + "'; COMP_WORDS=(airclay";
  for (const std::string& argument : arguments) script += " '" + argument + "'";
  script += "); COMP_CWORD=" + std::to_string(arguments.size()) + "; _airclay; echo \"${COMPREPLY[*]}\"";
  return runProgram({"bash", "-euc", script}).output;
}

TEST_F(Install, BashCompletesCommandsAndOptions) {
  const fs::path completion = prefix() / "share/bash-completion/completions/airclay";
  EXPECT_EQ(completed(completion, {"subd"}), "subdivide\n");
  EXPECT_EQ(completed(completion, {"track", "TAKE", "--pos"}), "--poses\n");
  EXPECT_EQ(completed(completion, {"rig", "che"}), "check\n");
}

TEST_F(Install, InstallsZshAndFishCompletions) {
  EXPECT_TRUE(contentOf(prefix() / "share/zsh/site-functions/_airclay").starts_with("#compdef airclay\n"));
  const std::string fish = contentOf(prefix() / "share/fish/vendor_completions.d/airclay.fish");
  EXPECT_NE(fish.find("complete -c airclay -n __fish_use_subcommand -a track"), std::string::npos);
}

TEST_F(Install, DesktopEntryNamesInstalledFiles) {
  const fs::path file = prefix() / "share/applications/airclay.desktop";
  const std::string entry = contentOf(file);
  EXPECT_TRUE(entry.starts_with("[Desktop Entry]\n"));
  std::map<std::string, std::string> values;
  std::istringstream lines(entry);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t at = line.find('='); at != std::string::npos)
      values[line.substr(0, at)] = line.substr(at + 1);
  EXPECT_EQ(values["Type"], "Application");
  EXPECT_TRUE(fs::exists(prefix() / "bin" / values["Exec"].substr(0, values["Exec"].find(' '))));
  EXPECT_TRUE(fs::exists(prefix() / "share/icons/hicolor/scalable/apps" / (values["Icon"] + ".svg")));
  const std::string type = values["MimeType"].substr(0, values["MimeType"].find(';'));
  EXPECT_NE(contentOf(prefix() / "share/mime/packages/airclay.xml").find('"' + type + '"'),
            std::string::npos);
  if (runProgram({"sh", "-c", "command -v desktop-file-validate"}).status == 0)
    expectSuccess({"desktop-file-validate", file});
}

}  // namespace
}  // namespace airclay
