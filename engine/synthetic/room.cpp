// SPDX-License-Identifier: MIT
#include "engine/synthetic/room.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/error.h"
#include "engine/synthetic/figure_view.h"
#include "engine/synthetic/room_script.h"

namespace airclay {
namespace {

/// Samples per pixel: each with its own instant of the exposure and its own place in the pixel.
constexpr int kSamples = 16;
/// How long before it first appears the hand starts to move, if nobody is there during the background's
/// frames: it appears on its way into the cube.
constexpr double kUnderWayS = 0.75;
constexpr double kSlowCloudS = 1.6, kSuddenS = 0.1, kCloudLight = 0.6;

struct Sample {
  double time;           ///< of the exposure, -1/2 to 1/2
  Vec2 offset;           ///< from the pixel's centre, -1/2 to 1/2
  std::size_t quadrant;  ///< of the pixel: RoomView::depth_m
};

/// Sample i is in column i of 16, with a row and an instant of its own, and four are in each quadrant. Found
/// by random exchanges: a straight edge of any direction and place covers a fraction of the samples that is
/// within 3 % (RMS) of the area that it covers, and the instants do not correlate with the places.
std::array<Sample, kSamples> samplePattern() {
  constexpr std::array<int, kSamples> kRows = {5, 12, 9, 1, 15, 7, 2, 11, 4, 13, 8, 0, 14, 6, 3, 10};
  constexpr std::array<int, kSamples> kInstants = {13, 9, 0, 2, 6, 10, 12, 14, 7, 8, 3, 4, 1, 15, 5, 11};
  const auto spread = [](std::size_t i) { return (static_cast<double>(i) + 0.5) / kSamples - 0.5; };
  std::array<Sample, kSamples> samples;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const Vec2 offset(spread(i), spread(static_cast<std::size_t>(kRows[i])));
    samples[i] = {spread(static_cast<std::size_t>(kInstants[i])), offset,
                  static_cast<std::size_t>((offset.x() > 0) + 2 * (offset.y() > 0))};
  }
  return samples;
}

std::uint64_t mixed(std::uint64_t x) {  // splitmix64 (Steele, Lea and Flood 2014)
  x += 0x9e3779b97f4a7c15;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
  x = (x ^ x >> 27) * 0x94d049bb133111eb;
  return x ^ x >> 31;
}

/// Quantiles of the normal distribution, 2¹² of them.
std::vector<float> normalTable() {
  constexpr int kCount = 1 << 12;
  std::vector<float> table;
  for (int i = 0; i < kCount; ++i) {
    double low = -5, high = 5;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (0.5 * std::erfc(-middle / std::numbers::sqrt2) < (i + 0.5) / kCount ? low : high) = middle;
    }
    table.push_back(static_cast<float>(low));
  }
  return table;
}

/// Image values from 0 to 255 of linear light from 0 to 1, interpolated.
class Encoding {
 public:
  Encoding() {
    for (std::size_t i = 0; i < table_.size(); ++i)
      table_[i] = 255 * static_cast<float>(std::pow(static_cast<double>(i) / kSteps, 1 / kEncodingGamma));
  }
  float operator()(float linear) const {
    const float place = std::clamp(linear, 0.f, 1.f) * kSteps;
    const auto i = static_cast<std::size_t>(place);
    return table_[i] + (place - static_cast<float>(i)) * (table_[i + 1] - table_[i]);
  }

 private:
  static constexpr int kSteps = 4096;
  std::array<float, kSteps + 2> table_;
};

/// The drift of one camera.
struct Drift {
  double sign, period_s, white_sign, white_period_s, offset_s;
};

struct CameraParts {
  Camera camera;                 ///< camera_from_room in place of camera_from_world
  std::optional<RoomView> view;  ///< since the first image
  FigureView figure;
  Drift drift;
  bool shows_figure = false;  ///< in the last image

  /// Linear light: of the figure in front of the room.
  Vec3f lightAt(int x, int y, std::size_t i, const std::optional<DeskShadow>& shadow, float daylight) const {
    Eigen::Vector2f reaches(1, daylight);
    if (shadow && !std::isnan(view->desk[i].x())) reaches = reaches.cwiseProduct(shadow->at(view->desk[i]));
    const Vec3f room = reaches.x() * view->ambient[i] + reaches.y() * view->window[i];
    const bool is_inside =
        shows_figure && x >= figure.left() && x < figure.right() && y >= figure.top() && y < figure.bottom();
    const int shown = is_inside ? figure.figureSamples()[i] : 0;
    if (shown == 0) return room;
    return (1.f / kSamples) * (figure.light()[i] + static_cast<float>(kSamples - shown) * room);
  }
  /// The lens darkens the corners by 30 %.
  float vignette(int x, int y) const {
    const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    const float dx = static_cast<float>(x) - 0.5f * width, dy = static_cast<float>(y) - 0.5f * height;
    return 1 - 0.3f * (dx * dx + dy * dy) * 4 / (width * width + height * height);
  }
};

