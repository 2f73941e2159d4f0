// SPDX-License-Identifier: MIT
// PDF: ISO 32000-1, a catalog, a page and its content. PNG: the W3C specification; the resolution is in pHYs,
// 11.3.5.3.
#include "capture/calibration/board_image.h"

#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/core/error.h"
#include "engine/core/file_io.h"

namespace airclay {
namespace {

constexpr double kPointsPerM = 72 / 0.0254;
// ISO 32000-1, annex C: 14,400 units per side.
constexpr double kMostPdfM = 14400 / kPointsPerM;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.7f", value);
  std::string digits = text;
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return digits == "-0" ? "0" : digits;
}

/// Coordinates are millimetres from the page's upper left corner; the page's matrix converts them to points.
std::string path(const std::vector<BoardRectangle>& rectangles) {
  std::string text;
  for (const BoardRectangle& r : rectangles)
    text += number(1e3 * r.left) + " " + number(1e3 * r.top) + " " + number(1e3 * (r.right - r.left)) + " " +
            number(1e3 * (r.bottom - r.top)) + " re\n";
  return text;
}

std::string contentOf(const BoardSheet& sheet) {
  const double points_per_mm = kPointsPerM / 1000, height = kPointsPerM * sheet.height_m;
  // The rectangles are nested, black in white in black: a single path with the even-odd rule has no seams.
  std::string text = "q\n" + number(points_per_mm) + " 0 0 " + number(-points_per_mm) + " 0 " +
                     number(height) + " cm\n0 g\n" + path(sheet.board) + "f*\n" + path(sheet.ruler) +
                     "f\nQ\nBT\n/F1 " + number(kPointsPerM * kTextSizeM) + " Tf\n" +
                     number(kPointsPerM * kTextLineM) + " TL\n" + number(kPointsPerM * sheet.text_m.x()) +
                     " " + number(height - kPointsPerM * sheet.text_m.y()) + " Td\n";
  for (const std::string& line : sheet.lines) text += "(" + line + ") Tj T*\n";
  return text + "ET\n";
}

/// The fraction of each pixel from `first` on that an interval covers.
struct PixelCoverage {
  int first = 0;
  std::vector<float> fractions;
};

PixelCoverage pixelCoverage(double low, double high, int pixels) {
  low = std::clamp(low, 0.0, double(pixels)), high = std::clamp(high, 0.0, double(pixels));
  PixelCoverage coverage;
  coverage.first = static_cast<int>(low);
  for (int i = coverage.first; i < high; ++i)
    coverage.fractions.push_back(static_cast<float>(std::min(high, i + 1.0) - std::max(low, double(i))));
  return coverage;
}

void paint(const std::vector<BoardRectangle>& rectangles, double pixels_per_m, cv::Mat1f& blackness) {
  for (const BoardRectangle& r : rectangles) {
    const PixelCoverage columns =
        pixelCoverage(r.left * pixels_per_m, r.right * pixels_per_m, blackness.cols);
    const PixelCoverage rows = pixelCoverage(r.top * pixels_per_m, r.bottom * pixels_per_m, blackness.rows);
    for (std::size_t y = 0; y < rows.fractions.size(); ++y) {
      float* pixel = blackness.ptr<float>(rows.first + static_cast<int>(y)) + columns.first;
      const float share = r.black ? rows.fractions[y] : -rows.fractions[y];
      for (const float column : columns.fractions) *pixel++ += share * column;
    }
  }
}

void write(const BoardSheet& sheet, double pixels_per_m, cv::Mat1b& grey) {
  // Hershey letters are 21 units high at scale 1.
  const double scale = kTextSizeM * 0.72 * pixels_per_m / 21;
  const int thickness = std::max(1, static_cast<int>(std::lround(1.5 * scale)));
  Vec2 at = sheet.text_m * pixels_per_m;
  for (const std::string& line : sheet.lines) {
    cv::putText(grey, line, cv::Point(int(std::lround(at.x())), int(std::lround(at.y()))),
                cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(0), thickness, cv::LINE_AA);
    at.y() += kTextLineM * pixels_per_m;
  }
}

std::string bigEndian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

/// The CRC-32 of PNG's appendix D, bit by bit.
std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
  }
  return ~crc;
}

/// A PNG with its resolution: pHYs after the signature (8 bytes) and IHDR (25).
std::string withResolution(std::string png, std::uint32_t pixels_per_m) {
  const std::string chunk = "pHYs" + bigEndian(pixels_per_m) + bigEndian(pixels_per_m) + '\1';
  return png.insert(33, bigEndian(9) + chunk + bigEndian(crc32(chunk)));
}

}  // namespace

void writeBoardPdf(const std::filesystem::path& file, const BoardSheet& sheet) {
  if (std::max(sheet.width_m, sheet.height_m) > kMostPdfM)
    throw Error(file.string() + ": a page of " + number(sheet.width_m) + " x " + number(sheet.height_m) +
                " m is larger than a PDF can be; expected a board of at most 5 m");
  const std::string content = contentOf(sheet);
  const std::vector<std::string> objects{
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + number(kPointsPerM * sheet.width_m) + " " +
          number(kPointsPerM * sheet.height_m) +
          "] /Resources << /Font << /F1 5 0 R >> >> /Contents 4 0 R >>",
      "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>"};
  std::string pdf = "%PDF-1.6\n%\xe2\xe3\xcf\xd3\n", table;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    char entry[32];
    std::snprintf(entry, sizeof entry, "%010zu 00000 n \n", pdf.size());
    table += entry;
    pdf += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::string count = std::to_string(objects.size() + 1), start = std::to_string(pdf.size());
  pdf += "xref\n0 " + count + "\n0000000000 65535 f \n" + table + "trailer\n<< /Size " + count +
         " /Root 1 0 R >>\nstartxref\n" + start + "\n%%EOF\n";
  writeWhole(file, pdf);
}

void writeBoardPng(const std::filesystem::path& file, const BoardSheet& sheet, double dpi) {
  const double pixels_per_m = std::round(dpi / 0.0254);  // an integer in pHYs
  const double width = std::ceil(sheet.width_m * pixels_per_m),
               height = std::ceil(sheet.height_m * pixels_per_m);
  if (!(pixels_per_m >= 1 && width * height <= kMaxBoardPixels))
    throw Error(file.string() + ": at " + number(dpi) + " dpi the page has " + number(width * height / 1e6) +
                    " million pixels; expected at most " + number(kMaxBoardPixels / 1e6) +
                    ": use a smaller --dpi, or a .pdf",
                Fault::kUsage);
  cv::Mat1f blackness(static_cast<int>(height), static_cast<int>(width), 0.0f);
  paint(sheet.board, pixels_per_m, blackness);
  paint(sheet.ruler, pixels_per_m, blackness);
  cv::Mat1b grey;
  blackness.convertTo(grey, CV_8U, -255, 255);
  blackness.release();
  write(sheet, pixels_per_m, grey);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", grey, bytes);
  writeWhole(file, withResolution({bytes.begin(), bytes.end()}, static_cast<std::uint32_t>(pixels_per_m)));
}

}  // namespace airclay
