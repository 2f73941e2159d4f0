// SPDX-License-Identifier: MIT
// Views and the parts of a scene.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "engine/mesh/mesh_export.h"
#include "engine/render/renderer.h"

namespace airclay {
namespace {

/// The pose of a camera at `eye` that looks along `forward`.
Pose cameraPose(const Vec3& eye, const Vec3& forward) {
  const Vec3 ahead = forward.normalized();
  // looking straight down, y points up in the image
  const Vec3 up = std::abs(ahead.z()) > 1 - 1e-9 ? Vec3::UnitY() : Vec3::UnitZ();
  const Vec3 right = ahead.cross(up).normalized();
  Pose workspace_from_camera = Pose::Identity();
  workspace_from_camera.linear() << right, ahead.cross(right), ahead;
  workspace_from_camera.translation() = eye;
  return workspace_from_camera.inverse();
}

/// From a distance at which the cube's front face fills 90 % of the image's height.
View alongAxis(const Workspace& workspace, const Vec3& from) {
  View view;
  view.vertical_fov_rad = 0.4;
  const double distance_m = workspace.edge_m * (0.5 + 0.5 / (0.9 * std::tan(0.2)));
  view.camera_from_workspace = cameraPose(distance_m * from, -from);
  return view;
}

/// Interleaves the bits of 10-bit coordinates, so that points close in space are close in the order (Morton
/// 1966).
std::uint32_t mortonCode(const Vec3& unit) {
  std::uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<std::uint32_t>(std::clamp(unit[axis], 0.0, 1.0) * 1023);
    for (int bit = 0; bit < 10; ++bit) code |= (cell >> bit & 1u) << (3 * bit + axis);
  }
  return code;
}

/// The triangles in Morton order of their centroids.
std::vector<std::array<int, 3>> inSpatialOrder(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  std::vector<std::pair<std::uint32_t, std::size_t>> order;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec3 centroid = Vec3::Zero();
    for (const int v : mesh.triangles[t]) centroid += mesh.vertices[static_cast<std::size_t>(v)] / 3;
    order.emplace_back(mortonCode((centroid - box.min()) / box.sizes().maxCoeff()), t);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::array<int, 3>> triangles;
  for (const auto& [code, t] : order) triangles.push_back(mesh.triangles[t]);
  return triangles;
}

std::vector<vec3> inFloat(const std::vector<Vec3>& values) {
  std::vector<vec3> result;
  for (const Vec3& value : values) result.push_back(value.cast<float>());
  return result;
}

/// The level to draw. Each level has about four times the points of the previous one.
int displayLevels(std::size_t control_points, int levels, const DisplayDetail& detail) {
  double points = static_cast<double>(control_points) * std::pow(4.0, levels);
  int drawn = levels;
  for (; drawn > 1 && points > detail.coarsen_above_points; --drawn) points /= 4;
  for (; drawn >= levels && drawn < levels + 2 && 4 * points <= detail.refine_below_points; ++drawn)
    points *= 4;
  return drawn;
}

}  // namespace

Pose workspaceFromWorld(const Workspace& workspace) {
  return Pose(Eigen::Translation3d(-workspace.center));
}

View lookAt(const Vec3& eye, const Vec3& target, double vertical_fov_rad) {
  View view;
  view.camera_from_workspace = cameraPose(eye, target - eye);
  view.vertical_fov_rad = vertical_fov_rad;
  return view;
}

View orbitView(const Orbit& orbit) {
  const Vec3 out(std::cos(orbit.elevation_rad) * std::cos(orbit.azimuth_rad),
                 std::cos(orbit.elevation_rad) * std::sin(orbit.azimuth_rad), std::sin(orbit.elevation_rad));
  return lookAt(orbit.target + orbit.distance_m * out, orbit.target, orbit.vertical_fov_rad);
}

View frontView(const Workspace& workspace) {
  return alongAxis(workspace, -Vec3::UnitY());
}
View sideView(const Workspace& workspace) {
  return alongAxis(workspace, Vec3::UnitX());
}
View topView(const Workspace& workspace) {
  return alongAxis(workspace, Vec3::UnitZ());
}

