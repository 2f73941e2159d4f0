// SPDX-License-Identifier: MIT
// Evidence for the hand in a real room: how much more likely each cell of 2 x 2 pixels is the hand than
// anything else, from the background in changing light and from colours learned while tracking
// (shaders/silhouette/evidence_io.h states the model).
//
// Sources: probabilities instead of masks after Franco and Boyer 2005, "Fusion of multi-view silhouette cues
// using a space occupancy grid"; appearance models shared by all views after Djelouah et al. 2013,
// "Multi-view object segmentation in space and time".
#pragma once

#include <span>

#include "engine/silhouette/silhouette.h"
#include "shaders/silhouette/evidence_io.h"

namespace airclay {

/// What explains a change of the background.
struct EvidenceAssumptions {
  double least_light = kFullShadow;  ///< the darkest shadow, as a factor of the background
  double texture_trust = 0;          ///< how much missing texture tells about a tile; 0 or kTextureTrust
};

class Evidence {
 public:
  Evidence(Gpu& gpu, const GpuRig& rig);

  /// Records the cells' background from the pixels' (Silhouettes::model()).
  void recordBackground(Recorder& recorder, const Buffer<std::uint32_t>& model,
                        const CameraRange& cameras = {});
  /// Records the evidence of a frame in one region per camera. `images` and `model` are in GpuRig's layout.
  void record(Recorder& recorder, const Buffer<std::uint32_t>& images, const Buffer<std::uint32_t>& model,
              std::span<const GpuTileRegion> regions, const EvidenceAssumptions& assumptions = {});
  /// Records learning the colours of one camera from the fitted hand's mask and forearm (outline_io.h), with
  /// the weight `rate` for the new colours. \pre record() of the same frame
  void recordLearning(Recorder& recorder, std::uint32_t camera, const Buffer<std::uint32_t>& masks,
                      const Buffer<vec4>& forearms, double rate);
  /// Records the adaptation of a part of the background to the frame's images, outside the regions if
  /// `has_hand`. `model` is Silhouettes::model(). \pre record() of the same frame
  void recordAdaptation(Recorder& recorder, const Buffer<std::uint32_t>& images,
                        const Buffer<std::uint32_t>& model, bool has_hand);
  /// Forgets the changes seen so far that may become the background. \pre nothing recorded is still running
  void resetAdaptation();
  /// Records a mask of the pixels that are more likely the hand than not. \pre record()
  void recordMasks(Recorder& recorder, const Buffer<std::uint32_t>& masks);
  /// Forgets the colours: any change may be the hand. \pre nothing recorded is still running
  void forgetColours();

  /// The region that covers a camera's image.
  GpuTileRegion wholeImage(std::size_t camera) const;
  /// The region around a box of pixels, clipped to the image.
  GpuTileRegion regionAround(std::size_t camera, const Eigen::AlignedBox2d& pixels) const;

  const Buffer<std::uint32_t>& evidence() const { return evidence_; }
  const Buffer<GpuTileRegion>& regions() const { return regions_; }
  const Buffer<float>& gains() const { return gains_; }
  // intermediate results, for comparison with the reference
  const Buffer<GpuCellBackground>& background() const { return background_; }
  const Buffer<std::uint32_t>& colours() const { return colours_; }
  const Buffer<float>& sums() const { return sums_; }
  const Buffer<float>& histograms() const { return histograms_; }
  const Buffer<float>& tables() const { return tables_; }
  const Buffer<std::uint32_t>& counts() const { return counts_; }

 private:
  std::uint32_t largestRegion() const;

