// SPDX-License-Identifier: MIT
// A rig in device memory: its cameras, and the memory layout of their masks and images.
#pragma once

#include "engine/camera/rig.h"
#include "engine/camera/silhouette_image.h"
#include "engine/gpu/buffer.h"
#include "shaders/camera/camera_io.h"

namespace airclay {

/// The cameras of a rig in device memory. Kernels work in the workspace frame: the world frame moved to the
/// cube's centre.
class GpuRig {
 public:
  /// \throw Error for more than kMaxCameras cameras.
  GpuRig(Gpu& gpu, const Rig& rig);

  const Rig& rig() const { return rig_; }
  std::uint32_t cameraCount() const { return static_cast<std::uint32_t>(rig_.cameras.size()); }
  const Buffer<GpuCamera>& cameras() const { return cameras_; }
  const GpuCamera& camera(std::size_t index) const { return host_cameras_[index]; }

  /// 32-bit words of all masks together (camera_io.h defines their layout).
  std::uint32_t maskWords() const { return mask_words_; }
  /// Tile entries of all masks together (carve_io.h), and the largest number of 128-pixel bands of any
  /// camera.
  std::uint32_t tileEntries() const { return tile_entries_; }
  std::uint32_t maxBands() const { return max_bands_; }
  /// 32-bit words of all images together: BGR bytes, rows without padding, each image aligned to a word; plus
  /// one word, so that a kernel can read four bytes at any offset.
  std::uint32_t imageWords() const { return image_words_ + 1; }
  /// Pixels of all images together.
  std::uint32_t pixels() const { return pixels_; }
  /// The largest number of pixels of any camera.
  std::uint32_t maxPixels() const { return max_pixels_; }
  /// A camera's image within a buffer of imageWords().
  std::span<std::uint8_t> image(std::span<std::uint32_t> images, std::size_t camera) const {
    const GpuCamera& c = host_cameras_[camera];
    return {reinterpret_cast<std::uint8_t*>(images.data() + c.image_words),
            std::size_t(3) * c.width * c.height};
  }
  /// The largest number of rows, and of words per row, of any camera's mask.
  std::uint32_t maxRows() const { return max_rows_; }
  std::uint32_t maxRowWords() const { return max_row_words_; }

  /// The image size common to all cameras; {0, 0} if they differ. Specialization constants 1 and 2 of
  /// image.glsl.
  std::array<std::uint32_t, 2> sameSize() const;
  /// One bit per lens kind in use: lens.glsl's kLenses.
  std::uint32_t lensKinds() const;

  /// Packs masks, one per camera, to one bit per pixel. \pre each mask has its camera's size
  void pack(const std::vector<Silhouette>& masks, std::span<std::uint32_t> words) const;
  /// The inverse of pack().
  std::vector<Silhouette> unpack(std::span<const std::uint32_t> words) const;

 private:
  Rig rig_;
  std::vector<GpuCamera> host_cameras_;
  Buffer<GpuCamera> cameras_;
  std::uint32_t mask_words_ = 0, tile_entries_ = 0, max_bands_ = 0, max_rows_ = 0, max_row_words_ = 0,
                image_words_ = 0, pixels_ = 0, max_pixels_ = 0;
};

/// Converts a camera for the kernels; leaves the memory layout at 0.
GpuCamera gpuCamera(const Camera& camera, const Workspace& workspace);

}  // namespace airclay
