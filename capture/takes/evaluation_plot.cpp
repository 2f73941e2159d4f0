// SPDX-License-Identifier: MIT
#include "capture/takes/evaluation_plot.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/images/image_file.h"

namespace airclay {
namespace {

// Drawn at twice the size and reduced: OpenCV's thin lines and letters are coarse.
constexpr int kScale = 2;
constexpr int kWidth_px = 1200, kPanelHeight_px = 270, kLeft_px = 76, kRight_px = 24, kTop_px = 76,
              kGap_px = 36, kBottom_px = 58;

// RGBA
const cv::Scalar kPaper(255, 255, 255, 255), kInk(45, 45, 48, 255), kGrid(230, 230, 232, 255),
    kFrame(150, 150, 155, 255), kLine(140, 170, 205, 255), kTracked(40, 95, 165, 255),
    kUncertain(235, 150, 20, 255), kWrong(205, 35, 40, 255), kLost(250, 214, 212, 255),
    kLimit(205, 90, 90, 255);

struct Tick {
  double value = 0;
  std::string label;  ///< empty: only a grid line
};

/// Maps values to 0..1.
struct Axis {
  double low = 0, high = 1;
  bool is_logarithmic = false;
  std::vector<Tick> ticks;

  double place(double value) const {
    if (!is_logarithmic) return (value - low) / (high - low);
    return std::log(std::max(value, low) / low) / std::log(high / low);
  }
};

std::string numberText(double value) {
  return cv::format("%.6g", value);
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `value`.
double roundedUp(double value) {
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {1, 2, 5})
    if (factor * decade >= value * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

void addLinearTicks(Axis& axis, int count) {
  const double step = roundedUp((axis.high - axis.low) / count);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-6)));
  for (double k = std::ceil(axis.low / step - 1e-6); k * step <= axis.high + 1e-6 * step; ++k)
    axis.ticks.push_back({k * step, cv::format("%.*f", decimals, k * step + 0.0)});
}

Axis timeAxis(const EvaluatedTake& take) {
  const double first_s = take.front().time_s, last_s = take.back().time_s;
  const double margin_s = std::max(0.01 * (last_s - first_s), 0.05);
  Axis axis{first_s - margin_s, last_s + margin_s, false, {}};
  addLinearTicks(axis, 12);
  return axis;
}

/// From 0, or logarithmic if a linear axis would flatten most of the values.
Axis errorAxis(std::vector<double> errors) {
  Axis axis;
  std::sort(errors.begin(), errors.end());
  if (errors.empty() || !(errors.back() > 0)) {
    addLinearTicks(axis, 5);
    return axis;
  }
  axis.is_logarithmic = errors.back() > 8 * percentile(errors, 0.5);
  if (!axis.is_logarithmic) {
    const double step = roundedUp(errors.back() / 5);
    axis.high = step * std::ceil(1.04 * errors.back() / step);
    addLinearTicks(axis, 6);
    return axis;
  }
  // At most four decades: exact frames would stretch the axis without end.
  axis.high = roundedUp(1.1 * errors.back());
  axis.low = std::max(percentile(errors, 0.01), 1e-4 * axis.high);
  double decade = std::pow(10, std::floor(std::log10(axis.low)));
  for (const double factor : {1, 2, 5})
    if (factor * decade <= axis.low * (1 + 1e-9)) axis.low = factor * decade;
  const bool labels_all = axis.high / axis.low <= 250;
  for (; decade <= axis.high * 1.001; decade *= 10)
    for (const double factor : {1, 2, 5}) {
      const double value = factor * decade;
      if (value < axis.low * 0.999 || value > axis.high * 1.001) continue;
      axis.ticks.push_back({value, labels_all || factor == 1 ? numberText(value) : ""});
    }
  return axis;
}

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

cv::Size textSize(const std::string& text, double size) {
  int below = 0;
  return cv::getTextSize(text, kFont, kScale * size, kScale, &below);
}

/// `across`: 0 aligns the text's left edge with `place`, 0.5 its middle, 1 its right edge.
void write(cv::Mat& image, const std::string& text, cv::Point2d place, double across, double size = 0.45) {
  const cv::Point origin(cvRound(kScale * place.x - across * textSize(text, size).width),
                         cvRound(kScale * place.y));
  cv::putText(image, text, origin, kFont, kScale * size, kInk, kScale, cv::LINE_AA);
}

cv::Scalar colourOf(const EvaluatedFrame& frame, const PoseError& error) {
  if (frame.is_uncertain) return kUncertain;
  return error.mm() > kWrongMm ? kWrong : kTracked;
}

/// One kind of error over time.
class Panel {
 public:
  Panel(cv::Mat& image, int top_px, Axis time, Axis errors)
      : image_(image), top_px_(top_px), time_(std::move(time)), errors_(std::move(errors)) {}

