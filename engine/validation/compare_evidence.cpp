// SPDX-License-Identifier: MIT
// The kernels of the evidence against their references, on the demo's images.
#include <algorithm>
#include <functional>

#include "engine/silhouette/cell_reference.h"
#include "engine/validation/compare_scene.h"

namespace airclay {
namespace {

constexpr double kRate = 0.75;  // of learning: the old histogram counts as well

void submit(OutlineScene& s, const std::function<void(Recorder&)>& record) {
  s.scene.recorder.begin();
  record(s.scene.recorder);
  s.scene.recorder.submitAndWait();
}

std::vector<GpuTileRegion> wholeImages(const OutlineScene& s) {
  std::vector<GpuTileRegion> regions;
  for (std::size_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) regions.push_back(s.evidence.wholeImage(c));
  return regions;
}

std::vector<GpuTileRegion> handRegions(const OutlineScene& s) {
  std::vector<GpuTileRegion> regions;
  for (std::size_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) {
    Eigen::AlignedBox2d box;
    for (const auto& pixel :
         projectReference(s.scene.rig.cameras[c], s.scene.rig.workspace, s.fitter.model(), s.truth))
      if (pixel) box.extend(*pixel);
    regions.push_back(s.evidence.regionAround(c, box));
  }
  return regions;
}

void recordEvidence(OutlineScene& s, const std::vector<GpuTileRegion>& regions,
                    const EvidenceAssumptions& assumptions) {
  submit(s,
         [&](Recorder& recorder) { s.evidence.record(recorder, s.images, s.model, regions, assumptions); });
}

template <class Visit>
void forEachCell(const GpuTileRegion& region, Visit visit) {
  const int n = kTileCells;
  for (int y = n * int(region.low[1]); y < n * int(region.high[1]); ++y)
    for (int x = n * int(region.low[0]); x < n * int(region.high[0]); ++x) visit(x, y);
}

void compareCellBackground(OutlineScene& s, Comparisons& comparisons) {
  submit(s, [&](Recorder& recorder) { s.evidence.recordBackground(recorder, s.model); });
  const std::vector<std::uint32_t> model = s.model.download();
  const std::vector<GpuCellBackground> cells = s.evidence.background().download();
  double error = 0;
  for (std::size_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) {
    const GpuCamera& camera = s.scene.gpu_rig.camera(c);
    const int columns = int(kTileCells * tilesOf(camera)[0]);
    forEachCell(s.evidence.wholeImage(c), [&](int x, int y) {
      const CellBackground expected =
          cellBackgroundReference(int(camera.width), std::span(model).subspan(camera.pixels_before), x, y);
      const GpuCellBackground& found = s.cells(cells, c)[std::size_t(y * columns + x)];
      for (int k = 0; k < 3; ++k)
        error = maxOrNan(error,
                         beyondRounding(unpackColour(found.colour)[k], expected.colour[k], kCellColourStep));
      error = maxOrNan(error, std::abs(found.variance - expected.variance));
    });
  }
  comparisons.add("cell background, grey levels", error, 1e-4);
}

/// Gains, colours and sums of the whole images. Colours are compared for the kernel's gains.
void compareColours(OutlineScene& s, Comparisons& comparisons) {
  const std::vector<std::uint32_t> model = s.model.download();
  const std::vector<std::uint32_t> colours = s.evidence.colours().download();
  const std::vector<GpuCellBackground> background = s.evidence.background().download();
  const std::vector<float> sums = s.evidence.sums().download();
  double gain_error = 0, colour_error = 0, sum_error = 0;
  for (std::size_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) {
    const GpuCamera& camera = s.scene.gpu_rig.camera(c);
    const std::vector<std::uint8_t> image = s.scene.image(s.images.host(), c);
    const int width = int(camera.width), height = int(camera.height);
    const std::uint32_t columns = tilesOf(camera)[0];
    const Vec3 gain = Eigen::Map<const vec3>(&s.evidence.gains().host()[4 * c]).cast<double>();
    const Vec3 expected = gainReference(width, height, image, std::span(model).subspan(camera.pixels_before));
    gain_error = maxOrNan(gain_error, (gain - expected).cwiseAbs().maxCoeff());
    const auto own = s.cells(colours, c);
    forEachCell(s.evidence.wholeImage(c), [&](int x, int y) {
      const Vec3 found = unpackColour(own[std::size_t(y * int(kTileCells * columns) + x)]);
      const Vec3 mean = cellColourReference(width, image, gain, x, y);
      for (int k = 0; k < 3; ++k)
        colour_error = maxOrNan(colour_error, beyondRounding(found[k], mean[k], kCellColourStep));
      if (x % int(kTileCells) != 0 || y % int(kTileCells) != 0) return;
      const int tile_x = x / int(kTileCells), tile_y = y / int(kTileCells);
      const Vec3 exact = tileSumsReference(own, s.cells(background, c), columns, tile_x, tile_y);
      const float* tile =
          &sums[kTileSums * (firstTile(camera) + std::size_t(tile_y * int(columns) + tile_x))];
      const Vec3 sum = Eigen::Map<const vec3>(tile).cast<double>();
      sum_error = maxOrNan(sum_error, (sum - exact).norm() / exact.norm());
    });
  }
  // a ratio at the border of a bin may fall into either: 1/256 for one of 1200 pixels
  comparisons.add("gains", gain_error, 1e-4);
  comparisons.add("cell colours, grey levels", colour_error, 1e-3);
  comparisons.add("tile sums, relative", sum_error, 1e-6);
}

/// The largest error of the logarithm, beyond the rounding of a byte. NaN if a clear change is not marked.
double evidenceError(const OutlineScene& s, const EvidenceAssumptions& assumptions) {
  const std::vector<std::uint32_t> colours = s.evidence.colours().download();
  const std::vector<std::uint32_t> evidence = s.evidence.evidence().download();
  const std::vector<GpuCellBackground> background = s.evidence.background().download();
  const std::vector<float> sums = s.evidence.sums().download(), tables = s.evidence.tables().download();
  double error = 0;
  for (std::size_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) {
    const GpuCamera& camera = s.scene.gpu_rig.camera(c);
    const GpuTileRegion region = s.evidence.regions().host()[c];
    const std::uint32_t columns = tilesOf(camera)[0];
    const auto own_sums = std::span(sums).subspan(std::size_t(kTileSums) * firstTile(camera));
    const auto table = std::span(tables).subspan(2 * c * kColourTable);
    forEachCell(region, [&](int x, int y) {
      const auto cell = std::size_t(y * int(kTileCells * columns) + x);
      const GpuCellBackground& mean = s.cells(background, c)[cell];
      const Vec3 seen = unpackColour(s.cells(colours, c)[cell]);
      const double light = lightReference(own_sums, columns, region, x, y, assumptions.least_light);
      const double noise = mean.variance + std::pow(kTextureNoise * seen.mean(), 2);
      const double texture = textureReference(own_sums, columns, region, x, y, noise, assumptions);
      const std::size_t bin = colourBin(seen);
      const CellEvidence expected = evidenceReference(seen, unpackColour(mean.colour), mean.variance, light,
                                                      texture, table[bin], table[kColourTable + bin]);
      const std::uint8_t found = s.evidenceBytes(evidence, c)[cell];
      error = maxOrNan(error, beyondRounding(evidenceOf(found), expected.log_ratio, 1.0 / kEvidenceSteps));
      if (std::abs(expected.change - 1) > 0.01 && (found % 2 == 1) != (expected.change > 1)) error = NAN;
    });
  }
  return error;
}

/// Learns the colours of each camera from the hand at its true pose.
void compareLearning(OutlineScene& s, Comparisons& comparisons) {
  s.fit(s.truth, {1, false, 10, 4}, {});
  const std::vector<std::uint32_t> colours = s.evidence.colours().download();
  const std::vector<std::uint32_t> evidence = s.evidence.evidence().download();
  const std::vector<Silhouette> masks = s.scene.gpu_rig.unpack(s.fitter.masks().download());
  double different = 0, histogram_error = 0, table_error = 0;
  for (std::uint32_t c = 0; c < s.scene.gpu_rig.cameraCount(); ++c) {
    const std::vector<float> before = s.evidence.histograms().download();
    submit(s, [&](Recorder& recorder) {
      s.evidence.recordLearning(recorder, c, s.fitter.masks(), s.fitter.forearms(), kRate);
    });
    const std::vector<std::uint32_t> counts = s.evidence.counts().download();
    const std::vector<float> after = s.evidence.histograms().download(),
                             tables = s.evidence.tables().download();
    const vec4 from = s.fitter.forearms().host()[2 * c], to = s.fitter.forearms().host()[2 * c + 1];
    ColourView view{s.evidence.regions().host()[c],
                    s.cells(colours, c),
                    s.evidenceBytes(evidence, c),
                    masks[c],
                    from.head<2>().cast<double>(),
                    to.head<2>().cast<double>(),
                    from[2]};
    // cells at the forearm's border may count or not
    view.arm_radius += 1e-3;
    const std::vector<std::uint32_t> least = colourCountsReference(view);
    view.arm_radius -= 2e-3;
    const std::vector<std::uint32_t> most = colourCountsReference(view);
    if (least[kColourTable] < kMinColours) different = NAN;  // nothing was learned
    for (std::size_t i = 0; i < counts.size(); ++i) different += counts[i] < least[i] || counts[i] > most[i];
    for (std::size_t h = 0; h < 2; ++h) {
      const std::size_t first = (2 * c + h) * kColourTable;
      const auto own = [&](const std::vector<float>& all) {
        return std::span(all).subspan(first, kColourTable);
      };
      const std::vector<double> expected =
          histogramReference(own(before), std::span(counts).subspan(h * kColourCounts), kRate);
      const std::vector<double> table =
          colourTableReference(own(after), h == 0 ? kHandUniform : kOtherUniform);
      for (std::size_t i = 0; i < kColourTable; ++i) {
        histogram_error = maxOrNan(histogram_error, std::abs(after[first + i] - expected[i]));
        table_error = maxOrNan(table_error, std::abs(tables[first + i] - table[i]) / table[i]);
      }
    }
  }
  comparisons.add("colour counts, bins", different, 0);
  comparisons.add("colour histograms", histogram_error, 1e-6);
  comparisons.add("colour tables, relative", table_error, 1e-5);
}

void compareEvidenceMasks(OutlineScene& s, Comparisons& comparisons) {
  const GpuRig& rig = s.scene.gpu_rig;
  const Buffer<std::uint32_t> masks(s.scene.gpu, rig.maskWords());
  MaskImages mask_images(s.scene.gpu, rig);
  submit(s, [&](Recorder& recorder) {
    s.evidence.recordMasks(recorder, masks);
    mask_images.record(recorder, masks);
  });
  const std::vector<std::uint32_t> evidence = s.evidence.evidence().download();
  const std::vector<std::uint32_t> images = mask_images.images().download();
  const std::vector<Silhouette> found = rig.unpack(masks.download());
  std::size_t set = 0, different = 0, image_different = 0;
  for (std::size_t c = 0; c < found.size(); ++c) {
    const Silhouette expected = evidenceMaskReference(s.scene.rig.cameras[c], s.evidence.regions().host()[c],
                                                      s.evidenceBytes(evidence, c));
    const std::vector<std::uint8_t> image = s.scene.image(images, c), exact = maskImageReference(found[c]);
    for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
      different += expected.pixels[i] != found[c].pixels[i];
      set += expected.pixels[i] != 0;
    }
    for (std::size_t i = 0; i < exact.size(); ++i) image_different += image[i] != exact[i];
  }
  comparisons.add("evidence mask, pixels", set > 0 ? double(different) : NAN, 0);
  comparisons.add("mask as image, bytes", double(image_different), 0);
}

/// Adapts a copy of the background outside the hand's regions, as often as it takes to replace a colour.
void compareAdaptation(OutlineScene& s, Comparisons& comparisons) {
  const GpuRig& rig = s.scene.gpu_rig;
  const std::vector<GpuTileRegion> regions = handRegions(s);
  recordEvidence(s, regions, {});
  std::vector<std::uint32_t> before = s.model.download();
  // another background at one pixel in five: it is replaced
  for (std::size_t i = 0; i < before.size(); i += 5) before[i] ^= 0x404040;
  const Buffer<std::uint32_t> model(s.scene.gpu, before);
  for (std::uint32_t visit = 0; visit <= kAdaptVisits; ++visit)
    submit(s, [&](Recorder& recorder) {
      for (std::uint32_t phase = 0; phase < kAdaptRows; ++phase)
        s.evidence.recordAdaptation(recorder, s.images, model, true);
    });
  double different = 0, replaced = 0, cell_error = 0;
  const std::vector<std::uint32_t> found = model.download();
  const std::vector<GpuCellBackground> cells = s.evidence.background().download();
  for (std::size_t c = 0; c < rig.cameraCount(); ++c) {
    const GpuCamera& camera = rig.camera(c);
    const std::vector<std::uint8_t> image = s.scene.image(s.images.host(), c);
    const Vec3 gain = Eigen::Map<const vec3>(&s.evidence.gains().host()[4 * c]).cast<double>();
    const int columns = int(kTileCells * tilesOf(camera)[0]);
    forEachCell(s.evidence.wholeImage(c), [&](int x, int y) {
      const int tile_x = x / int(kTileCells), tile_y = y / int(kTileCells);
      const GpuTileRegion& region = regions[c];
      if (tile_x >= int(region.low[0]) && tile_x < int(region.high[0]) && tile_y >= int(region.low[1]) &&
          tile_y < int(region.high[1]))
        return;
      for (int k = 0; k < 4; ++k) {
        const auto pixel = std::size_t((2 * y + k / 2) * int(camera.width) + 2 * x + k % 2);
        const std::size_t index = camera.pixels_before + pixel;
        Vec3 seen;
        for (int channel = 0; channel < 3; ++channel)
          seen[channel] = image[3 * pixel + std::size_t(channel)] / gain[channel];
        AdaptedPixel own{before[index], 0};
        for (std::uint32_t visit = 0; visit <= kAdaptVisits; ++visit) own = adaptReference(own, seen);
        // a colour at the border of two grey levels may be rounded to either
        const Vec3 fraction = seen - seen.array().floor().matrix();
        const bool is_clear = (fraction - Vec3::Constant(0.5)).cwiseAbs().minCoeff() > 1e-4;
        different += is_clear && own.model != found[index];
        replaced += index % 5 == 0 && own.model != before[index];
      }
      const CellBackground exact =
          cellBackgroundReference(int(camera.width), std::span(found).subspan(camera.pixels_before), x, y);
      const GpuCellBackground& cell = s.cells(cells, c)[std::size_t(y * columns + x)];
      for (int k = 0; k < 3; ++k)
        cell_error = maxOrNan(cell_error,
                              beyondRounding(unpackColour(cell.colour)[k], exact.colour[k], kCellColourStep));
    });
  }
  comparisons.add("adapted background, pixels", replaced > 0 ? different : NAN, 0);
  comparisons.add("adapted cells, grey levels", cell_error, 1e-4);
  submit(s, [&](Recorder& recorder) { s.evidence.recordBackground(recorder, s.model); });
}

}  // namespace

void compareEvidence(OutlineScene& s, Comparisons& comparisons) {
  compareCellBackground(s, comparisons);
  recordEvidence(s, wholeImages(s), {});
  compareColours(s, comparisons);
  double error = evidenceError(s, {});
  compareLearning(s, comparisons);
  const EvidenceAssumptions textured{kDaylight, kTextureTrust};
  recordEvidence(s, handRegions(s), textured);
  error = maxOrNan(error, evidenceError(s, textured));
  compareEvidenceMasks(s, comparisons);
  compareAdaptation(s, comparisons);
  recordEvidence(s, wholeImages(s), {});
  error = maxOrNan(error, evidenceError(s, {}));
  // residuals are differences of sums in single precision; a step of the stored logarithm is 0.06
  comparisons.add("evidence", error, 0.01);
}

}  // namespace airclay