View cameraView(const Camera& camera, const Workspace& workspace) {
  View view;
  view.camera_from_workspace = camera.camera_from_world * workspaceFromWorld(workspace).inverse();
  // a pinhole camera cannot show 180°, and 140° is already strongly stretched
  view.vertical_fov_rad = std::min(2 * std::atan(0.5 * camera.height / camera.lens.fy), 2.4);
  view.axis_shift =
      Vec2(camera.lens.cx - 0.5 * (camera.width - 1), camera.lens.cy - 0.5 * (camera.height - 1)) /
      camera.height;
  return view;
}

RenderMesh::RenderMesh(Gpu& gpu, const TriangleMesh& mesh) : RenderMesh(gpu, mesh, vertexNormals(mesh)) {}

RenderMesh::RenderMesh(Gpu& gpu, const TriangleMesh& mesh, const std::vector<Vec3>& normals)
    : positions_(gpu, inFloat(mesh.vertices)), normals_(gpu, inFloat(normals)) {
  std::vector<std::uint32_t> indices;
  for (const auto& triangle : inSpatialOrder(mesh))
    for (const int v : triangle) indices.push_back(static_cast<std::uint32_t>(v));
  triangles_ = Buffer<std::uint32_t>(gpu, indices);
}

RenderMesh RenderMesh::withDistances(Gpu& gpu, const TriangleMesh& mesh) {
  // 4 mm cells resolve a fingertip; the contact shadow ends at 4 cm
  constexpr double kCellM = 0.004, kMarginM = 0.04;
  RenderMesh drawn(gpu, mesh);
  drawn.grid_ = signedDistanceGrid(mesh, kCellM, kMarginM);
  drawn.grid_values_ = Buffer<float>(gpu, drawn.grid_.values);
  return drawn;
}

RenderMesh RenderMesh::faceted(Gpu& gpu, const PolygonMesh& mesh) {
  TriangleMesh flat;
  std::vector<Vec3> normals;
  for (const std::vector<int>& face : mesh.faces) {
    const int first = static_cast<int>(flat.vertices.size()), corners = static_cast<int>(face.size());
    Vec3 area = Vec3::Zero();  // Newell's method, valid for non-planar faces
    for (int i = 0; i < corners; ++i) {
      const Vec3& a = mesh.points[static_cast<std::size_t>(face[static_cast<std::size_t>(i)])];
      const Vec3& b =
          mesh.points[static_cast<std::size_t>(face[static_cast<std::size_t>((i + 1) % corners)])];
      area += a.cross(b);
      flat.vertices.push_back(a);
    }
    normals.insert(normals.end(), face.size(), area.normalized());
    for (int i = 1; i + 1 < corners; ++i) flat.triangles.push_back({first, first + i, first + i + 1});
  }
  return RenderMesh(gpu, flat, normals);
}

DisplaySurface::DisplaySurface(Gpu& gpu, const PolygonMesh& cage, SubdivisionRule rule, int levels,
                               const DisplayDetail& detail)
    : gpu_(gpu), evaluator_(gpu, subdivide(cage, displayLevels(cage.points.size(), levels, detail), rule)) {}

void DisplaySurface::evaluate(const std::vector<Vec3>& control_points, const Workspace& workspace) {
  std::vector<vec3> in_workspace;
  for (const Vec3& point : control_points) in_workspace.push_back((point - workspace.center).cast<float>());
  const Buffer<vec3> points(gpu_, in_workspace);
  Recorder recorder(gpu_);
  recorder.begin();
  recorder.stage("display surface");
  record(recorder, points);
  recorder.submitAndWait();
}

vec3 colorFromSrgb(int red, int green, int blue) {
  return {linearFromSrgb(red), linearFromSrgb(green), linearFromSrgb(blue)};
}

vec3 clayColor() {
  return colorFromSrgb(kClayColor[0], kClayColor[1], kClayColor[2]);
}
vec3 skinColor() {
  return colorFromSrgb(208, 152, 128);
}

