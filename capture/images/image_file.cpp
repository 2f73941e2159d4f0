// SPDX-License-Identifier: MIT
// Images through OpenCV's codecs. The file structure is checked here first (PNG: W3C specification, 5; JPEG:
// ITU T.81, B.1; the others below): the size before memory is allocated, and completeness because the
// decoders write errors to standard error.
#include "capture/images/image_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "capture/images/quiet_opencv.h"
#include "engine/camera/rig.h"
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

std::uint32_t littleEndian(const Bytes& bytes, size_t at, int count) {
  std::uint32_t value = 0;
  for (int i = count; i-- > 0;) value = value << 8 | bytes[at + static_cast<size_t>(i)];
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

/// The size in a bitmap's header; true if all rows of an uncompressed one are there (Microsoft: "Bitmap
/// Storage").
bool readBmpFrame(const Bytes& bytes, ImageSize& size) {
  if (bytes.size() < 54 || littleEndian(bytes, 14, 4) < 40) return false;
  const std::int64_t width = static_cast<std::int32_t>(littleEndian(bytes, 18, 4));
  const std::int64_t height = std::abs(std::int64_t(static_cast<std::int32_t>(littleEndian(bytes, 22, 4))));
  if (width > kMaxImageSide || height > kMaxImageSide) return false;
  size = {static_cast<int>(width), static_cast<int>(height)};
  const std::uint32_t bits = littleEndian(bytes, 28, 2), compression = littleEndian(bytes, 30, 4);
  const bool is_plain = compression == 0 || compression == 3;
  const std::int64_t row_bytes = (width * bits + 31) / 32 * 4;
  return !is_plain || littleEndian(bytes, 10, 4) + row_bytes * height <= std::int64_t(bytes.size());
}

/// A TIFF file's first directory (TIFF 6.0, section 2).
class TiffFrame {
 public:
  explicit TiffFrame(const Bytes& bytes) : bytes_(bytes), is_big_(bytes[0] == 'M') {}

  /// True if the directory, its values and all strips or tiles are inside the file.
  bool read(ImageSize& size) {
    const size_t directory = number(4, 4);
    if (directory < 8 || directory + 2 > bytes_.size()) return false;
    const size_t entries = number(directory, 2);
    if (directory + 2 + 12 * entries + 4 > bytes_.size()) return false;
    std::vector<std::uint32_t> offsets, lengths;
    for (size_t i = 0; i < entries; ++i) {
      const size_t entry = directory + 2 + 12 * i;
      const std::uint32_t tag = number(entry, 2);
      if (!isInside(entry)) return false;
      if (tag == 339) is_float_ = valuesAt(entry, 1).at(0) == 3;  // SampleFormat
      if (tag == 256) size.width = static_cast<int>(valuesAt(entry, 1).at(0));
      if (tag == 257) size.height = static_cast<int>(valuesAt(entry, 1).at(0));
      if (tag == 273 || tag == 324) offsets = valuesAt(entry, kMaxImageSide);  // strips, tiles
      if (tag == 279 || tag == 325) lengths = valuesAt(entry, kMaxImageSide);
    }
    if (offsets.empty() || offsets.size() != lengths.size()) return false;
    for (size_t i = 0; i < offsets.size(); ++i)
      if (std::uint64_t(offsets[i]) + lengths[i] > bytes_.size()) return false;
    return true;
  }

  /// Whether the samples are floating-point numbers.
  bool isFloat() const { return is_float_; }

 private:
  /// Whether an entry's values are inside the file.
  bool isInside(size_t entry) const {
    static constexpr std::array<size_t, 13> kBytes{1, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8};  // by type
    const std::uint32_t type = number(entry + 2, 2);
    const size_t bytes = (type < kBytes.size() ? kBytes[type] : 1) * size_t(number(entry + 4, 4));
    return bytes <= 4 || number(entry + 8, 4) + bytes <= bytes_.size();
  }

  std::uint32_t number(size_t at, int count) const {
    return is_big_ ? bigEndian(bytes_, at, count) : littleEndian(bytes_, at, count);
  }

  /// An entry's values, at most `most`; {0} if they are neither 16 nor 32 bits wide or outside the file.
  std::vector<std::uint32_t> valuesAt(size_t entry, size_t most) const {
    const std::uint32_t type = number(entry + 2, 2);
    const int width = type == 3 ? 2 : 4;
    const size_t count = number(entry + 4, 4);
    const size_t at = count * static_cast<size_t>(width) <= 4 ? entry + 8 : number(entry + 8, 4);
    if ((type != 3 && type != 4) || count == 0 || at + count * static_cast<size_t>(width) > bytes_.size())
      return {0};
    std::vector<std::uint32_t> values;
    for (size_t i = 0; i < std::min(count, most); ++i)
      values.push_back(number(at + i * static_cast<size_t>(width), width));
    return values;
  }

  const Bytes& bytes_;
  bool is_big_, is_float_ = false;
};

bool readTiffFrame(const Bytes& bytes, const std::filesystem::path& file, ImageSize& size) {
  TiffFrame frame(bytes);
  const bool is_complete = frame.read(size);
  if (frame.isFloat())
    throw Error(file.string() + ": its samples are floating-point numbers; expected 8 or 16 bits");
  return is_complete;
}

/// The size in the first chunk of a WebP file; true if the file is as long as it declares (RFC 9649).
bool readWebpFrame(const Bytes& bytes, ImageSize& size) {
  if (bytes.size() < 30 || std::uint64_t(littleEndian(bytes, 4, 4)) + 8 > bytes.size()) return false;
  const std::string chunk(bytes.begin() + 12, bytes.begin() + 16);
  const auto side = [](std::uint32_t value) { return static_cast<int>(value); };
  if (chunk == "VP8X")
    size = {side(littleEndian(bytes, 24, 3)) + 1, side(littleEndian(bytes, 27, 3)) + 1};
  else if (chunk == "VP8L")
    size = {side(littleEndian(bytes, 21, 4) & 0x3fff) + 1,
            side(littleEndian(bytes, 21, 4) >> 14 & 0x3fff) + 1};
  else if (chunk == "VP8 ")
    size = {side(littleEndian(bytes, 26, 2) & 0x3fff), side(littleEndian(bytes, 28, 2) & 0x3fff)};
  return true;
}

/// Whether the bytes from `at` on are `text`.
bool hasText(const Bytes& bytes, size_t at, std::string_view text) {
  return bytes.size() >= at + text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin() + static_cast<long>(at),
                    [](char c, std::uint8_t byte) { return static_cast<std::uint8_t>(c) == byte; });
}

