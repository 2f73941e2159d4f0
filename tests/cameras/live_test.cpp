// SPDX-License-Identifier: MIT
// Live cameras: matching frames by their times, failures and recovery.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>
#include <thread>

#include "capture/cameras/live_cameras.h"
#include "capture/cameras/v4l2_devices.h"
#include "capture/images/video_writer.h"
#include "capture/takes/frame_matcher.h"
#include "engine/core/error.h"
#include "tests/support/mjpeg_server.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

namespace fs = std::filesystem;
using Ids = std::vector<std::optional<std::uint64_t>>;
constexpr std::nullopt_t kMissing = std::nullopt;

// ----------------------------------------------------------------------------------------- FrameMatcher

/// Times in milliseconds; ids count a camera's frames from 0.
struct Matching {
  FrameMatcher matcher;
  std::vector<std::uint64_t> next_ids;

  Matching(std::size_t cameras, double max_skew_ms, double patience_ms = 100, std::size_t queue = 8)
      : matcher(cameras, {max_skew_ms / 1000, patience_ms / 1000, queue}), next_ids(cameras) {}
  void add(std::size_t camera, std::initializer_list<double> times_ms) {
    for (const double time_ms : times_ms) matcher.add(camera, time_ms / 1000, next_ids[camera]++);
  }
  std::optional<Ids> newest(double now_ms) {
    const auto set = matcher.newest(now_ms / 1000);
    return set ? std::optional(set->ids) : std::nullopt;
  }
  std::vector<Ids> all(double now_ms) {
    std::vector<Ids> sets;
    while (const auto set = matcher.next(now_ms / 1000)) sets.push_back(set->ids);
    return sets;
  }
};

TEST(FrameMatcher, NewestCompleteSetWins) {
  Matching m(3, 16);
  m.add(0, {0, 33, 67});
  m.add(1, {5, 38, 71});
  EXPECT_EQ(m.newest(71), std::nullopt) << "the third camera may still deliver";
  m.add(2, {9, 42});
  EXPECT_EQ(m.newest(72), (Ids{1, 1, 1})) << "the older set is skipped";
  m.add(2, {76});
  EXPECT_EQ(m.newest(77), (Ids{2, 2, 2}));
  EXPECT_EQ(m.newest(500), std::nullopt) << "no frame is returned twice";
  for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(m.matcher.dropped(c), 0u);
}

TEST(FrameMatcher, SkewIsBoundedAndReported) {
  Matching m(2, 10);
  m.add(0, {0, 33});
  m.add(1, {15, 48});
  EXPECT_EQ(m.newest(50), std::nullopt);
  ASSERT_TRUE(m.matcher.excessSkew());
  EXPECT_NEAR(*m.matcher.excessSkew(), 0.015, 1e-12);
  Matching wider(2, 15.001);
  wider.add(0, {0, 33});
  wider.add(1, {15, 48});
  const auto set = wider.matcher.newest(0.05);
  ASSERT_TRUE(set);
  EXPECT_EQ(set->ids, (Ids{1, 1}));
  EXPECT_TRUE(set->complete);
  EXPECT_NEAR(set->skew_s, 0.015, 1e-12);
  EXPECT_EQ(wider.matcher.excessSkew(), std::nullopt);
}

TEST(FrameMatcher, WaitsForALateCamera) {
  Matching m(3, 16, 100);
  m.add(0, {0});
  m.add(1, {4});
  EXPECT_EQ(m.newest(99), std::nullopt);
  const auto set = m.matcher.newest(0.101);
  ASSERT_TRUE(set);
  EXPECT_EQ(set->ids, (Ids{0, 0, kMissing}));
  EXPECT_FALSE(set->complete);
  EXPECT_TRUE(std::isnan(set->times_s[2]));
  EXPECT_NEAR(set->skew_s, 0.004, 1e-12);
  // its frame of that instant arrives now: too late for that set and all later ones
  m.add(2, {2, 35});
  m.add(0, {33});
  m.add(1, {37});
  EXPECT_EQ(m.newest(110), (Ids{1, 1, 1}));
}