  void drawLost(const EvaluatedTake& take) {
    double frame_s = 1.0 / 30;
    for (std::size_t i = 1; i < take.size(); ++i)
      frame_s = std::min(frame_s, take[i].time_s - take[i - 1].time_s);
    for (const EvaluatedFrame& frame : take)
      if (!frame.estimate)
        cv::rectangle(image_, at(x(frame.time_s - 0.5 * frame_s), top_px_),
                      at(x(frame.time_s + 0.5 * frame_s), top_px_ + kPanelHeight_px), kLost, cv::FILLED);
  }

  void drawGrid(const std::string& title, bool labels_time) {
    for (const Tick& tick : errors_.ticks) {
      line({kLeft_px, y(tick.value)}, {kWidth_px - kRight_px, y(tick.value)}, kGrid);
      write(image_, tick.label, {kLeft_px - 8, y(tick.value) + 5}, 1);
    }
    for (const Tick& tick : time_.ticks) {
      line({x(tick.value), double(top_px_)}, {x(tick.value), double(top_px_ + kPanelHeight_px)}, kGrid);
      if (labels_time) write(image_, tick.label, {x(tick.value), top_px_ + kPanelHeight_px + 20.0}, 0.5);
    }
    write(image_, title, {double(kLeft_px), top_px_ - 8.0}, 0);
    cv::rectangle(image_, at(kLeft_px, top_px_), at(kWidth_px - kRight_px, top_px_ + kPanelHeight_px), kFrame,
                  kScale);
  }

  /// A dashed line, if the axis includes the value.
  void drawLimit(double value) {
    if (value < errors_.low || value > errors_.high) return;
    for (double from = kLeft_px; from < kWidth_px - kRight_px; from += 12)
      line({from, y(value)}, {std::min(from + 6, double(kWidth_px - kRight_px)), y(value)}, kLimit);
  }

  void drawErrors(const EvaluatedTake& take, const Vec3& center_in_hand, double (PoseError::*size)() const) {
    std::optional<cv::Point2d> before;
    for (const EvaluatedFrame& frame : take) {
      const std::optional<PoseError> error = poseError(frame, center_in_hand);
      const auto place =
          error ? std::optional(cv::Point2d(x(frame.time_s), y(((*error).*size)()))) : std::nullopt;
      if (before && place) line(*before, *place, kLine, 1.5);
      before = place;
    }
    // Dots that would merge are smaller; those of interest are drawn over the others.
    const double spacing_px = (kWidth_px - kLeft_px - kRight_px) / static_cast<double>(take.size());
    const int radius = cvRound(kScale * std::clamp(0.5 * spacing_px, 1.5, 3.0));
    for (const bool is_good : {true, false})
      for (const EvaluatedFrame& frame : take)
        if (const std::optional<PoseError> error = poseError(frame, center_in_hand);
            error && is_good == (colourOf(frame, *error) == kTracked))
          cv::circle(image_, at(x(frame.time_s), y(((*error).*size)())), radius, colourOf(frame, *error),
                     cv::FILLED, cv::LINE_AA);
  }

 private:
  double x(double time_s) const {
    return kLeft_px + time_.place(time_s) * (kWidth_px - kLeft_px - kRight_px);
  }
  double y(double error) const { return top_px_ + (1 - errors_.place(error)) * kPanelHeight_px; }
  static cv::Point at(double x_px, double y_px) { return {cvRound(kScale * x_px), cvRound(kScale * y_px)}; }
  void line(cv::Point2d from, cv::Point2d to, const cv::Scalar& colour, double width_px = 1) {
    cv::line(image_, at(from.x, from.y), at(to.x, to.y), colour, cvRound(kScale * width_px), cv::LINE_AA);
  }