/// What a camera's electronics make of an image value: gain, noise whose variance grows with the value, a
/// byte.
class Sensitivity {
 public:
  Sensitivity(const RoomOptions& options, const Vec3& gain)
      : gain_(gain.cast<float>()),
        dark_(static_cast<float>(std::pow(options.noise_dark, 2))),
        per_value_((static_cast<float>(std::pow(options.noise_bright, 2)) - dark_) / 255) {}

  /// `encoded`: from 0 to 255; `normal`: a normally distributed number.
  std::uint8_t value(float encoded, int channel, float normal) const {
    const float value = encoded * gain_[channel];
    const float noisy = value + std::sqrt(std::max(dark_ + per_value_ * value, 0.f)) * normal;
    return static_cast<std::uint8_t>(std::clamp(noisy + 0.5f, 0.f, 255.f));
  }

 private:
  Vec3f gain_;
  float dark_, per_value_;
};

RoomPath pathOf(const RoomOptions& options) {
  const double appears_s = options.background_frames / options.rate_hz;
  const bool seated = options.background == BackgroundFrames::kSeated;
  RoomPath path;
  path.seed = options.seed + 500;
  path.begins_s = seated ? appears_s : appears_s - kUnderWayS;
  // the hand is still on its way out in the last frame
  path.ends_s = appears_s + options.hand_frames / options.rate_hz + 0.65;
  path.peak_speed_m_s = options.peak_speed_m_s;
  path.still_s = options.still_s;
  return path;
}

}  // namespace