ImageSize frameSize(const Bytes& bytes, const std::filesystem::path& file) {
  using namespace std::string_view_literals;
  ImageSize size;
  bool is_complete = false;
  if (hasText(bytes, 0, "\x89PNG\r\n\x1a\n"sv))
    is_complete = readPngFrame(bytes, size);
  else if (hasText(bytes, 0, "\xff\xd8"sv))
    is_complete = readJpegFrame(bytes, size);
  else if (hasText(bytes, 0, "BM"sv))
    is_complete = readBmpFrame(bytes, size);
  else if (hasText(bytes, 0, "II*\0"sv) || hasText(bytes, 0, "MM\0*"sv))
    is_complete = bytes.size() > 8 && readTiffFrame(bytes, file, size);
  else if (hasText(bytes, 0, "RIFF"sv) && hasText(bytes, 8, "WEBP"sv))
    is_complete = readWebpFrame(bytes, size);
  else
    throw Error(file.string() + ": it is not a PNG, JPEG, BMP, TIFF or WebP image");
  if (!is_complete || size.width <= 0 || size.height <= 0)
    throw Error(file.string() + ": the image is truncated or damaged; expected a complete one");
  return size;
}

/// Decodes to 8 or 16 bits per channel, with one channel (grey) or three (BGR). Empty if that fails.
cv::Mat decode(const Bytes& bytes, PixelFormat format) {
  const int channels = format == PixelFormat::kGrey8 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR;
  try {
    return cv::imdecode(bytes, channels | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

/// The bits that hold the largest of 16-bit values: 10, 12, 14 or 16.
int bitsOf(const cv::Mat& image) {
  double largest = 0;
  cv::minMaxLoc(image.reshape(1), nullptr, &largest);
  for (const int bits : {10, 12, 14})
    if (largest < 1 << bits) return bits;
  return 16;
}

std::string text(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

}  // namespace

ImageSize imageSize(const std::filesystem::path& file) {
  return frameSize(readBytes(file), file);
}

bool isImageName(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  static constexpr std::array kExtensions{".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp"};
  return std::any_of(kExtensions.begin(), kExtensions.end(),
                     [&](const char* known) { return extension == known; });
}

int imageBits(const std::filesystem::path& file) {
  quietOpenCv();
  const Bytes bytes = readBytes(file);
  frameSize(bytes, file);
  const cv::Mat decoded = decode(bytes, PixelFormat::kGrey8);
  if (decoded.empty()) throw Error(file.string() + ": the image cannot be decoded; expected a complete one");
  return decoded.depth() == CV_16U ? bitsOf(decoded) : 8;
}

void readImage(const std::filesystem::path& file, ImageSize size, PixelFormat format,
               std::span<std::uint8_t> pixels, std::optional<int> bits) {
  quietOpenCv();
  const Bytes bytes = readBytes(file);
  const ImageSize found = frameSize(bytes, file);
  if (found != size)
    throw Error(file.string() + ": the image is " + text(found) + " pixels; expected the rig's " +
                text(size));
  cv::Mat target(size.height, size.width, format == PixelFormat::kGrey8 ? CV_8UC1 : CV_8UC3, pixels.data());
  cv::Mat decoded = decode(bytes, format);
  // convertTo rounds and saturates.
  if (decoded.depth() == CV_16U)
    decoded.convertTo(decoded, CV_8U, 255.0 / ((1 << bits.value_or(bitsOf(decoded))) - 1));
  if (decoded.size() != target.size() || decoded.type() != target.type())
    throw Error(file.string() + ": the image cannot be decoded; expected a complete one of 8 or 16 bits");
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
