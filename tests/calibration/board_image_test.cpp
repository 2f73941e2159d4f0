// SPDX-License-Identifier: MIT
// Printed boards: the PDF's own numbers, and the PNG read back, measured and detected.
#include "capture/calibration/board_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "capture/calibration/board_detector.h"
#include "engine/core/error.h"
#include "engine/core/file_io.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

Board a3Board() {
  Board board;
  board.squares_x = 7, board.squares_y = 5;
  board.square_m = 0.055, board.marker_m = 0.041;
  return board;
}

/// A page as a PDF reader interprets it: lengths in millimetres of paper.
struct ReadPdf {
  double width = 0, height = 0;
  std::vector<std::array<double, 4>> board, ruler;  ///< left, top, width, height, from the upper left corner
  std::string text;
};

ReadPdf readPdf(const std::filesystem::path& file) {
  constexpr double kMmPerPoint = 25.4 / 72;
  const std::string pdf = readWhole(file, 1 << 24);
  ReadPdf page;
  const std::size_t box = pdf.find("/MediaBox [0 0 ");
  std::istringstream(pdf.substr(box + 15)) >> page.width >> page.height;
  const double height_points = page.height;
  page.width *= kMmPerPoint, page.height *= kMmPerPoint;
  // The cross-reference table points at the objects, and the stream's length is correct.
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  EXPECT_EQ(pdf.substr(table, 5), "xref\n");
  for (int i = 1; i <= 5; ++i) {
    const std::size_t at = std::stoul(pdf.substr(table + 9 + 20 * std::size_t(i), 10));
    EXPECT_EQ(pdf.substr(at, 8), std::to_string(i) + " 0 obj\n") << i;
  }
  const std::size_t length = std::stoul(pdf.substr(pdf.find("/Length ") + 8));
  const std::size_t begin = pdf.find("stream\n") + 7;
  EXPECT_EQ(pdf.substr(begin + length, 9), "endstream");

  std::istringstream tokens(pdf.substr(begin, length));
  std::vector<double> numbers;
  std::vector<std::array<double, 4>> rectangles;
  double a = 1, d = 1, e = 0, f = 0;  // of the matrix
  for (std::string token; tokens >> token;) {
    if (token == "cm") {
      a = numbers.at(0), d = numbers.at(3), e = numbers.at(4), f = numbers.at(5);
    } else if (token == "re") {
      const double top = height_points - (d * numbers.at(1) + f);
      rectangles.push_back({kMmPerPoint * (a * numbers.at(0) + e), kMmPerPoint * top,
                            kMmPerPoint * a * numbers.at(2), -kMmPerPoint * d * numbers.at(3)});
    } else if (token == "f*") {
      page.board = std::move(rectangles), rectangles.clear();
    } else if (token == "f") {
      page.ruler = std::move(rectangles), rectangles.clear();
    } else if (std::isdigit(static_cast<unsigned char>(token[0])) || token[0] == '-') {
      numbers.push_back(std::stod(token));
      continue;
    } else if (token[0] == '(') {
      std::string rest;
      std::getline(tokens, rest);
      page.text += token + rest;
    }
    numbers.clear();
  }
  return page;
}

TEST(BoardPdf, IsTrueToScale) {
  const TemporaryFolder folder;
  for (const Board& board : {Board(), a3Board()}) {
    const Page page = board.squares_x == 5 ? Page::kA4 : Page::kA3;
    writeBoardPdf(folder / "board.pdf", layOut(board, page));
    const ReadPdf read = readPdf(folder / "board.pdf");
    EXPECT_NEAR(read.width, page == Page::kA4 ? 297 : 420, 1e-4);
    EXPECT_NEAR(read.height, page == Page::kA4 ? 210 : 297, 1e-4);
    // Squares, then markers, then the markers' white cells.
    const double square = 1000 * board.square_m, marker = 1000 * board.marker_m;
    int squares = 0, markers = 0;
    double left = 1e9, right = 0, bottom = 0;
    for (const auto& [x, y, width, height] : read.board) {
      squares += std::abs(width - square) < 1e-4 && std::abs(height - square) < 1e-4;
      markers += std::abs(width - marker) < 1e-4 && std::abs(height - marker) < 1e-4;
      left = std::min(left, x), right = std::max(right, x + width), bottom = std::max(bottom, y + height);
    }
    EXPECT_EQ(squares, (board.squares_x * board.squares_y + 1) / 2);
    EXPECT_EQ(markers, board.squares_x * board.squares_y / 2);
    EXPECT_NEAR(right - left, board.squares_x * square, 1e-4);
    EXPECT_NEAR(left + right, read.width, 1e-4) << "in the middle of the page";
    // The ruler: eleven ticks, 100 mm between the first and the last, below the board.
    ASSERT_EQ(read.ruler.size(), 12u);
    EXPECT_NEAR(read.ruler[11][0] - read.ruler[1][0], 100, 1e-4);
    EXPECT_NEAR(read.ruler[0][2], 100.2, 1e-4);
    for (const auto& [x, y, width, height] : read.ruler) {
      EXPECT_GT(y, bottom);
      EXPECT_LT(y + height, read.height - 5);
    }
    EXPECT_NE(read.text.find("this line is 100 mm"), std::string::npos);
    EXPECT_NE(read.text.find(std::to_string(board.squares_x) + " x " + std::to_string(board.squares_y)),
              std::string::npos);
  }
}