  const GpuRig& rig_;
  Kernel<EvidenceBackgroundArgs> background_kernel_;
  Kernel<EvidenceGainArgs> gain_kernel_;
  Kernel<EvidenceCellArgs> cell_kernel_;
  Kernel<EvidenceArgs> evidence_kernel_;
  Kernel<EvidenceCountArgs> count_kernel_;
  Kernel<EvidenceHistogramArgs> histogram_kernel_;
  Kernel<EvidenceTableArgs> table_kernel_;
  Kernel<EvidenceMaskArgs> mask_kernel_;
  Kernel<BackgroundAdaptArgs> adapt_kernel_;
  Buffer<GpuCellBackground> background_;
  Buffer<float> gains_;
  Buffer<GpuTileRegion> regions_, no_regions_;
  Buffer<std::uint32_t> colours_, evidence_, counts_, candidates_;
  std::uint32_t adapted_frames_ = 0;
  Buffer<float> sums_, histograms_, tables_;
};

/// Masks in place of a camera's images: white on black, with a black background.
class MaskImages {
 public:
  MaskImages(Gpu& gpu, const GpuRig& rig);
  void record(Recorder& recorder, const Buffer<std::uint32_t>& masks);
  const Buffer<std::uint32_t>& images() const { return images_; }
  const Buffer<std::uint32_t>& background() const { return background_; }

 private:
  const GpuRig& rig_;
  Kernel<MaskImageArgs> kernel_;
  Buffer<std::uint32_t> images_, background_;
};

/// Tiles in a row and in a column of an image.
inline std::array<std::uint32_t, 2> tilesOf(const GpuCamera& camera) {
  return {camera.width / kEvidenceTile, camera.height / kEvidenceTile};
}
/// The first cell of a camera, and of a tile.
inline std::uint32_t firstCell(const GpuCamera& camera) {
  return 4 * (camera.pixels_before / 16);
}
inline std::uint32_t firstTile(const GpuCamera& camera) {
  return camera.pixels_before / 64;
}
/// A packed colour, and the log-likelihood ratio of an evidence byte.
inline Vec3 unpackColour(std::uint32_t word) {
  return kCellColourStep * Vec3(word & 1023, word >> 10 & 1023, word >> 20 & 1023);
}
inline double evidenceOf(std::uint8_t byte) {
  return ((byte >> 1) - double(kEvidenceZero)) / kEvidenceSteps;
}
/// The bin of a colour in the histograms.
std::uint32_t colourBin(const Vec3& colour);

// --- the reference implementation, in double precision, step by step ---

/// The gains of B, G and R of an image against the background. `image`: BGR bytes; `model`: one word per
/// pixel.
Vec3 gainReference(int width, int height, std::span<const std::uint8_t> image,
                   std::span<const std::uint32_t> model);
/// The mean colour of cell (x, y) after division by the gains.
Vec3 cellColourReference(int width, std::span<const std::uint8_t> image, const Vec3& gain, int x, int y);
/// The light factor of cell (x, y) from a region's sums of image times background and background squared.
/// `sums`: two per tile, row by row, `columns` tiles per row.
double lightReference(std::span<const float> sums, std::uint32_t columns, const GpuTileRegion& region, int x,
                      int y, double least_light = kFullShadow);

/// A pixel's background and its candidate (silhouette_io.h, BackgroundAdaptArgs) after a visit. `seen`: the
/// image's colour divided by the gains.
struct AdaptedPixel {
  std::uint32_t model = 0, candidate = 0;
};
AdaptedPixel adaptReference(const AdaptedPixel& before, const Vec3& seen);

struct CellEvidence {
  double log_ratio = 0;  ///< clipped at kMaxEvidence
  double change = 0;     ///< in units of kChangedResidual: changed from 1 on
};
/// The evidence of a cell. `hand` and `other`: densities of its colour relative to a uniform one.
/// `texture`: the increase of the residual by the tile's.
CellEvidence evidenceReference(const Vec3& seen, const Vec3& background, double variance, double light,
                               double texture, double hand, double other);
/// The smoothed densities of a histogram of kColourTable bins whose sum is 1.
std::vector<double> colourTableReference(std::span<const float> histogram, double uniform);

}  // namespace airclay
