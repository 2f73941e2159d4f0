// SPDX-License-Identifier: MIT
// Images through OpenCV's codecs. The file structure is checked here first (PNG: W3C specification, 5; JPEG:
// ITU T.81, B.1): the size before memory is allocated, and completeness because libpng and libjpeg write
// errors to standard error.
#include "capture/images/image_file.h"

#include <array>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "capture/images/quiet_opencv.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

using Bytes = std::vector<std::uint8_t>;

// 16384 x 16384 pixels in uncompressed 8-bit RGBA, the largest image of a rig.
constexpr std::uintmax_t kMaxFileBytes = 1u << 30;

Bytes readBytes(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw Error(file.string() + ": the image is missing or is not a readable file");
  if (size > kMaxFileBytes) throw Error(file.string() + ": the image file is larger than 1 GB");
  Bytes bytes(size);
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    throw Error(file.string() + ": the image cannot be read");
  return bytes;
}

std::uint32_t bigEndian(const Bytes& bytes, size_t at, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[at + static_cast<size_t>(i)];
  return value;
}

/// The CRC-32 of PNG's appendix D.
std::uint32_t crc32(const std::uint8_t* bytes, size_t count) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> remainders{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      std::uint32_t c = n;
      for (int bit = 0; bit < 8; ++bit) c = c & 1 ? 0xedb88320u ^ c >> 1 : c >> 1;
      remainders[n] = c;
    }
    return remainders;
  }();
  std::uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < count; ++i) crc = table[(crc ^ bytes[i]) & 0xff] ^ crc >> 8;
  return ~crc;
}

/// Reads the size in IHDR; true if all chunks up to IEND are complete and intact.
bool readPngFrame(const Bytes& bytes, ImageSize& size) {
  for (size_t at = 8; at + 12 <= bytes.size();) {
    const size_t length = bigEndian(bytes, at, 4);
    if (length > bytes.size() - at - 12) return false;
    if (crc32(&bytes[at + 4], length + 4) != bigEndian(bytes, at + 8 + length, 4)) return false;
    const std::uint32_t type = bigEndian(bytes, at + 4, 4);
    if (type == 0x49484452u && length == 13)  // IHDR
      size = {static_cast<int>(bigEndian(bytes, at + 8, 4)), static_cast<int>(bigEndian(bytes, at + 12, 4))};
    if (type == 0x49454e44u) return true;  // IEND
    at += 12 + length;
  }
  return false;
}

/// Reads the size in the frame header; true if the end-of-image marker follows.
bool readJpegFrame(const Bytes& bytes, ImageSize& size) {
  size_t at = 2;
  while (at + 9 <= bytes.size() && bytes[at] == 0xff) {
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      size = {static_cast<int>(bigEndian(bytes, at + 7, 2)), static_cast<int>(bigEndian(bytes, at + 5, 2))};
      for (size_t end = bytes.size() - 1; end > at; --end)
        if (bytes[end - 1] == 0xff && bytes[end] == 0xd9) return true;
      return false;
    }
    at += 2 + bigEndian(bytes, at + 2, 2);
  }
  return false;
}

ImageSize frameSize(const Bytes& bytes, const std::filesystem::path& file) {
  static const std::array<std::uint8_t, 8> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const bool is_png = bytes.size() > 8 && std::equal(png.begin(), png.end(), bytes.begin());
  const bool is_jpeg = bytes.size() > 3 && bytes[0] == 0xff && bytes[1] == 0xd8;
  if (!is_png && !is_jpeg) throw Error(file.string() + ": it is neither a PNG nor a JPEG image");
  ImageSize size;
  if (!(is_png ? readPngFrame(bytes, size) : readJpegFrame(bytes, size)) || size.width <= 0 ||
      size.height <= 0)
    throw Error(file.string() + ": the image is truncated or damaged; expected a complete one");
  return size;
}

std::string text(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

}  // namespace

ImageSize imageSize(const std::filesystem::path& file) {
  return frameSize(readBytes(file), file);
}

void readImage(const std::filesystem::path& file, ImageSize size, PixelFormat format,
               std::span<std::uint8_t> pixels) {
  quietOpenCv();
  const Bytes bytes = readBytes(file);
  const ImageSize found = frameSize(bytes, file);
  if (found != size)
    throw Error(file.string() + ": the image is " + text(found) + " pixels; expected the rig's " +
                text(size));
  const bool is_grey = format == PixelFormat::kGrey8;
  const int flags = (is_grey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR) | cv::IMREAD_IGNORE_ORIENTATION;
  cv::Mat target(size.height, size.width, is_grey ? CV_8UC1 : CV_8UC3, pixels.data());
  cv::Mat decoded;
  try {
    decoded = cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {
    decoded.release();
  }
  if (decoded.size() != target.size() || decoded.type() != target.type())
    throw Error(file.string() + ": the image cannot be decoded; expected a PNG or JPEG");
  decoded.copyTo(target);
}

void writePng(const std::filesystem::path& file, ImageSize size, std::span<const std::uint8_t> rgba) {
  if (size.width < 1 || size.height < 1 ||
      rgba.size() != static_cast<size_t>(size.width) * static_cast<size_t>(size.height) * 4)
    throw Error(file.string() + ": got " + std::to_string(rgba.size()) + " bytes for an image of " +
                text(size) + " pixels");
  // OpenCV only reads the data, but cv::Mat cannot wrap const memory.
  const cv::Mat image(size.height, size.width, CV_8UC4, const_cast<std::uint8_t*>(rgba.data()));
  cv::Mat bgra;
  cv::cvtColor(image, bgra, cv::COLOR_RGBA2BGRA);
  Bytes bytes;
  cv::imencode(".png", bgra, bytes);
  writeWhole(file, std::string(bytes.begin(), bytes.end()));
}

}  // namespace airclay