  cv::Mat& image_;
  int top_px_;
  Axis time_, errors_;
};

/// What the colours mean and how many frames have each; only those that occur.
/// Returns its left edge.
double drawLegend(cv::Mat& image, const Evaluation& evaluation) {
  struct Entry {
    std::string text;
    int count;
    cv::Scalar colour;
    bool is_band;
  };
  const Entry entries[] = {
      {"tracked", evaluation.tracked - evaluation.uncertain - evaluation.wrong_tracked, kTracked, false},
      {"tracked, over " + numberText(kWrongMm) + " mm off", evaluation.wrong_tracked, kWrong, false},
      {"uncertain", evaluation.uncertain, kUncertain, false},
      {"lost", evaluation.lost, kLost, true}};
  double right_px = kWidth_px - kRight_px;
  for (auto entry = std::rbegin(entries); entry != std::rend(entries); ++entry) {
    if (entry->count == 0) continue;
    const std::string text = entry->text + ": " + std::to_string(entry->count);
    write(image, text, {right_px, 32}, 1);
    right_px -= textSize(text, 0.45).width / double(kScale) + 12;
    const cv::Point middle(cvRound(kScale * right_px), kScale * 27);
    if (entry->is_band)
      cv::rectangle(image, middle - cv::Point(6, 8) * kScale, middle + cv::Point(6, 8) * kScale,
                    entry->colour, cv::FILLED);
    else
      cv::circle(image, middle, 4 * kScale, entry->colour, cv::FILLED, cv::LINE_AA);
    right_px -= 26;
  }
  return right_px;
}

/// Shortened to `width_px`.
std::string fitting(std::string text, double size, double width_px) {
  if (textSize(text, size).width <= kScale * width_px) return text;
  while (!text.empty() && textSize(text + "...", size).width > kScale * width_px) text.pop_back();
  return text + "...";
}

std::string titleOf(const std::string& title, const std::string& unit,
                    const std::optional<ErrorDistribution>& errors) {
  if (!errors) return title;
  return title + cv::format(", %s: median %.2f, 90th percentile %.2f, 99th %.2f, worst %.2f", unit.c_str(),
                            errors->median, errors->p90, errors->p99, errors->worst);
}

}  // namespace

void drawEvaluation(const std::filesystem::path& png, const std::string& name, const EvaluatedTake& take,
                    const Vec3& center_in_hand) {
  const int height_px = kTop_px + 2 * kPanelHeight_px + kGap_px + kBottom_px;
  cv::Mat image(kScale * height_px, kScale * kWidth_px, CV_8UC4, kPaper);
  const Evaluation evaluation = evaluate({&take, 1}, center_in_hand);
  const double legend_px = drawLegend(image, evaluation);
  write(image, fitting(name, 0.6, legend_px - kLeft_px), {double(kLeft_px), 34}, 0, 0.6);
  if (!take.empty()) {
    std::vector<double> mm, deg;
    for (const EvaluatedFrame& frame : take)
      if (const std::optional<PoseError> error = poseError(frame, center_in_hand)) {
        mm.push_back(error->mm());
        deg.push_back(error->deg());
      }
    Panel position(image, kTop_px, timeAxis(take), errorAxis(mm));
    Panel rotation(image, kTop_px + kPanelHeight_px + kGap_px, timeAxis(take), errorAxis(deg));
    for (Panel* panel : {&position, &rotation}) panel->drawLost(take);
    position.drawGrid(titleOf("position error", "mm", evaluation.mm), false);
    position.drawLimit(kWrongMm);
    rotation.drawGrid(titleOf("rotation error", "degrees", evaluation.deg), true);
    position.drawErrors(take, center_in_hand, &PoseError::mm);
    rotation.drawErrors(take, center_in_hand, &PoseError::deg);
    write(image, "time, s", {0.5 * (kLeft_px + kWidth_px - kRight_px), height_px - 14.0}, 0.5);
  }
  cv::Mat reduced;
  cv::resize(image, reduced, {kWidth_px, height_px}, 0, 0, cv::INTER_AREA);
  writePng(png, {reduced.cols, reduced.rows},
           {reduced.ptr<std::uint8_t>(),
            static_cast<std::size_t>(reduced.cols) * static_cast<std::size_t>(reduced.rows) * 4});
}

}  // namespace airclay
