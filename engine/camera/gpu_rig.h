// SPDX-License-Identifier: MIT
// A rig as the kernels take it: its cameras, and how their masks lie in memory.
#pragma once

#include "engine/camera/mask.h"
#include "engine/camera/rig.h"
#include "engine/gpu/buffer.h"
#include "shaders/camera/camera_io.h"

namespace airclay {

/// The cameras of a rig in device memory. The kernels' world is the workspace's frame: the world moved to the
/// cube's centre.
class GpuRig {
 public:
  /// \throw Error past kMaxCameras cameras.
  GpuRig(Gpu& gpu, const Rig& rig);

  const Rig& rig() const { return rig_; }
  std::uint32_t cameraCount() const { return static_cast<std::uint32_t>(rig_.cameras.size()); }
  const Buffer<GpuCamera>& cameras() const { return cameras_; }
  const GpuCamera& camera(std::size_t index) const { return host_cameras_[index]; }

  /// Words of all masks together (see camera_io.h for their layout).
  std::uint32_t maskWords() const { return mask_words_; }
  /// Entries of all masks' tiles (carve_io.h), and the largest number of any camera's bands of 128 pixels.
  std::uint32_t tileEntries() const { return tile_entries_; }
  std::uint32_t maxBands() const { return max_bands_; }
  /// Words of all images together: BGR bytes, rows without padding, each camera's image at a whole word;
  /// and one word more, so that a kernel may read four pixels from any byte.
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
  /// The largest number of rows, and of words a row, of any camera's mask.
  std::uint32_t maxRows() const { return max_rows_; }
  std::uint32_t maxRowWords() const { return max_row_words_; }

  /// The size that all cameras share, {0, 0} where they differ: specialization constants 1 and 2 of
  /// image.glsl.
  std::array<std::uint32_t, 2> sameSize() const;
  /// Bits of the kinds of lens there are: lens.glsl's kLenses.
  std::uint32_t lensKinds() const;

  /// Packs masks, one a camera, one bit a pixel. \pre sizes are the cameras'
  void pack(const std::vector<Mask>& masks, std::span<std::uint32_t> words) const;
  /// The inverse of pack().
  std::vector<Mask> unpack(std::span<const std::uint32_t> words) const;

 private:
  Rig rig_;
  std::vector<GpuCamera> host_cameras_;
  Buffer<GpuCamera> cameras_;
  std::uint32_t mask_words_ = 0, tile_entries_ = 0, max_bands_ = 0, max_rows_ = 0, max_row_words_ = 0,
                image_words_ = 0, pixels_ = 0, max_pixels_ = 0;
};

/// The kernels' form of a camera, all but the memory layout.
GpuCamera gpuCamera(const Camera& camera, const Workspace& workspace);

}  // namespace airclay