TEST(FrameMatcher, MissingCameraIsSkippedAndRejoins) {
  Matching m(3, 16);
  m.matcher.expect(2, false);
  m.add(0, {0});
  m.add(1, {4});
  const auto set = m.matcher.newest(0.005);
  ASSERT_TRUE(set) << "immediately";
  EXPECT_EQ(set->ids, (Ids{0, 0, kMissing}));
  EXPECT_FALSE(set->complete) << "a camera is missing";
  m.matcher.expect(2, true);
  m.add(2, {34});
  m.add(0, {33});
  m.add(1, {37});
  EXPECT_EQ(m.newest(38), (Ids{1, 1, 0}));
}

TEST(FrameMatcher, SingleCameraIsASetOnlyInASingleCameraRig) {
  Matching two(2, 16);
  two.add(0, {0, 33});
  EXPECT_EQ(two.newest(1000), std::nullopt);
  two.matcher.expect(1, false);
  EXPECT_EQ(two.newest(1000), std::nullopt);
  EXPECT_TRUE(two.all(1000).empty());
  Matching one(1, 16);
  one.add(0, {0, 33});
  EXPECT_EQ(one.newest(33), (Ids{1}));
}

TEST(FrameMatcher, SetsArriveInOrder) {
  Matching m(2, 33);
  m.add(0, {0, 33, 67, 100});
  m.add(1, {3, 36, 70, 103});
  EXPECT_EQ(m.all(104), (std::vector<Ids>{{0, 0}, {1, 1}, {2, 2}, {3, 3}}));
}

TEST(FrameMatcher, SkipsAtMostOneFrameForATighterMatch) {
  // 25 ms one way, 8 the other: the first frame has no better partner, all others do
  Matching m(2, 33, 500);
  m.add(0, {0});
  m.add(1, {25});
  EXPECT_TRUE(m.all(26).empty()) << "the next frame may fit better";
  m.add(0, {33, 67, 100, 133});
  m.add(1, {58, 92, 125});
  EXPECT_EQ(m.all(134), (std::vector<Ids>{{1, 0}, {2, 1}, {3, 2}, {4, 3}}));
  EXPECT_EQ(m.matcher.dropped(0), 1u);
  EXPECT_EQ(m.matcher.dropped(1), 0u);
}

TEST(FrameMatcher, WideBoundDoesNotMixInstants) {
  // both could be matched with the other's older frame, 32 ms away; the nearer ones arrive a moment later
  Matching m(3, 34, 100);
  m.add(0, {0, 33, 67});
  m.add(1, {1, 34});
  m.add(2, {2, 35});
  EXPECT_EQ(m.newest(67), (Ids{1, 1, 1}));
  m.add(1, {68});
  EXPECT_EQ(m.newest(68), std::nullopt);
  m.add(2, {69});
  EXPECT_EQ(m.newest(69), (Ids{2, 2, 2}));
}

TEST(FrameMatcher, HalfPeriodOffsetWithJitterLosesNothing) {
  Matching m(2, 34, 500, 400);
  std::mt19937 random(3);
  std::normal_distribution<double> flutter_ms(0, 1.5);
  for (int k = 0; k < 300; ++k) {
    m.add(0, {1000 / 30.0 * k + flutter_ms(random)});
    m.add(1, {1000 / 30.0 * (k + 0.5) + flutter_ms(random)});
  }
  const std::vector<Ids> sets = m.all(10000);
  EXPECT_GE(sets.size(), 299u);
  EXPECT_LE(m.matcher.dropped(0) + m.matcher.dropped(1), 1u);
}

