// SPDX-License-Identifier: MIT
// Draws a person's mesh as a camera sees it, from many samples per pixel: each sample has its own instant and
// its own place within the pixel, so edges are smooth and motion blurs.
#pragma once

#include "engine/synthetic/person.h"
#include "engine/synthetic/room_scene.h"

namespace airclay {

/// The colours of skin, shirt and hair.
class FigureColors {
 public:
  explicit FigureColors(const RoomOptions& options);
  /// Linear, without light. `texture` as in FigureMesh.
  Vec3f albedo(Material material, const Vec3f& texture) const;

 private:
  NoiseVolume noise_;
  Vec3f skin_, shirt_, shirt_stripe_, hair_;
  int pattern_;
  float stripe_m_;
};

class FigureView {
 public:
  /// `camera` has the room's frame in place of the world; `mesh` and `colors` must outlive this.
  FigureView(const Camera& camera, const FigureMesh& mesh, const FigureColors& colors);

  /// Starts an image. `light`: received by each vertex, linear.
  void begin(const std::vector<Vec3f>& light);
  /// Adds one sample of every pixel: the pixel's centre plus `offset` (pixels), in front of what is at
  /// `depth_m`.
  void addSample(const BonePoses& poses, const Vec2& offset, const std::vector<float>& depth_m);

  /// The rows and columns that may contain the figure, the last exclusive.
  int left() const { return left_; }
  int right() const { return right_; }
  int top() const { return top_; }
  int bottom() const { return bottom_; }
  /// Per pixel, row by row: the sum over the samples of linear light, and how many show the figure, and the
  /// hand. Only inside the bounds.
  const std::vector<Vec3f>& light() const { return light_; }
  const std::vector<std::uint8_t>& figureSamples() const { return figure_samples_; }
  const std::vector<std::uint8_t>& handSamples() const { return hand_samples_; }

 private:
  struct ScreenVertex {
    float x, y, z;  ///< pixels; depth, NaN where the lens does not see it
  };
  void project(const BonePoses& poses);
  void chooseFacing();
  void drawTriangle(std::uint32_t index, const Vec2& offset, const std::vector<float>& limit_m);
  void shade(const Vec2& offset);
  /// The light of a triangle at a place in the image.
  Vec3f lightAt(std::uint32_t triangle, float x, float y) const;

  Camera camera_;
  const FigureMesh& mesh_;
  const FigureColors& colors_;
  std::vector<ScreenVertex> screen_;
  std::array<std::optional<Pose>, kBones> projected_;
  std::vector<std::uint32_t>
      facing_;  ///< the triangles that may face the camera during this image's exposure
  std::vector<Vec3f> vertex_light_;
  std::vector<float> depth_m_;
  std::vector<std::uint32_t> triangle_;  ///< 1-based; 0: none
  std::vector<Vec3f> light_;
  std::vector<Vec3f> shaded_;              ///< the last sample's light
  std::vector<Material> shaded_material_;  ///< and its material; kHandSkin: none to use again
  int sample_ = 0;                         ///< of this image
  std::vector<std::uint8_t> figure_samples_, hand_samples_;
  int left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  ///< of all samples
};

}  // namespace airclay