TEST(BoardPdf, ChoosesPageOrientation) {
  Board tall;
  std::swap(tall.squares_x, tall.squares_y);
  EXPECT_LT(layOut(tall, Page::kA4).width_m, layOut(tall, Page::kA4).height_m);
  Board smaller;
  smaller.square_m = 0.052;
  EXPECT_GT(layOut(smaller, Page::kLetter).width_m, 0.27);
  const BoardSheet fit = layOut(a3Board(), Page::kFit);
  EXPECT_NEAR(fit.width_m, 0.385 + 0.02, 1e-12);
  EXPECT_LT(fit.height_m, 0.32);
}

TEST(BoardPdf, SuggestsFittingPageOrSquare) {
  const std::string a4 = messageOf([] { layOut(a3Board(), Page::kA4); });
  EXPECT_NE(a4.find("--page a3"), std::string::npos) << a4;
  const std::size_t at = a4.find("--square-mm ");
  ASSERT_NE(at, std::string::npos) << a4;
  Board smaller = a3Board();
  smaller.square_m = std::stod(a4.substr(at + 12)) / 1000, smaller.marker_m = 0.7 * smaller.square_m;
  EXPECT_EQ(messageOf([&] { layOut(smaller, Page::kA4); }), "");
  smaller.square_m += 0.001;
  EXPECT_NE(messageOf([&] { layOut(smaller, Page::kA4); }), "");
  Board large = a3Board();
  large.square_m = 0.2;
  EXPECT_NE(messageOf([&] { layOut(large, Page::kA3); }).find("--page fit"), std::string::npos);
  large.square_m = 1.9, large.marker_m = 1;
  const TemporaryFolder folder;
  EXPECT_NE(messageOf([&] { writeBoardPdf(folder / "b.pdf", layOut(large, Page::kFit)); }).find("5 m"),
            std::string::npos);
  EXPECT_NE(messageOf([&] { writeBoardPng(folder / "b.png", layOut(large, Page::kFit), 300); }).find("--dpi"),
            std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

std::uint32_t bigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes.at(at + i));
  return value;
}

TEST(BoardPng, IsTrueToScaleAndDetected) {
  const TemporaryFolder folder;
  Board inverted = a3Board();
  inverted.inverted = true;
  Board chess = a3Board();
  chess.chessboard = true, chess.squares_y = 4;
  for (const Board& board : {Board(), a3Board(), inverted, chess}) {
    const std::filesystem::path file = folder / "board.png";
    const BoardSheet sheet = layOut(board, Page::kA3);
    writeBoardPng(file, sheet, 100);
    const std::string bytes = readWhole(file, 1 << 24);
    const std::size_t chunk = bytes.find("pHYs");
    ASSERT_NE(chunk, std::string::npos);
    const double pixels_per_m = bigEndian(bytes, chunk + 4);
    EXPECT_EQ(pixels_per_m, std::round(100 / 0.0254));
    EXPECT_EQ(bytes[chunk + 12], 1) << "per metre";

    const ImageSize size = imageSize(file);  // also checks every chunk's CRC
    EXPECT_EQ(size.width, std::ceil(0.420 * pixels_per_m));
    std::vector<std::uint8_t> grey(std::size_t(size.width) * std::size_t(size.height));
    readImage(file, size, PixelFormat::kGrey8, grey);
    const std::optional<BoardView> view = BoardDetector(board).find(size, PixelFormat::kGrey8, grey);
    ASSERT_TRUE(view) << board.inverted << board.chessboard;
    ASSERT_EQ(static_cast<int>(view->ids.size()), board.cornerCount());
    double left = 1, top = 1;
    for (const BoardRectangle& r : sheet.board) left = std::min(left, r.left), top = std::min(top, r.top);
    for (int id = 0; id < board.cornerCount(); ++id) {
      const Vec2 at = (Vec2(left, top) + board.corner(id).head<2>()) * pixels_per_m - Vec2(0.5, 0.5);
      EXPECT_LE((view->pixels[std::size_t(id)] - at).norm(), 0.03) << id;
    }
  }
}

TEST(BoardPng, RulerIsOneHundredMillimetres) {
  const TemporaryFolder folder;
  const BoardSheet sheet = layOut(Board(), Page::kA4);
  writeBoardPng(folder / "board.png", sheet, 254);  // 10 pixels per millimetre
  const cv::Mat1b grey = cv::imread((folder / "board.png").string(), cv::IMREAD_GRAYSCALE);
  const int y = static_cast<int>(1e4 * sheet.ruler_begin_m.y());
  double ink = 0;
  for (int x = 0; x < grey.cols; ++x) ink += grey(y, x) < 128;
  EXPECT_NEAR(ink, 1002, 1);
}

}  // namespace
}  // namespace airclay