TEST(FrameMatcher, MissedFrameShiftsNothing) {
  Matching m(3, 33, 500);
  m.add(0, {0, 33, 67, 100});
  m.add(1, {1, 34, 100});  // misses 67
  m.add(2, {2, 35, 69, 102});
  EXPECT_EQ(m.all(103), (std::vector<Ids>{{0, 0, 0}, {1, 1, 1}, {2, kMissing, 2}, {3, 2, 3}}));
}

TEST(FrameMatcher, DifferentRatesDropOnlySurplusFrames) {
  // ten seconds at 30 and 29.97 Hz: 300 and 299 or 300 frames
  Matching m(2, 34, 500, 400);
  for (int k = 0; k < 300; ++k) m.add(0, {1000 / 30.0 * k});
  for (int k = 0; k < 299; ++k) m.add(1, {1000 / 29.97 * k + 12});
  EXPECT_GE(m.all(9999).size(), 298u);
}

TEST(FrameMatcher, QueuesAreBounded) {
  Matching m(2, 16, 100, 4);
  for (int k = 0; k < 1000; ++k) m.add(0, {33.0 * k});
  EXPECT_EQ(m.matcher.waiting(0), 4u);
  EXPECT_EQ(m.matcher.dropped(0), 996u);
  EXPECT_EQ(m.matcher.oldestWaiting(0), 996u);
  EXPECT_FALSE(m.matcher.add(0, 0.001, 1000)) << "time decreases";
}

// ----------------------------------------------------------------------------------------- sources

TEST(Source, RecognizesEveryForm) {
  const TemporaryFolder folder;
  const auto kindOf = [](const std::string& text) { return parseSource(text).kind; };
  EXPECT_EQ(kindOf("0"), SourceKind::kDevice);
  EXPECT_EQ(parseSource("2").text, "/dev/video2");
  EXPECT_EQ(kindOf("/dev/video1"), SourceKind::kDevice);
  EXPECT_EQ(kindOf("left.mp4"), SourceKind::kVideo);
  EXPECT_EQ(kindOf("images/img_%04d.png"), SourceKind::kImages);
  EXPECT_EQ(kindOf(folder.path().string()), SourceKind::kImages);
  EXPECT_EQ(kindOf("rtsp://10.0.0.2:8554/left"), SourceKind::kStream);
  EXPECT_EQ(kindOf("gst: videotestsrc"), SourceKind::kPipeline);
  EXPECT_EQ(parseSource("gst: videotestsrc").text, "videotestsrc");
  EXPECT_EQ(kindOf("videotestsrc ! video/x-raw,width=64"), SourceKind::kPipeline);
  for (const char* bad : {"", "gst:", "ftp://camera/x"})
    EXPECT_NE(messageOf([&] { parseSource(bad); }).find("expected"), std::string::npos) << bad;
  EXPECT_EQ(parseNamedSource("left=rtsp://a/b=c").source.text, "rtsp://a/b=c");
  for (const char* bad : {"left", "=0", "a/b=0", "..=0", "left="})
    EXPECT_NE(messageOf([&] { parseNamedSource(bad); }).find("--camera "), std::string::npos) << bad;
}

