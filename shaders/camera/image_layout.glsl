// SPDX-License-Identifier: MIT
// How a camera's picture and mask lie in memory. Where all cameras have one size it is specialized, so that nothing is loaded: a load
// costs as much as thirty operations on lavapipe.

#include "shaders/camera/camera_io.h"

layout(constant_id = 1) const uint kSameWidth = 0;  // of every camera; 0 when they differ
layout(constant_id = 2) const uint kSameHeight = 0;

struct Picture {
  uint width, height, row_words;
  uint mask_words;     // words before the mask
  uint picture_words;  // words before the picture
  uint pixels_before;
  uint first_entry;    // tiles' entries before its own
};

Picture pictureOf(ReadCameras cameras, uint index) {
  Picture picture;
  if (kSameWidth != 0) {
    picture.width = kSameWidth;
    picture.height = kSameHeight;
    picture.row_words = (kSameWidth + 63) / 64 * 2;
    picture.mask_words = index * picture.row_words * kSameHeight;
    picture.picture_words = index * ((3 * kSameWidth * kSameHeight + 7) / 8 * 2);
    picture.pixels_before = index * kSameWidth * kSameHeight;
    picture.first_entry = index * ((kSameWidth + 127) / 128) * ((kSameHeight + 15) / 16 * 5);
  } else {
    picture.width = cameras.at[index].width;
    picture.height = cameras.at[index].height;
    picture.row_words = cameras.at[index].row_words;
    picture.mask_words = cameras.at[index].mask_words;
    picture.picture_words = cameras.at[index].picture_words;
    picture.pixels_before = cameras.at[index].pixels_before;
    picture.first_entry = cameras.at[index].first_entry;
  }
  return picture;
}
