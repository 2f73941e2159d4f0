// SPDX-License-Identifier: MIT
// How a camera's image and mask are laid out in memory. If all cameras have the same size, the layout is specialized and nothing is loaded:
// a load costs as much as thirty operations on lavapipe.

#include "shaders/camera/camera_io.h"

layout(constant_id = 1) const uint kSameWidth = 0;  // of every camera; 0 when they differ
layout(constant_id = 2) const uint kSameHeight = 0;

struct ImageLayout {
  uint width, height, row_words;
  uint mask_words;     // words before the mask
  uint image_words;  // words before the image
  uint pixels_before;
  uint first_entry;    // tile entries before this camera's
};

ImageLayout imageLayoutOf(ReadCameras cameras, uint index) {
  ImageLayout image;
  if (kSameWidth != 0) {
    image.width = kSameWidth;
    image.height = kSameHeight;
    image.row_words = (kSameWidth + 63) / 64 * 2;
    image.mask_words = index * image.row_words * kSameHeight;
    image.image_words = index * ((3 * kSameWidth * kSameHeight + 7) / 8 * 2);
    image.pixels_before = index * kSameWidth * kSameHeight;
    image.first_entry = index * ((kSameWidth + 127) / 128) * ((kSameHeight + 15) / 16 * 5);
  } else {
    image.width = cameras.at[index].width;
    image.height = cameras.at[index].height;
    image.row_words = cameras.at[index].row_words;
    image.mask_words = cameras.at[index].mask_words;
    image.image_words = cameras.at[index].image_words;
    image.pixels_before = cameras.at[index].pixels_before;
    image.first_entry = cameras.at[index].first_entry;
  }
  return image;
}