TEST(Source, ErrorsNameCameraAndSource) {
  for (const char* source :
       {"/dev/video63", "none.mp4", "none/%06d.png", "tcp://127.0.0.1:9", "gst: noSuchElement"}) {
    const std::string message = messageOf([&] { openSource({"left", parseSource(source)}); });
    EXPECT_NE(message.find("camera \"left\""), std::string::npos) << message;
    EXPECT_NE(message.find(parseSource(source).text), std::string::npos) << message;
    EXPECT_NE(message.find("expected"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

/// A uniform image with the brightness `grey`.
LiveImage flat(int grey, ImageSize size = {64, 48}) {
  return {size, std::vector<std::uint8_t>(3 * std::size_t(size.width) * std::size_t(size.height),
                                          std::uint8_t(grey))};
}

constexpr ImageSize kVideoSize = {256, 32};

/// A video whose frame k, below 60, is white from column 4 k on: coding blurs it by less.
void writeSweep(const fs::path& file, int frames, double rate_hz) {
  VideoWriter writer(file, {kVideoSize, rate_hz, VideoWriter::Format::kBgr8});
  for (int k = 0; k < frames; ++k) {
    LiveImage image = flat(0, kVideoSize);
    for (std::size_t i = 0; i < image.bgr.size(); ++i)
      if (int(i) / 3 % kVideoSize.width >= 4 * k) image.bgr[i] = 255;
    writer.write(image.bgr);
  }
  writer.finish();
}

/// The index of a frame of that video.
int frameOf(const LiveImage& image) {
  int black = 0;
  for (int x = 0; x < kVideoSize.width; ++x)
    black += image.bgr[std::size_t(3 * (16 * kVideoSize.width + x))] < 128;
  return static_cast<int>(std::lround(black / 4.0));
}

TEST(Source, FilesRunInRealTime) {
  const TemporaryFolder folder;
  writeSweep(folder / "left.mp4", 25, 50);
  const auto source = openSource({"left", parseSource((folder / "left.mp4").string())});
  EXPECT_EQ(source->size(), kVideoSize);
  EXPECT_DOUBLE_EQ(source->rateHz(), 50);
  EXPECT_EQ(source->times(), TimeOrigin::kFile);
  const double start_s = secondsNow();
  LiveImage image;
  double first_s = 0;
  for (int k = 0; k < 25; ++k) {
    double capture_s = 0;
    ASSERT_TRUE(source->read(image, capture_s));
    if (k == 0) first_s = capture_s;
    EXPECT_NEAR(capture_s - first_s, k / 50.0, 1e-9);
    EXPECT_GE(secondsNow(), capture_s - 1e-3) << "frame arrives early";
    EXPECT_EQ(frameOf(image), k);
  }
  EXPECT_GE(secondsNow() - start_s, 24 / 50.0 - 1e-3);
  double ignored = 0;
  EXPECT_FALSE(source->read(image, ignored));
}

TEST(Source, LoopsOnRequest) {
  const TemporaryFolder folder;
  writeSweep(folder / "left.mp4", 4, 100);
  const auto source = openSource({"left", parseSource((folder / "left.mp4").string())}, {.loop = true});
  LiveImage image;
  double before_s = 0, capture_s = 0;
  for (int k = 0; k < 11; ++k, before_s = capture_s) {
    ASSERT_TRUE(source->read(image, capture_s));
    EXPECT_EQ(frameOf(image), k % 4);
    EXPECT_TRUE(k == 0 || std::abs(capture_s - before_s - 0.01) < 1e-9) << k;
  }
}

TEST(ArrivalClock, RemovesJitter) {
  std::mt19937 random(5);
  std::exponential_distribution<double> jitter_s(1 / 0.02);
  ArrivalClock clock;
  double worst_s = 0;
  for (int k = 0; k < 600; ++k) {
    const double truth_s = 100 + k / 30.0, arrival_s = truth_s + 0.05 + jitter_s(random);
    const double estimate_s = clock.captureOf(arrival_s, k / 30.0);
    if (k > 60) worst_s = std::max(worst_s, std::abs(estimate_s - truth_s - 0.05));
  }
  EXPECT_LT(worst_s, 0.002) << "20 ms of jitter";
  // the stream restarts: its times start at 0
  double estimate_s = 0;
  for (int k = 0; k < 10; ++k) estimate_s = clock.captureOf(200 + k / 30.0, k / 30.0);
  EXPECT_NEAR(estimate_s, 200 + 9 / 30.0, 1e-9);
}

// ----------------------------------------------------------------------------------------- LiveCameras

/// The behaviour of a fake camera, controlled by the test while it runs.
struct FakeState {
  std::atomic<bool> silent = false, dead = false, same = false, blocked = false;
  std::atomic<double> late_s = 0;
  std::atomic<int> opened = 0;
};

/// A camera of 50 Hz.
class FakeSource : public CameraSource {
 public:
  explicit FakeSource(FakeState& state) : state_(state) {
    if (state_.dead) throw Error("camera is unplugged");
    ++state_.opened;
    ++alive;
  }
  ~FakeSource() override { --alive; }
  ImageSize size() const override { return {64, 48}; }
  double rateHz() const override { return 50; }
  TimeOrigin times() const override { return TimeOrigin::kBuffer; }
  bool read(LiveImage& image, double& capture_s) override {
    while (state_.blocked) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    while (state_.silent && !state_.dead && !stopped_)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    // all fakes run synchronously
    const double tick = std::floor(secondsNow() * 50) + 1;
    while (secondsNow() < tick / 50 + state_.late_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (state_.dead) throw Error("camera was unplugged");
    capture_s = tick / 50;
    if (!state_.same) ++grey_;
    image = flat(grey_ & 255);
    return !stopped_;
  }
  void stop() override { stopped_ = true; }

  static inline std::atomic<int> alive = 0;

 private:
  FakeState& state_;
  int grey_ = 0;
  std::atomic<bool> stopped_ = false;
};

struct ThreeFakes {
  FakeState states[3];
  std::unique_ptr<LiveCameras> cameras;

  explicit ThreeFakes(const LiveOptions& options = {}) {
    std::vector<LiveCamera> all;
    for (int c = 0; c < 3; ++c)
      all.push_back(
          {"cam" + std::to_string(c), [this, c] { return std::make_unique<FakeSource>(states[c]); }});
    cameras = std::make_unique<LiveCameras>(std::move(all), options);
  }
  CameraState stateOf(std::size_t c) const { return cameras->status()[c].state; }
  bool becomes(std::size_t c, CameraState state) {
    return waitUntil([&] { return cameras->next(0.01), stateOf(c) == state; });
  }
  /// The next set that is complete, or incomplete.
  std::optional<LiveSet> nextWhere(bool complete) {
    std::optional<LiveSet> set;
    waitUntil([&] { return (set = cameras->next(0.1)) && set->complete == complete; });
    return set;
  }
};

TEST(LiveCameras, SetsContainOneInstant) {
  ThreeFakes fakes;
  double before_s = 0;
  for (int k = 0; k < 20; ++k) {
    const auto set = fakes.cameras->next(5);
    ASSERT_TRUE(set);
    EXPECT_TRUE(set->complete);
    EXPECT_LT(set->skew_s, 1e-9);
    EXPECT_GT(set->time_s, before_s);
    before_s = set->time_s;
    for (const LiveImage& image : set->images) EXPECT_EQ(image.bgr.size(), 64u * 48 * 3);
  }
  EXPECT_EQ(fakes.stateOf(0), CameraState::kLive);
}

TEST(LiveCameras, FrozenCameraDoesNotStopTheOthers) {
  ThreeFakes fakes;
  ASSERT_TRUE(fakes.nextWhere(true));
  fakes.states[1].silent = true;
  ASSERT_TRUE(fakes.becomes(1, CameraState::kFrozen));
  const auto set = fakes.cameras->next(5);
  ASSERT_TRUE(set);
  EXPECT_FALSE(set->complete);
  EXPECT_TRUE(set->images[1].bgr.empty());
  EXPECT_FALSE(set->images[2].bgr.empty());
  EXPECT_EQ(fakes.stateOf(2), CameraState::kLive);
  fakes.states[1].silent = false;
  ASSERT_TRUE(fakes.nextWhere(true)) << "it rejoins";
  EXPECT_GT(fakes.cameras->status()[1].drops, 10u) << "half a second at 50 Hz";
}

TEST(LiveCameras, RepeatedImagesCountAsFrozen) {
  ThreeFakes fakes;
  ASSERT_TRUE(fakes.nextWhere(true));
  fakes.states[2].same = true;
  EXPECT_TRUE(fakes.becomes(2, CameraState::kFrozen));
  const auto set = fakes.nextWhere(false);
  ASSERT_TRUE(set);
  EXPECT_TRUE(set->images[2].bgr.empty()) << "a stale image is not used";
  fakes.states[2].same = false;
  EXPECT_TRUE(fakes.nextWhere(true));
}

TEST(LiveCameras, LostCameraIsReopenedAndRejoins) {
  ThreeFakes fakes;
  ASSERT_TRUE(fakes.nextWhere(true));
  fakes.states[0].dead = true;
  ASSERT_TRUE(fakes.becomes(0, CameraState::kReconnecting));
  EXPECT_EQ(fakes.cameras->status()[0].fault.rfind("camera ", 0), 0u);
  ASSERT_TRUE(fakes.nextWhere(false));
  fakes.states[0].dead = false;
  ASSERT_TRUE(fakes.nextWhere(true));
  EXPECT_EQ(fakes.states[0].opened, 2);
  EXPECT_EQ(fakes.cameras->status()[0].reconnects, 1);
  EXPECT_TRUE(fakes.becomes(0, CameraState::kLive));
}

TEST(LiveCameras, FewerThanTwoCamerasGiveNoSet) {
  ThreeFakes fakes;
  ASSERT_TRUE(fakes.nextWhere(true));
  fakes.states[0].dead = fakes.states[1].dead = true;
  ASSERT_TRUE(fakes.becomes(0, CameraState::kReconnecting));
  ASSERT_TRUE(fakes.becomes(1, CameraState::kReconnecting));
  while (fakes.cameras->next(0.2)) {
  }
  EXPECT_EQ(fakes.cameras->next(0.3), std::nullopt);
  fakes.states[0].dead = false;
  const auto set = fakes.cameras->next(10);
  ASSERT_TRUE(set);
  EXPECT_TRUE(set->images[1].bgr.empty());
}

TEST(LiveCameras, StopsWhileAReadBlocks) {
  auto fakes = std::make_unique<ThreeFakes>();
  ASSERT_TRUE(fakes->nextWhere(true));
  fakes->states[1].blocked = true;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const double start_s = secondsNow();
  fakes->cameras.reset();
  EXPECT_LT(secondsNow() - start_s, 1.0);
  fakes->states[1].blocked = false;
  EXPECT_TRUE(waitUntil([] { return FakeSource::alive == 0; })) << "the thread ends";
}

TEST(LiveCameras, SubtractsOffsets) {
  FakeState states[2];
  std::vector<LiveCamera> all;
  for (int c = 0; c < 2; ++c)
    all.push_back({"cam" + std::to_string(c),
                   [&states, c] { return std::make_unique<FakeSource>(states[c]); }, c == 1 ? 0.04 : 0});
  LiveCameras cameras(std::move(all), {.max_skew_s = 0.001});
  const auto set = cameras.next(5);
  ASSERT_TRUE(set);
  EXPECT_LT(set->skew_s, 1e-6) << "two frames of 20 ms";
}

struct TwoVideos {
  TemporaryFolder folder;
  std::vector<LiveCamera> cameras;
  TwoVideos(int frames, int frames_of_second, double rate_hz) {
    for (const auto& [name, count] : {std::pair{"left", frames}, std::pair{"right", frames_of_second}}) {
      const fs::path file = folder / (name + std::string(".mp4"));
      writeSweep(file, count, rate_hz);
      cameras.push_back(liveCamera({name, parseSource(file.string())}));
    }
  }
};

TEST(LiveCameras, FilesArriveInStepWithoutLoss) {
  TwoVideos videos(40, 35, 50);
  LiveCameras cameras(std::move(videos.cameras), {.sets = LiveOptions::Sets::kEvery});
  int count = 0;
  while (!cameras.ended()) {
    const auto set = cameras.next(0.5);
    if (!set) continue;
    ASSERT_TRUE(set->complete);
    EXPECT_EQ(frameOf(set->images[0]), count);
    EXPECT_EQ(frameOf(set->images[1]), count);
    EXPECT_LT(set->skew_s, 1e-9);
    ++count;
  }
  EXPECT_EQ(count, 35) << "the length of the shorter video";
  EXPECT_EQ(cameras.status()[1].drops, 0u);
  EXPECT_EQ(cameras.status()[0].state, CameraState::kEnded);
}

TEST(LiveCameras, SlowConsumerGetsTheNewestFrame) {
  TwoVideos videos(50, 50, 50);
  LiveCameras cameras(std::move(videos.cameras));
  int before = -1, count = 0;
  while (!cameras.ended()) {
    const auto set = cameras.next(0.2);
    if (!set) continue;
    EXPECT_EQ(frameOf(set->images[0]), frameOf(set->images[1]));
    EXPECT_GT(frameOf(set->images[0]), before);
    before = frameOf(set->images[0]);
    EXPECT_LT(secondsNow() - set->time_s, 0.2) << "old frames were queued";
    ++count;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_LT(count, 20);
  EXPECT_GE(count, 5);
}

TEST(LiveCameras, KilledStreamReconnects) {
  const TemporaryFolder folder;
  auto server = std::make_unique<MjpegServer>(ImageSize{64, 48}, 30);
  const int port = server->port();
  FakeState fake;
  std::vector<LiveCamera> all = {
      {"near", [&] { return std::make_unique<FakeSource>(fake); }},
      liveCamera({"far", parseSource("http://127.0.0.1:" + std::to_string(port) + "/")}),
  };
  LiveCameras cameras(std::move(all), {.max_skew_s = 0.03});
  const auto comesComplete = [&] {
    return waitUntil([&] {
      const auto set = cameras.next(0.1);
      return set && set->complete;
    });
  };
  ASSERT_TRUE(comesComplete());
  EXPECT_EQ(cameras.status()[1].times, TimeOrigin::kArrival);
  server.reset();
  ASSERT_TRUE(waitUntil([&] { return cameras.status()[1].state == CameraState::kReconnecting; }));
  EXPECT_NE(cameras.status()[1].fault.find("camera \"far\""), std::string::npos);
  EXPECT_EQ(cameras.status()[0].state, CameraState::kLive);
  server = std::make_unique<MjpegServer>(ImageSize{64, 48}, 30, port);
  ASSERT_TRUE(comesComplete());
  EXPECT_GE(cameras.status()[1].reconnects, 1);
}

TEST(LiveCameras, SourcesMustMatchTheRig) {
  const Rig rig = ringRig(2, 64, 48);
  const auto named = [](const std::string& name) { return NamedSource{name, parseSource(name + ".mp4")}; };
  EXPECT_EQ(inOrderOf(rig, {named("cam1"), named("cam0")})[0].name, "cam0");
  EXPECT_NE(messageOf([&] { inOrderOf(rig, {named("cam1")}); }).find("cam0"), std::string::npos);
  EXPECT_NE(messageOf([&] {
              inOrderOf(rig, {named("cam0"), named("cam1"), named("top")});
            }).find("top"),
            std::string::npos);
  TwoVideos videos(5, 5, 50);
  LiveCameras cameras(std::move(videos.cameras));
  EXPECT_NO_THROW(checkSizes(ringRig(2, 256, 32), cameras));
  EXPECT_NE(messageOf([&] { checkSizes(ringRig(2), cameras); }).find("256 x 32"), std::string::npos);
}

// ----------------------------------------------------------------------------------------- devices

TEST(V4l2Devices, ListsDevicesOrNothing) {
  for (const V4l2Device& device : listV4l2Devices()) {
    EXPECT_TRUE(device.path.starts_with("/dev/video")) << device.path;
    for (const V4l2Mode& mode : device.modes) EXPECT_EQ(mode.format.size(), 4u);
  }
}

}  // namespace
}  // namespace airclay