SceneStrokes cubeEdges(const Workspace& workspace) {
  SceneStrokes strokes;
  const double half = 0.5 * workspace.edge_m;
  for (int axis = 0; axis < 3; ++axis)
    for (const double u : {-half, half})
      for (const double v : {-half, half})
        for (const double w : {-half, half}) {
          Vec3 point;
          point[axis] = w;
          point[(axis + 1) % 3] = u;
          point[(axis + 2) % 3] = v;
          strokes.host_points.push_back(point);
        }
  strokes.color = vec3(0.12f, 0.12f, 0.13f);
  strokes.width_px = 1.4;
  return strokes;
}

SceneStrokes symmetryRing(int axis, double radius_m) {
  constexpr int kChords = 96;
  SceneStrokes ring;
  for (int i = 0; i < 2 * kChords; ++i) {
    const double angle = 2 * M_PI * ((i + 1) / 2) / kChords;  // both ends of each chord
    Vec3 point = Vec3::Zero();
    point[(axis + 1) % 3] = radius_m * std::cos(angle);
    point[(axis + 2) % 3] = radius_m * std::sin(angle);
    ring.host_points.push_back(point);
  }
  ring.color = vec3(0.42f, 0.13f, 0.05f);
  ring.width_px = 1.6;
  ring.hidden = 0.25;
  return ring;
}

SceneStrokes cameraFrusta(const Rig& rig, double length_m) {
  SceneStrokes strokes;
  strokes.width_px = 1.6;
  for (const Camera& camera : rig.cameras) {
    const View view = cameraView(camera, rig.workspace);
    const Pose workspace_from_camera = view.camera_from_workspace.inverse();
    const double half_height = std::tan(0.5 * view.vertical_fov_rad);
    const double aspect = static_cast<double>(camera.width) / camera.height;
    std::array<Vec3, 4> corners;
    const double signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 at = Vec2(signs[i][0] * aspect, signs[i][1]) - 2 * view.axis_shift;
      corners[i] =
          workspace_from_camera * Vec3(length_m * Vec3(half_height * at.x(), half_height * at.y(), 1));
    }
    for (std::size_t i = 0; i < 4; ++i)
      for (const Vec3& point :
           {workspace_from_camera.translation().eval(), corners[i], corners[i], corners[(i + 1) % 4]})
        strokes.host_points.push_back(point);
  }
  return strokes;
}

std::vector<std::uint32_t> edgeIndices(const std::vector<std::vector<int>>& faces) {
  std::set<std::pair<int, int>> edges;
  for (const std::vector<int>& face : faces)
    for (std::size_t i = 0; i < face.size(); ++i)
      edges.insert(std::minmax(face[i], face[(i + 1) % face.size()]));
  std::vector<std::uint32_t> ends;
  for (const auto& [a, b] : edges)
    for (const int end : {a, b}) ends.push_back(static_cast<std::uint32_t>(end));
  return ends;
}

SceneStrokes meshEdges(const PolygonMesh& mesh, const Workspace& workspace) {
  SceneStrokes strokes;
  for (const std::uint32_t end : edgeIndices(mesh.faces))
    strokes.host_points.push_back(mesh.points[end] - workspace.center);
  return strokes;
}

std::vector<SceneCapsule> skeletonCapsules(const HandModel& hand, const Pose& workspace_from_hand) {
  std::vector<SceneCapsule> capsules;
  const auto place = [&](const Joint& joint) {
    return Vec3(workspace_from_hand * joint.hand_from_joint_rest.translation());
  };
  for (const Joint& joint : hand.joints) {
    const Vec3 at = place(joint);
    const bool is_tip = joint.name.ends_with("-tip");  // tips are on the skin: a sphere there would protrude
    if (!is_tip) capsules.push_back({at, at, 0.0052, 0.0052, colorFromSrgb(205, 96, 62)});
    if (joint.parent < 0) continue;
    const Vec3 from = place(hand.joints[static_cast<std::size_t>(joint.parent)]);
    const Vec3 to = is_tip ? Vec3(at - 0.005 * (at - from).normalized()) : at;
    capsules.push_back({from, to, 0.0034, 0.0024, colorFromSrgb(240, 232, 216)});
  }
  return capsules;
}

}  // namespace airclay
