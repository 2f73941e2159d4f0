// SPDX-License-Identifier: MIT
// The fit of the hand's outline to the images of all cameras at once, each at its own time
// (shaders/hand/outline_io.h states the method and its sources).
//
// Positions are in the workspace frame, or relative to the hand's centre of mass in the hand's axes.
#pragma once

#include "engine/gpu/kernel.h"
#include "engine/gpu/recorder.h"
#include "engine/hand/hand_model.h"
#include "engine/hand/hand_pose.h"
#include "engine/silhouette/evidence.h"
#include "shaders/hand/outline_io.h"

namespace airclay {

/// A hand model for the fit. Vertices at the same place are one.
struct OutlineModel {
  std::vector<vec3> vertices;          ///< from the centre of mass, metres
  std::vector<GpuTriangle> triangles;  ///< of the closed skin
  std::vector<GpuOutlineEdge> edges;   ///< between two triangles of skin, not of the cut at the wrist
  std::vector<vec3> points;            ///< on the skin; neighbours are about kPointSpacing_m apart
  Vec3 center_of_mass = Vec3::Zero();  ///< hand frame, metres
  Vec3 to_forearm = Vec3::Zero();      ///< unit, from the middle finger's knuckle to the wrist
  Vec3 arm_from = Vec3::Zero(), arm_to = Vec3::Zero();  ///< ends of the forearm's axis
  double radius_m = 0;  ///< largest distance of the skin from the centre of mass

  static constexpr double kPointSpacing_m = 0.004;
};

OutlineModel outlineModel(const HandModel& hand);

/// A number of Gauss-Newton steps of the same kind.
struct OutlineStage {
  int steps = 0;
  bool fine = false;
  int reach = 0;            ///< pixels, coarse stages only
  double spread = 0;        ///< standard deviation of the expected offset in pixels, coarse stages only
  bool finds_edges = true;  ///< before the first step; otherwise the edges are those of the stage before
};

/// The scale of the hand relative to its model: fixed, or estimated with a Gaussian prior of its logarithm.
struct ScalePrior {
  double log_scale = 0;
  double weight = 0;  ///< 1 / variance; 0: fixed at the start's scale
};

class OutlineFitter {
 public:
  OutlineFitter(Gpu& gpu, const GpuRig& rig, const OutlineModel& model);

  /// The frame's motion and camera times; the forearm is the model's.
  GpuOutlineFrame frame() const;
  /// Records the fit from `start`. \pre the evidence of the frame is recorded around the hand
  void record(Recorder& recorder, const GpuOutlineFrame& frame, const GpuOutlinePose& start,
              std::span<const OutlineStage> stages, const Evidence& evidence,
              const Buffer<std::uint32_t>& images, const Buffer<std::uint32_t>& model,
              const ScalePrior& scale);
  /// The result. \pre the recorded work is done
  const GpuOutlineFit& result() const { return result_.host()[0]; }
  const Buffer<GpuOutlineFit>& resultBuffer() const { return result_; }
  /// The hand's mask in every camera in the last step, and the forearms (outline_project).
  const Buffer<std::uint32_t>& masks() const { return masks_; }
  const Buffer<vec4>& forearms() const { return forearms_; }

  const OutlineModel& model() const { return model_; }
  // for comparison with the reference
  const Buffer<vec2>& pixels() const { return pixels_; }
  const Buffer<std::uint32_t>& lists() const { return lists_; }
  const Buffer<GpuOutlineLine>& lines() const { return lines_; }

 private:
  void recordOutline(Recorder& recorder, bool find_edges);

  const GpuRig& rig_;
  OutlineModel model_;
  Kernel<OutlineProjectArgs> project_;
  Kernel<OutlineMaskArgs> mask_;
  Kernel<OutlineListArgs> list_;
  Kernel<OutlineCoarseArgs> coarse_;
  Kernel<OutlineFineArgs> fine_;
  Kernel<OutlineSolveArgs> solve_;
  Buffer<vec3> vertices_;
  Buffer<GpuTriangle> triangles_;
  Buffer<GpuOutlineEdge> edges_;
  Buffer<GpuOutlineFrame> frame_;
  Buffer<GpuOutlinePose> pose_;
  Buffer<vec2> pixels_;
  Buffer<vec4> forearms_;
  Buffer<std::uint32_t> masks_, lists_;
  Buffer<GpuOutlineLine> lines_;
  Buffer<GpuOutlineFit> result_;
};

/// The outline's pose of a hand, and back.
GpuOutlinePose noOutlinePose();
GpuOutlinePose outlinePose(const Mat3& rotation, const Vec3& position, double scale);
inline Mat3 rotationOf(const GpuOutlinePose& pose) {
  return Eigen::Quaterniond(Eigen::Vector4d(pose.rotation.cast<double>())).normalized().toRotationMatrix();
}
/// The pose at a camera's own time, and after `seconds` of the frame's motion.
GpuOutlinePose movedPose(const GpuOutlinePose& pose, const GpuOutlineFrame& frame, double seconds);

// --- the reference implementation, in double precision, step by step ---

/// The vertices' pixels in a camera; empty where the lens model does not cover them.
std::vector<std::optional<Vec2>> projectReference(const Camera& camera, const Workspace& workspace,
                                                  const OutlineModel& model, const GpuOutlinePose& pose);
/// The forearm's ends in pixels; its radius in z of the first.
std::array<vec4, 2> forearmReference(const Camera& camera, const Workspace& workspace,
                                     const GpuOutlineFrame& frame, const GpuOutlinePose& pose);
/// The pixels whose centres are in a front-facing triangle.
Silhouette maskReference(const Camera& camera, const OutlineModel& model,
                         const std::vector<std::optional<Vec2>>& pixels);
/// The silhouette edges in their order.
std::vector<std::uint32_t> listReference(const OutlineModel& model,
                                         const std::vector<std::optional<Vec2>>& pixels);

/// A camera's data for the lines of a step.
struct OutlineView {
  const Camera* camera = nullptr;
  const Workspace* workspace = nullptr;
  const OutlineModel* model = nullptr;
  GpuOutlinePose pose;  ///< at the camera's time
  std::vector<std::optional<Vec2>> pixels;
  Silhouette mask;
  vec4 arm_from, arm_to;
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  ///< of the frame: m/s, rad/s
  // coarse
  std::span<const std::uint8_t> evidence;  ///< bytes of the camera's cells
  GpuTileRegion region;
  // fine
  std::span<const std::uint8_t> image;        ///< BGR
  std::span<const std::uint32_t> background;  ///< the pixels' model
  Vec3 gain = Vec3::Ones();
};

/// As GpuOutlineLine.
struct OutlineLine {
  Eigen::Matrix<double, 7, 1> row = Eigen::Matrix<double, 7, 1>::Zero();
  double offset = 0, weight = 0, length = 0, blur = 0;
};
OutlineLine coarseReference(const OutlineView& view, std::uint32_t edge, int reach, double spread);
OutlineLine fineReference(const OutlineView& view, std::uint32_t edge);
/// One step, and the sums before it; the scale is fixed unless scale.weight > 0. `lines`: of each camera.
GpuOutlineFit solveReference(const GpuOutlinePose& pose,
                             const std::vector<std::vector<GpuOutlineLine>>& lines, const ScalePrior& scale);
/// Whether the images confirm the fit.
bool judgeReference(const GpuOutlineFit& fit, std::size_t cameras);

}  // namespace airclay
