// SPDX-License-Identifier: MIT
#include "engine/silhouette/evidence.h"

#include <algorithm>
#include <cmath>

#include "shaders/silhouette/background_adapt.comp.h"
#include "shaders/silhouette/evidence.comp.h"
#include "shaders/silhouette/evidence_background.comp.h"
#include "shaders/silhouette/evidence_cells.comp.h"
#include "shaders/silhouette/evidence_count.comp.h"
#include "shaders/silhouette/evidence_gain.comp.h"
#include "shaders/silhouette/evidence_histogram.comp.h"
#include "shaders/silhouette/evidence_mask.comp.h"
#include "shaders/silhouette/evidence_table.comp.h"
#include "shaders/silhouette/mask_image.comp.h"

namespace airclay {
namespace {

std::vector<std::uint32_t> constants(const GpuRig& rig, std::uint32_t workgroup = kEvidenceWorkgroup) {
  const auto [width, height] = rig.sameSize();
  return {workgroup, width, height};
}

}  // namespace

Evidence::Evidence(Gpu& gpu, const GpuRig& rig)
    : rig_(rig),
      background_kernel_(gpu, "evidence_background", evidence_background_comp, constants(rig)),
      gain_kernel_(gpu, "evidence_gain", evidence_gain_comp, constants(rig)),
      cell_kernel_(gpu, "evidence_cells", evidence_cells_comp, constants(rig)),
      evidence_kernel_(gpu, "evidence", evidence_comp, constants(rig)),
      count_kernel_(gpu, "evidence_count", evidence_count_comp, constants(rig)),
      histogram_kernel_(gpu, "evidence_histogram", evidence_histogram_comp, constants(rig)),
      table_kernel_(gpu, "evidence_table", evidence_table_comp, constants(rig)),
      mask_kernel_(gpu, "evidence_mask", evidence_mask_comp, constants(rig)),
      adapt_kernel_(gpu, "background_adapt", background_adapt_comp, constants(rig)),
      background_(gpu, rig.pixels() / 4),
      gains_(gpu, std::size_t(4) * rig.cameraCount(), Memory::kHost),
      regions_(gpu, rig.cameraCount(), Memory::kHost),
      no_regions_(gpu, std::vector<GpuTileRegion>(rig.cameraCount())),
      colours_(gpu, rig.pixels() / 4),
      evidence_(gpu, rig.pixels() / 16),
      counts_(gpu, 2 * kColourCounts),
      candidates_(gpu, std::vector<std::uint32_t>(rig.pixels())),
      sums_(gpu, std::size_t(kTileSums) * (rig.pixels() / 64)),
      histograms_(gpu, std::size_t(2) * kColourTable * rig.cameraCount()),
      tables_(gpu, std::size_t(2) * kColourTable * rig.cameraCount()) {
  forgetColours();
}

void Evidence::forgetColours() {
  std::vector<float> tables(tables_.count()), histograms(histograms_.count(), 1.0f / kColourTable);
  for (std::size_t i = 0; i < tables.size(); ++i)
    tables[i] = i / kColourTable % 2 == 0 ? kUnknownHandDensity : 1;
  tables_.upload(tables);
  histograms_.upload(histograms);
}

void Evidence::recordBackground(Recorder& recorder, const Buffer<std::uint32_t>& model,
                                const CameraRange& cameras) {
  EvidenceBackgroundArgs args{};
  args.cameras = rig_.cameras();
  args.model = model;
  args.cells = background_;
  args.first_camera = cameras.first;
  recorder.dispatch(background_kernel_, args, groupsFor(rig_.maxPixels() / 4, kEvidenceWorkgroup),
                    std::min(cameras.count, rig_.cameraCount() - cameras.first));
}

std::uint32_t Evidence::largestRegion() const {
  std::uint32_t tiles = 0;
  for (const GpuTileRegion& region : regions_.host())
    tiles = std::max(tiles, (region.high[0] - region.low[0]) * (region.high[1] - region.low[1]));
  return tiles;
}

void Evidence::record(Recorder& recorder, const Buffer<std::uint32_t>& images,
                      const Buffer<std::uint32_t>& model, std::span<const GpuTileRegion> regions,
                      const EvidenceAssumptions& assumptions) {
  std::ranges::copy(regions, regions_.host().begin());
  const std::uint32_t cameras = rig_.cameraCount(), tiles = largestRegion();

  EvidenceGainArgs gain{};
  gain.cameras = rig_.cameras();
  gain.images = images;
  gain.model = model;
  gain.gains = gains_;
  recorder.dispatch(gain_kernel_, gain, cameras);
  if (tiles == 0) return;

  EvidenceCellArgs cells{};
  cells.cameras = rig_.cameras();
  cells.images = images;
  cells.gains = gains_;
  cells.background = background_;
  cells.regions = regions_;
  cells.colours = colours_;
  cells.sums = sums_;
  recorder.dispatch(cell_kernel_, cells, groupsFor(tiles, kEvidenceWorkgroup), cameras);

  EvidenceArgs args{};
  args.cameras = rig_.cameras();
  args.background = background_;
  args.regions = regions_;
  args.colours = colours_;
  args.sums = sums_;
  args.tables = tables_;
  args.evidence = evidence_;
  args.least_light = static_cast<float>(assumptions.least_light);
  args.texture_trust = static_cast<float>(assumptions.texture_trust);
  recorder.dispatch(evidence_kernel_, args, groupsFor(kTileCells * tiles, kEvidenceWorkgroup), cameras);
}

void Evidence::recordLearning(Recorder& recorder, std::uint32_t camera, const Buffer<std::uint32_t>& masks,
                              const Buffer<vec4>& forearms, double rate) {
  const std::uint32_t tiles = largestRegion();
  if (tiles == 0) return;
  recorder.fill(counts_.raw(), 0);
  EvidenceCountArgs count{};
  count.cameras = rig_.cameras();
  count.regions = regions_;
  count.colours = colours_;
  count.evidence = evidence_;
  count.masks = masks;
  count.forearms = forearms;
  count.counts = counts_;
  count.camera = camera;
  recorder.dispatch(count_kernel_, count, groupsFor(kTileCells * tiles, kEvidenceWorkgroup));

  EvidenceHistogramArgs histogram{};
  histogram.counts = counts_;
  histogram.histograms = histograms_;
  histogram.camera = camera;
  histogram.rate = static_cast<float>(rate);
  recorder.dispatch(histogram_kernel_, histogram, groupsFor(kColourTable, kEvidenceWorkgroup), 2);

  EvidenceTableArgs table{};
  table.histograms = histograms_;
  table.tables = tables_;
  table.camera = camera;
  recorder.dispatch(table_kernel_, table, groupsFor(kColourBins * kColourBins, kEvidenceWorkgroup), 2);
}

void Evidence::recordAdaptation(Recorder& recorder, const Buffer<std::uint32_t>& images,
                                const Buffer<std::uint32_t>& model, bool has_hand) {
  BackgroundAdaptArgs args{};
  args.cameras = rig_.cameras();
  args.images = images;
  args.gains = gains_;
  args.regions = has_hand ? regions_ : no_regions_;
  args.model = model;
  args.candidates = candidates_;
  args.cells = background_;
  args.phase = adapted_frames_++ % kAdaptRows;
  const std::uint32_t cells = rig_.maxPixels() / 4 / kAdaptRows + rig_.maxRowWords() * 16;
  recorder.dispatch(adapt_kernel_, args, groupsFor(cells, kEvidenceWorkgroup), rig_.cameraCount());
}

void Evidence::resetAdaptation() {
  adapted_frames_ = 0;
  candidates_.upload(std::vector<std::uint32_t>(candidates_.count()));
}

void Evidence::recordMasks(Recorder& recorder, const Buffer<std::uint32_t>& masks) {
  EvidenceMaskArgs args{};
  args.cameras = rig_.cameras();
  args.regions = regions_;
  args.evidence = evidence_;
  args.masks = masks;
  const std::uint32_t words = rig_.maxRowWords() * ((rig_.maxRows() + 1) / 2);
  recorder.dispatch(mask_kernel_, args, groupsFor(words, kEvidenceWorkgroup), rig_.cameraCount());
}

GpuTileRegion Evidence::wholeImage(std::size_t camera) const {
  const auto [columns, rows] = tilesOf(rig_.camera(camera));
  return {{0, 0}, {columns, rows}};
}

GpuTileRegion Evidence::regionAround(std::size_t camera, const Eigen::AlignedBox2d& pixels) const {
  GpuTileRegion region = wholeImage(camera);
  for (int k = 0; k < 2; ++k) {
    const double tiles = region.high[k];
    const double low = std::clamp(std::floor(pixels.min()[k] / kEvidenceTile), 0.0, tiles);
    const double high = std::clamp(std::ceil(pixels.max()[k] / kEvidenceTile), low, tiles);
    region.low[k] = static_cast<std::uint32_t>(low);
    region.high[k] = static_cast<std::uint32_t>(high);
  }
  return region;
}

MaskImages::MaskImages(Gpu& gpu, const GpuRig& rig)
    : rig_(rig),
      kernel_(gpu, "mask_image", mask_image_comp, constants(rig)),
      images_(gpu, rig.imageWords()),
      background_(gpu, rig.pixels()) {
  const auto spread = static_cast<std::uint32_t>(kMinSpread / kSpreadStep);
  background_.upload(std::vector<std::uint32_t>(background_.count(), spread << 24));
}

void MaskImages::record(Recorder& recorder, const Buffer<std::uint32_t>& masks) {
  MaskImageArgs args{};
  args.cameras = rig_.cameras();
  args.masks = masks;
  args.images = images_;
  const std::size_t words = (std::size_t(3) * rig_.maxPixels() + 3) / 4;
  const std::uint32_t groups = groupsFor(words, kEvidenceWorkgroup);
  recorder.dispatch(kernel_, args, groups, rig_.cameraCount());
}

}  // namespace airclay