Rig roomRig(int count, const Pose& world_from_room) {
  struct Place {
    const char* name;
    double azimuth_degrees, elevation_degrees, distance_m, focal_pixels, k1, k2;
  };
  // The person sits at azimuth 270. No two are opposite each other.
  const Place places[] = {
      {"left", 142, 27, 1.02, 556, -0.156, 0.054},  {"right", 48, 24, 1.08, 561, -0.177, 0.042},
      {"above", 100, 74, 0.98, 552, -0.142, 0.047}, {"side", 8, 20, 1.00, 548, -0.150, 0.039},
      {"front", 84, 33, 1.10, 566, -0.163, 0.051},  {"far", 176, 38, 1.05, 550, -0.139, 0.044},
      {"back", 318, 55, 0.94, 543, -0.171, 0.058},  {"over", 218, 52, 0.97, 558, -0.148, 0.036}};
  if (count < 2 || count > 8) throw Error("the room has 2 to 8 cameras, not " + std::to_string(count));
  Rig rig;
  for (int i = 0; i < count; ++i) {
    const Place& place = places[i];
    Camera camera;
    camera.name = place.name;
    camera.width = 640;
    camera.height = 480;
    camera.lens.fx = camera.lens.fy = place.focal_pixels;
    camera.lens.cx = 319.5 + 2.5 * std::sin(i + 1.0);
    camera.lens.cy = 239.5 + 2.5 * std::cos(3.0 * i);
    camera.lens.distortion = {place.k1, place.k2, 5e-4 * std::sin(2.0 * i), 5e-4 * std::cos(5.0 * i), 0, 0,
                              0,        0};
    camera.lens = withMonotonicRange(camera.lens);
    const double azimuth = place.azimuth_degrees * std::numbers::pi / 180;
    const double elevation = place.elevation_degrees * std::numbers::pi / 180;
    const Vec3 eye = place.distance_m * Vec3(std::cos(elevation) * std::cos(azimuth),
                                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    // not exactly at the centre, nor exactly upright
    const Vec3 target(0.02 * std::sin(7.0 * i), 0.02 * std::cos(4.0 * i), 0.01 * std::sin(3.0 * i));
    const Vec3 forward = (target - eye).normalized();
    const Vec3 up = Vec3::UnitZ() + 0.05 * std::sin(2.0 * i + 1) * forward.cross(Vec3::UnitZ());
    const Vec3 right = forward.cross(up).normalized();
    Pose room_from_camera = Pose::Identity();
    room_from_camera.linear() << right, forward.cross(right), forward;
    room_from_camera.translation() = eye;
    camera.camera_from_world = (world_from_room * room_from_camera).inverse();
    rig.cameras.push_back(camera);
  }
  rig.workspace.center = world_from_room.translation();
  return rig;
}

struct Room::Parts {
  RoomOptions options;
  std::vector<Vec3> skin;  ///< the hand's vertices, hand frame, unscaled
  Person person;
  RoomScene scene;
  FigureColors colors;
  HandScript script;
  double script_begins_s, appears_s;
  std::vector<CameraParts> cameras;
  std::array<Sample, kSamples> samples = samplePattern();
  std::vector<float> normal_table = normalTable();
  Encoding encode;

  Parts(const HandModel& hand, const RoomOptions& o)
      : options(o),
        skin(hand.skin.vertices),
        person(hand, o),
        scene(o),
        colors(o),
        script(roomScript(pathOf(o))),
        script_begins_s(pathOf(o).begins_s),
        appears_s(o.background == BackgroundFrames::kSeated ? -1e9 : o.background_frames / o.rate_hz) {
    Random random(o.seed + 600);
    for (Camera camera : o.rig.cameras) {
      camera.camera_from_world = camera.camera_from_world * o.world_from_room;  // now camera_from_room
      const Drift drift{random.uniform(0, 1) < 0.5 ? -1. : 1., random.uniform(2.2, 4.5),
                        random.uniform(0, 1) < 0.5 ? -1. : 1., random.uniform(2.5, 5), random.uniform(0, 1)};
      cameras.push_back({camera, std::nullopt, FigureView(camera, person.mesh(), colors), drift});
    }
    // the offsets span the whole spread
    double low = 1, high = 0;
    for (const CameraParts& camera : cameras)
      low = std::min(low, camera.drift.offset_s), high = std::max(high, camera.drift.offset_s);
    for (CameraParts& camera : cameras)
      camera.drift.offset_s =
          high > low ? o.clock_spread_s * (camera.drift.offset_s - low) / (high - low) : 0;
  }

  /// Empty while nobody is there.
  std::optional<Pose> roomFromWrist(double time_s) const {
    if (time_s < appears_s) return std::nullopt;
    return person.sided(*script.at(std::max(time_s, script_begins_s)));
  }
  std::vector<Vec3f> vertexLight(const BonePoses& poses, double daylight) const;
  void drawFigure(CameraParts& camera, double time_s, double daylight);
  DeskShadow shadowOf(const BonePoses& poses) const;
};

Room::Room(const HandModel& hand, const RoomOptions& options)
    : parts_(std::make_unique<Parts>(hand, options)) {}
Room::~Room() = default;
Room::Room(Room&&) noexcept = default;

std::optional<Pose> Room::handAt(double time_s) const {
  const std::optional<Pose> room_from_wrist = parts_->roomFromWrist(time_s);
  if (!room_from_wrist) return std::nullopt;
  return parts_->options.world_from_room * *room_from_wrist * parts_->person.handFromWrist().inverse();
}

bool Room::isHandInCube(double time_s) const {
  const std::optional<Pose> world_from_hand = handAt(time_s);
  if (!world_from_hand) return false;
  const Workspace& cube = parts_->options.rig.workspace;
  return std::ranges::all_of(parts_->skin, [&](const Vec3& vertex) {
    const Vec3 from_center = *world_from_hand * Vec3(parts_->options.hand_scale * vertex) - cube.center;
    return from_center.cwiseAbs().maxCoeff() <= 0.5 * cube.edge_m;
  });
}

std::vector<double> Room::cameraTimesOf(int frame) const {
  std::vector<double> times;
  for (const CameraParts& camera : parts_->cameras)
    times.push_back(frame / parts_->options.rate_hz + camera.drift.offset_s);
  return times;
}

Vec3 Room::gainAt(std::size_t camera, double time_s) const {
  const RoomOptions& options = parts_->options;
  const Drift& drift = parts_->cameras[camera].drift;
  const double exposure =
      1 + options.exposure_drift * drift.sign * std::sin(2 * std::numbers::pi * time_s / drift.period_s);
  const double red = options.white_balance_drift * drift.white_sign *
                     std::sin(2 * std::numbers::pi * time_s / drift.white_period_s);
  return exposure * Vec3(1 + red, 1, 1 - red);
}

double Room::daylightAt(double time_s) const {
  const RoomOptions& options = parts_->options;
  const double middle_s = (options.background_frames + 0.5 * options.hand_frames) / options.rate_hz;
  const double from_middle_s = time_s - middle_s;
  if (options.daylight == Daylight::kSlow)
    return 1 - (1 - kCloudLight) * std::exp(-std::pow(from_middle_s / (0.5 * kSlowCloudS), 2));
  if (options.daylight == Daylight::kSudden)
    return 1 - (1 - kCloudLight) * std::clamp(from_middle_s / kSuddenS + 0.5, 0., 1.);
  return 1;
}

/// Ambient light from above and, less, from the desk; the window's light, which skin carries a little past
/// the terminator.
std::vector<Vec3f> Room::Parts::vertexLight(const BonePoses& poses, double daylight) const {
  const FigureMesh& mesh = person.mesh();
  std::vector<Vec3f> light(mesh.positions.size());
  const Vec3f to_window = scene.toWindow().cast<float>();
  const auto window = kWindowLight * static_cast<float>(daylight);
  for (const FigureMesh::Part& part : mesh.parts) {
    const Eigen::Matrix3f room_from_bone = poses[static_cast<std::size_t>(part.bone)].linear().cast<float>();
    for (std::uint32_t i = part.first; i < part.first + part.count; ++i) {
      const Vec3f normal = room_from_bone * mesh.normals[i];
      const Vec3f bleed(0.30f, 0.20f, 0.16f);
      const Eigen::Array3f facing =
          ((Vec3f::Constant(normal.dot(to_window)) + bleed).array() / (1 + bleed.array())).max(0.f);
      const float around = kAmbientLight * (0.62f + 0.38f * normal.z()) * mesh.open[i];
      const Vec3f received = (around + window * (0.35f + 0.65f * mesh.open[i]) * facing).matrix();
      light[i] = received.cwiseProduct(mesh.tint[i]);
    }
  }
  return light;
}

void Room::Parts::drawFigure(CameraParts& camera, double time_s, double daylight) {
  camera.figure.begin(vertexLight(person.poses(*roomFromWrist(time_s), time_s), daylight));
  for (const Sample& sample : samples) {
    const double instant_s = std::max(time_s + sample.time * options.exposure_s, appears_s);
    camera.figure.addSample(person.poses(*roomFromWrist(instant_s), instant_s), sample.offset,
                            camera.view->depth_m[sample.quadrant]);
  }
}

DeskShadow Room::Parts::shadowOf(const BonePoses& poses) const {
  DeskShadow shadow;
  for (const ShadowBall& ball : person.shadowBalls())
    shadow.add(poses[static_cast<std::size_t>(ball.bone)] * ball.center, ball.radius_m, scene.toWindow());
  return shadow;
}

void Room::render(std::size_t index, int frame, std::span<std::uint8_t> bgr) {
  Parts& parts = *parts_;
  CameraParts& camera = parts.cameras[index];
  const double time_s = cameraTimesOf(frame)[index], daylight = daylightAt(time_s);
  if (!camera.view) camera.view = parts.scene.view(camera.camera);
  const std::optional<Pose> room_from_wrist = parts.roomFromWrist(time_s);
  camera.shows_figure = room_from_wrist.has_value();
  std::optional<DeskShadow> shadow;
  if (room_from_wrist) {
    parts.drawFigure(camera, time_s, daylight);
    if (parts.options.has_shadows) shadow = parts.shadowOf(parts.person.poses(*room_from_wrist, time_s));
  }
  const Sensitivity sensitivity(parts.options, gainAt(index, time_s));
  const std::uint64_t key =
      mixed((std::uint64_t(parts.options.seed) << 40) ^ (std::uint64_t(index) << 32) ^ std::uint64_t(frame));
  const int width = camera.camera.width, height = camera.camera.height;
  std::size_t i = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, ++i) {
      const Vec3f linear =
          camera.vignette(x, y) * camera.lightAt(x, y, i, shadow, static_cast<float>(daylight));
      std::uint64_t chance = mixed(key + i);
      for (const int channel : {2, 1, 0}) {  // blue first
        const float normal = parts.normal_table[chance & (parts.normal_table.size() - 1)];
        chance >>= 12;
        bgr[3 * i + static_cast<std::size_t>(2 - channel)] =
            sensitivity.value(parts.encode(linear[channel]), channel, normal);
      }
    }
}

std::vector<float> Room::handCoverage(std::size_t index) const {
  const CameraParts& camera = parts_->cameras[index];
  std::vector<float> coverage(camera.figure.handSamples().size(), 0.f);
  if (camera.shows_figure)
    for (std::size_t i = 0; i < coverage.size(); ++i)
      coverage[i] = static_cast<float>(camera.figure.handSamples()[i]) / kSamples;
  return coverage;
}

}  // namespace airclay
