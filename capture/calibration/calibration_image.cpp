// SPDX-License-Identifier: MIT
// Draws a calibration: the rig from above and from the side, and each camera's residuals.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/calibration/calibration.h"
#include "capture/images/image_file.h"

namespace airclay {
namespace {

constexpr int kPanel_px = 480, kMargin_px = 16, kTitle_px = 28;
// A residual of a tenth of a pixel is drawn ten pixels long.
constexpr double kResidualScale = 100;

const cv::Scalar kPaper(250, 250, 250, 255), kInk(40, 40, 40, 255), kFrame(190, 190, 190, 255),
    kBoard(200, 170, 120, 255), kCube(60, 140, 60, 255), kLens(40, 40, 200, 255), kResidual(200, 60, 30, 255);

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontScale = 0.5;

void write(cv::Mat& image, const std::string& text, cv::Point place) {
  cv::putText(image, text, place, kFont, kFontScale, kInk, 1, cv::LINE_AA);
}

/// Moves text that would extend beyond the image's edges.
void writeInside(cv::Mat& image, const std::string& text, cv::Point place) {
  constexpr int kEdge_px = 4;
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, kFontScale, 1, &below);
  place.x = std::max(std::min(place.x, image.cols - size.width - kEdge_px), kEdge_px);
  place.y = std::max(std::min(place.y, image.rows - below - kEdge_px), kTitle_px + size.height);
  write(image, text, place);
}

/// Draws a projection onto two of the world's axes.
class PlanView {
 public:
  PlanView(cv::Mat image, int right, int up, const Calibration& calibration)
      : image_(std::move(image)), right_(right), up_(up) {
    for (const Camera& camera : calibration.rig.cameras) reach(eyeOf(camera));
    for (const double sign : {-0.5, 0.5})
      reach(calibration.rig.workspace.center + Vec3::Constant(sign * calibration.rig.workspace.edge_m));
    const Vec2 size = (high_ - low_).cwiseMax(1e-6);
    per_metre_ =
        std::min((image_.cols - 6 * kMargin_px) / size.x(), (image_.rows - 6 * kMargin_px) / size.y());
  }

  void drawAll(const Calibration& calibration, const Board& outline) {
    for (const Pose& world_from_board : calibration.world_from_boards) {
      const Vec3 x = Vec3(outline.squares_x * outline.square_m, 0, 0);
      const Vec3 y = Vec3(0, outline.squares_y * outline.square_m, 0);
      loop({world_from_board * Vec3::Zero().eval(), world_from_board * x, world_from_board * (x + y),
            world_from_board * y},
           kBoard, 1);
    }
    drawCube(calibration.rig.workspace);
    for (const Camera& camera : calibration.rig.cameras) drawCamera(camera);
    line({at(Vec3::Zero()), at(0.1 * Vec3::Unit(right_))}, kInk);
    line({at(Vec3::Zero()), at(0.1 * Vec3::Unit(up_))}, kInk);
  }

 private:
  static Vec3 eyeOf(const Camera& camera) { return camera.camera_from_world.inverse().translation(); }
  Vec2 flat(const Vec3& point) const { return {point[right_], point[up_]}; }
  void reach(const Vec3& point) { low_ = low_.cwiseMin(flat(point)), high_ = high_.cwiseMax(flat(point)); }
  cv::Point at(const Vec3& point) const {
    const Vec2 from_middle = per_metre_ * (flat(point) - 0.5 * (low_ + high_));
    return {cvRound(0.5 * image_.cols + from_middle.x()), cvRound(0.5 * image_.rows - from_middle.y())};
  }
  void line(const std::array<cv::Point, 2>& ends, const cv::Scalar& colour, int width = 1) {
    cv::line(image_, ends[0], ends[1], colour, width, cv::LINE_AA);
  }
  void loop(const std::vector<Vec3>& points, const cv::Scalar& colour, int width) {
    for (std::size_t i = 0; i < points.size(); ++i)
      line({at(points[i]), at(points[(i + 1) % points.size()])}, colour, width);
  }
  void drawCube(const Workspace& workspace) {
    const double half = workspace.edge_m / 2;
    std::vector<Vec3> points;
    for (const auto& [a, b] : {std::pair(-half, -half), {half, -half}, {half, half}, {-half, half}}) {
      Vec3 point = workspace.center;
      point[right_] += a, point[up_] += b;
      points.push_back(point);
    }
    loop(points, kCube, 2);
  }
  /// The camera's position and its view frustum, 15 cm long.
  void drawCamera(const Camera& camera) {
    const Pose world_from_camera = camera.camera_from_world.inverse();
    std::vector<Vec3> rim;
    for (const auto& [u, v] :
         {std::pair(0, 0), {camera.width, 0}, {camera.width, camera.height}, {0, camera.height}})
      if (const std::optional<Vec3> ray = rayThroughPixel(camera.lens, Vec2(u, v)))
        rim.push_back(world_from_camera * Vec3(0.15 * *ray));
    for (const Vec3& point : rim) line({at(eyeOf(camera)), at(point)}, kLens);
    loop(rim, kLens, 1);
    cv::circle(image_, at(eyeOf(camera)), 4, kLens, cv::FILLED, cv::LINE_AA);
    writeInside(image_, camera.name, at(eyeOf(camera)) + cv::Point(6, -6));
  }

