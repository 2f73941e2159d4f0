// SPDX-License-Identifier: MIT
#include "app/session/tracking_debug.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/cli/output_paths.h"
#include "app/session/contact_sheet.h"

namespace airclay {
namespace {

using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb kSilhouette = {240, 210, 60}, kTracked = {60, 220, 90}, kUncertain = {255, 150, 40},
              kLost = {240, 60, 60};
constexpr int kPanelWidth = 480;  // pixels
constexpr int kGap = ContactSheet::kGap / 2;

void setPixel(RgbaImage& image, int x, int y, const Rgb& color) {
  if (x < 0 || y < 0 || x >= image.size.width || y >= image.size.height) return;
  std::copy(color.begin(), color.end(), image.rgba.begin() + 4 * (std::ptrdiff_t(y) * image.size.width + x));
}

void drawLine(RgbaImage& image, const Vec2& from, const Vec2& to, const Rgb& color) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).cwiseAbs().maxCoeff())));
  if (steps > image.size.width + image.size.height) return;
  for (int i = 0; i <= steps; ++i) {
    const Vec2 at = from + (to - from) * (double(i) / steps);
    setPixel(image, static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())), color);
  }
}

/// The edges between front and back faces of the hand.
void drawHand(RgbaImage& image, const Camera& camera, const OutlineModel& model, const HandFit& fit,
              const Rgb& color) {
  std::vector<std::optional<Vec2>> pixels;
  for (const vec3& vertex : model.vertices) {
    const Vec3 in_hand = fit.scale * (vertex.cast<double>() + model.center_of_mass);
    pixels.push_back(
        projectThroughLens(camera.lens, camera.camera_from_world * (fit.pose.world_from_hand * in_hand)));
  }
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  for (const GpuOutlineEdge& edge : model.edges) {
    const auto &from = pixels[edge.from], &to = pixels[edge.to];
    const auto &left = pixels[edge.left], &right = pixels[edge.right];
    if (!from || !to || !left || !right) continue;
    if ((cross(*to - *from, *left - *from) < 0) != (cross(*from - *to, *right - *to) < 0))
      drawLine(image, *from, *to, color);
  }
}

void drawMaskOutline(RgbaImage& image, const Silhouette& mask) {
  for (int y = 1; y + 1 < mask.height; ++y)
    for (int x = 1; x + 1 < mask.width; ++x)
      if (mask.contains(x, y) && !(mask.contains(x - 1, y) && mask.contains(x + 1, y) &&
                                   mask.contains(x, y - 1) && mask.contains(x, y + 1)))
        setPixel(image, x, y, kSilhouette);
}

const Rgb& colorOf(HandState state) {
  return state == HandState::kTracked ? kTracked : state == HandState::kUncertain ? kUncertain : kLost;
}

RgbaImage blank(const Camera& camera, std::uint8_t level) {
  RgbaImage image{{camera.width, camera.height}, {}};
  image.rgba.assign(std::size_t(4) * std::size_t(camera.width) * std::size_t(camera.height), level);
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

}  // namespace

RgbaImage trackingOverlay(const Pipeline& pipeline, std::size_t camera, const Silhouette& mask,
                          const OutlineModel& model, const FrameResult& result) {
  const Camera& view = pipeline.rig().cameras[camera];
  RgbaImage image = blank(view, 0);
  const std::span<const std::uint8_t> bgr = pipeline.image(camera);
  for (std::size_t i = 0; i < bgr.size() / 3; ++i)
    for (std::size_t c = 0; c < 3; ++c) image.rgba[4 * i + c] = bgr[3 * i + 2 - c];
  drawMaskOutline(image, mask);
  for (const HandFit& fit : result.hands) drawHand(image, view, model, fit, colorOf(result.state()));
  return image;
}

RgbaImage evidenceImage(const Pipeline& pipeline, std::size_t camera, std::span<const std::uint32_t> words) {
  RgbaImage image = blank(pipeline.rig().cameras[camera], 128);
  const Evidence* evidence = pipeline.evidence();
  if (!evidence || words.empty()) return image;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
  const GpuCamera& layout = pipeline.gpuRig().camera(camera);
  const GpuTileRegion& region = evidence->regions().host()[camera];
  const std::uint32_t columns = kTileCells * tilesOf(layout)[0];
  for (std::uint32_t y = kTileCells * region.low[1]; y < kTileCells * region.high[1]; ++y)
    for (std::uint32_t x = kTileCells * region.low[0]; x < kTileCells * region.high[0]; ++x) {
      const double ratio = evidenceOf(bytes[firstCell(layout) + y * columns + x]);
      const auto level = static_cast<std::uint8_t>(std::lround(255 / (1 + std::exp(-ratio))));
      for (int k = 0; k < 4; ++k)
        setPixel(image, int(2 * x) + k % 2, int(2 * y) + k / 2, {level, level, level});
    }
  return image;
}

TrackingDebug::TrackingDebug(const std::filesystem::path& folder, const HandModel& hand, double rate_hz)
    : folder_(folder), model_(outlineModel(hand)), rate_hz_(rate_hz) {
  makeFolder(folder);
}

void TrackingDebug::add(const Pipeline& pipeline, const PlayedFrame& frame) {
  const std::vector<Camera>& cameras = pipeline.rig().cameras;
  const int rows = static_cast<int>(cameras.size());
  const std::vector<Silhouette> masks = pipeline.gpuRig().unpack(pipeline.silhouettes().masks().host());
  std::vector<std::uint32_t> evidence;
  if (pipeline.evidence()) evidence = pipeline.evidence()->evidence().download();
  std::vector<RgbaImage> panels;
  int height = kGap;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const int width = std::min(kPanelWidth, cameras[k].width);
    const ImageSize size{width, std::max(1, cameras[k].height * width / cameras[k].width)};
    panels.push_back(reduced(trackingOverlay(pipeline, k, masks[k], model_, frame.result), size));
    panels.push_back(reduced(evidenceImage(pipeline, k, evidence), size));
  }
  // two cameras side by side
  for (int row = 0; row < rows; row += 2) height += panels[std::size_t(2 * row)].size.height + kGap;
  const int width = kGap + 4 * (kPanelWidth + kGap);
  ContactSheet sheet({width + width % 2, height + height % 2});
  int top = kGap;
  for (int row = 0; row < rows; ++row) {
    const int left = kGap + row % 2 * 2 * (kPanelWidth + kGap);
    sheet.lay(panels[std::size_t(2 * row)], left, top);
    sheet.lay(panels[std::size_t(2 * row + 1)], left + kPanelWidth + kGap, top);
    if (row % 2 == 1) top += panels[std::size_t(2 * row)].size.height + kGap;
  }
  char name[32];
  std::snprintf(name, sizeof name, "%06d.png", frame.frame);
  save(folder_ / name, sheet.image());
  if (!video_)
    video_ = std::make_unique<VideoWriter>(
        folder_ / "tracking.mp4",
        VideoWriter::Options{sheet.image().size, rate_hz_, VideoWriter::Format::kRgba8});
  video_->write(sheet.image().rgba);
}

void TrackingDebug::finish() {
  if (video_) video_->finish();
  video_.reset();
}

}  // namespace airclay
