// SPDX-License-Identifier: MIT
#include "engine/hand/fit.h"

#include "shaders/hand/fit.comp.h"

namespace airclay {

static_assert(sizeof(GpuPatch) == 32, "fit.comp loads it by this size");

FitModel fitModel(const HandModel& hand) {
  const TriangleMesh closed = withCaps(hand.skin);
  const MassProperties solid = massProperties(hand.skin);
  FitModel model;
  model.center_of_mass = solid.centroid;
  model.inertia_m2 = solid.inertia_m5 / solid.volume_m3;
  for (std::size_t i = 0; i < closed.triangles.size(); ++i) {
    const auto& [a, b, c] = closed.triangles[i];
    const Vec3 &p = closed.vertices[std::size_t(a)], &q = closed.vertices[std::size_t(b)],
               &r = closed.vertices[std::size_t(c)];
    const Vec3 twice_area = (q - p).cross(r - p);
    if (twice_area.norm() == 0) continue;  // degenerate: exerts no force
    GpuPatch patch{};
    patch.center = ((p + q + r) / 3 - solid.centroid).cast<float>();
    patch.area = static_cast<float>(0.5 * twice_area.norm());
    patch.normal = twice_area.normalized().cast<float>();
    // triangles added by withCaps() are also where the forearm continues
    patch.cut = i >= hand.skin.triangles.size() || (i < hand.cut_patches.size() && hand.cut_patches[i]);
    model.patches.push_back(patch);
    model.patch_area_m2 += patch.area;
  }
  for (const Vec3& vertex : closed.vertices)
    model.radius_m = std::max(model.radius_m, (vertex - solid.centroid).norm());
  return model;
}

FitModel thinned(const FitModel& model, int step) {
  FitModel thin = model;
  thin.patches.clear();
  double area = 0;
  for (std::size_t i = 0; i < model.patches.size(); i += static_cast<std::size_t>(step)) {
    thin.patches.push_back(model.patches[i]);
    area += model.patches[i].area;
  }
  for (GpuPatch& patch : thin.patches)
    patch.area = static_cast<float>(patch.area * model.patch_area_m2 / area);
  return thin;
}

HandPoseFrame poseFrame(const FitModel& model, const Workspace& workspace) {
  return {model.center_of_mass, workspace.center};
}

GpuFit fitAt(const HandPose& start, const FitModel& model, const Workspace& workspace) {
  GpuFit fit{};
  fit.pose = gpuHandPose(start, poseFrame(model, workspace));
  return fit;
}

Fitter::Fitter(Gpu& gpu, const FitModel& model)
    : model_(model),
      kernel_(gpu, "fit", fit_comp, {gpu.reductionWorkgroup()}),
      patches_(gpu, model.patches) {}

void Fitter::record(Recorder& recorder, const DistanceField& field, const FieldGrid& grid,
                    const Buffer<GpuFit>& fits, std::uint32_t count, const FitLimits& limits) {
  FitArgs args{};
  args.patches = patches_;
  args.distances = field.entries();
  args.fits = fits;
  args.field_low = grid.low.cast<float>();
  args.cell_m = static_cast<float>(grid.cell_m);
  const Mat3& inertia = model_.inertia_m2;
  args.inertia_low = Vec3(inertia.diagonal()).cast<float>();
  args.inertia_high = Vec3(inertia(0, 1), inertia(0, 2), inertia(1, 2)).cast<float>();
  args.patch_area = static_cast<float>(model_.patch_area_m2);
  args.margin_m = static_cast<float>(kFitMargin * grid.cell_m);
  for (int k = 0; k < 3; ++k) args.field_size[k] = grid.place.size[k];
  args.patch_count = static_cast<std::uint32_t>(model_.patches.size());
  args.max_iterations = static_cast<std::uint32_t>(limits.iterations);
  recorder.dispatch(kernel_, args, count);
}

}  // namespace airclay