  cv::Mat image_;
  int right_, up_;
  Vec2 low_ = Vec2::Constant(1e9), high_ = Vec2::Constant(-1e9);
  double per_metre_ = 1;
};

void drawResiduals(cv::Mat panel, const Calibration& calibration, int index) {
  const Camera& camera = calibration.rig.cameras[static_cast<std::size_t>(index)];
  const double scale = std::min(panel.cols / static_cast<double>(camera.width),
                                (panel.rows - kTitle_px) / static_cast<double>(camera.height));
  const cv::Rect inside(0, kTitle_px, cvRound(scale * camera.width), cvRound(scale * camera.height));
  for (const CornerResidual& corner : calibration.residuals) {
    if (corner.camera != index) continue;
    const Vec2 from = scale * corner.pixel, to = from + scale * kResidualScale * corner.error_px;
    const auto place = [](const Vec2& p) { return cv::Point(cvRound(p.x()), kTitle_px + cvRound(p.y())); };
    cv::line(panel, place(from), place(to), kResidual, 1, cv::LINE_AA);
    cv::circle(panel, place(from), 1, kInk, cv::FILLED, cv::LINE_AA);
  }
  cv::rectangle(panel, inside, kFrame, 1);
  const CameraQuality& quality = calibration.cameras[static_cast<std::size_t>(index)];
  write(panel, cv::format("%s: %d views, %.2f px RMS", camera.name.c_str(), quality.views, quality.rms_px),
        {2, 18});
}

}  // namespace

void drawCalibration(const std::filesystem::path& png, const Board& board, const Calibration& calibration) {
  const int cameras = static_cast<int>(calibration.rig.cameras.size());
  // Two rows: from above and from the side, then the cameras, two to a column.
  const int columns = 1 + (cameras + 1) / 2, step = kPanel_px + kMargin_px;
  cv::Mat image(2 * step + kMargin_px, columns * step + kMargin_px, CV_8UC4, kPaper);
  const auto panel = [&](int column, int row) {
    return image(cv::Rect(kMargin_px + column * step, kMargin_px + row * step, kPanel_px, kPanel_px));
  };
  for (const int row : {0, 1}) {
    cv::Mat view = panel(0, row);
    PlanView(view, 0, row == 0 ? 1 : 2, calibration).drawAll(calibration, board);
    write(view, row == 0 ? "from above: x right, y up" : "from the side: x right, z up", {2, 18});
    cv::rectangle(view, {0, 0, kPanel_px, kPanel_px}, kFrame, 1);
  }
  for (int camera = 0; camera < cameras; ++camera)
    drawResiduals(panel(1 + camera / 2, camera % 2), calibration, camera);
  cv::Mat rgba;
  cv::cvtColor(image, rgba, cv::COLOR_BGRA2RGBA);
  writePng(png, {rgba.cols, rgba.rows},
           {rgba.ptr<std::uint8_t>(),
            static_cast<std::size_t>(rgba.cols) * static_cast<std::size_t>(rgba.rows) * 4});
}

}  // namespace airclay
