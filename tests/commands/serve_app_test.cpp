// SPDX-License-Identifier: MIT
// `airclay serve` as a user runs it, and its streams as cameras over the loopback interface.
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/cameras/live_cameras.h"
#include "capture/images/video_writer.h"
#include "engine/core/error.h"
#include "tests/support/mjpeg_server.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace airclay {
namespace {

using nlohmann::json;
using Strings = std::vector<std::string>;

constexpr ImageSize kSize = {320, 240};
constexpr int kFrames = 60;
// A smooth image encoded twice. Another frame, or another camera's, has less
// than 20.
constexpr double kLeastPsnrDb = 30;

/// Frame k of a camera: changing colours below a bar that is white from column 4 k on.
std::vector<std::uint8_t> frame(int camera, int k) {
  std::vector<std::uint8_t> bgr(3 * std::size_t(kSize.width) * std::size_t(kSize.height));
  for (std::size_t i = 0; i < bgr.size(); ++i) {
    const int x = int(i) / 3 % kSize.width, y = int(i) / 3 / kSize.width, channel = int(i) % 3;
    const double wave = std::sin(0.03 * (x + (camera + 1) * y) + 0.1 * k + 2 * channel);
    bgr[i] = y < 16 ? (x >= 4 * k ? 255 : 0) : static_cast<std::uint8_t>(128 + 90 * wave);
  }
  return bgr;
}

/// The index of a frame, read from its bar.
int frameOf(const LiveImage& image) {
  int black = 0;
  for (int x = 0; x < kSize.width; ++x) black += image.bgr[std::size_t(3 * (8 * kSize.width + x))] < 128;
  return static_cast<int>(std::lround(black / 4.0));
}

/// PSNR of an image against the frame that its bar names.
double psnrDb(const LiveImage& image, int camera) {
  const std::vector<std::uint8_t> truth = frame(camera, frameOf(image));
  if (image.size != kSize) return 0;
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) squares += std::pow(int(image.bgr[i]) - int(truth[i]), 2);
  return 10 * std::log10(255 * 255 * double(truth.size()) / std::max(squares, 1.0));
}

/// A server process.
class Server {
 public:
  explicit Server(const Strings& cameras, int port = 0, const Strings& more = {}) {
    Strings arguments = {AIRCLAY_PROGRAM, "serve", "--port", std::to_string(port)};
    for (const std::string& camera : cameras) arguments.insert(arguments.end(), {"--camera", camera});
    arguments.insert(arguments.end(), more.begin(), more.end());
    program_ = std::make_unique<Process>(arguments, std::map<std::string, std::string>{}, folder_ / "output",
                                         folder_ / "errors");
    waitUntil([&] { return output().find("Ctrl-C") != std::string::npos || !program_->running(); });
    const std::size_t at = output().find("rtsp://127.0.0.1:");
    if (at != std::string::npos) port_ = std::stoi(output().substr(at + 17));
    EXPECT_GT(port_, 0) << errors();
  }
  Process& program() { return *program_; }
  std::string output() const { return contentOf(folder_ / "output"); }
  std::string errors() const { return contentOf(folder_ / "errors"); }
  int port() const { return port_; }
  std::string address(const std::string& name) const {
    return "rtsp://127.0.0.1:" + std::to_string(port_) + "/" + name;
  }
  NamedSource source(const std::string& name) const { return {name, parseSource(address(name))}; }

 private:
  TemporaryFolder folder_;
  int port_ = 0;
  std::unique_ptr<Process> program_;
};

class ServeApp : public testing::Test {
 protected:
  ServeApp() {
    for (int camera = 0; camera < 2; ++camera) {
      VideoWriter writer(folder / (camera == 0 ? "left.mp4" : "right.mp4"),
                         {kSize, 30, VideoWriter::Format::kBgr8});
      for (int k = 0; k < kFrames; ++k) writer.write(frame(camera, k));
      writer.finish();
    }
  }
  std::string camera(const std::string& name) const {
    return name + "=" + (folder / (name + ".mp4")).string();
  }
  Strings both() const { return {camera("left"), camera("right")}; }

  TemporaryFolder folder;
};

std::optional<LiveSet> completeSet(LiveCameras& cameras) {
  std::optional<LiveSet> set;
  waitUntil([&] { return (set = cameras.next(0.1)) && set->complete; });
  return set && set->complete ? set : std::nullopt;
}

TEST_F(ServeApp, ImagesArriveUnchanged) {
  const Server server(both(), 0, {"--loop"});
  LiveCameras cameras({liveCamera(server.source("left")), liveCamera(server.source("right"))});
  for (const CameraStatus& one : cameras.status()) {
    EXPECT_EQ(one.size, kSize);
    EXPECT_NEAR(one.rate_hz, 30, 0.01);
  }
  int before = -1;
  for (int k = 0; k < 10; ++k) {
    const auto set = completeSet(cameras);
    ASSERT_TRUE(set);
    for (int c = 0; c < 2; ++c) EXPECT_GT(psnrDb(set->images[std::size_t(c)], c), kLeastPsnrDb);
    EXPECT_LT(psnrDb(set->images[0], 1), 20) << "the cameras are confused";
    EXPECT_NE(frameOf(set->images[0]), before);
    before = frameOf(set->images[0]);
  }
}

TEST_F(ServeApp, StreamsWorkAsCameras) {
  const Server server(both(), 0, {"--loop"});
  const RunResult result = runAirclay({"cameras", "--camera", "a=" + server.address("left"), "--camera",
                                       "b=" + server.address("right"), "--watch", "3", "--json"});
  ASSERT_EQ(result.status, 0) << result.errors;
  const json watched = json::parse(result.output);
  for (const json& one : watched["cameras"]) {
    EXPECT_EQ(one["width"], kSize.width);
    EXPECT_EQ(one["height"], kSize.height);
    EXPECT_EQ(one["reconnects"], 0);
    EXPECT_GT(one["frames"], 20);
  }
  EXPECT_GT(watched["sets"], 10);
}

TEST_F(ServeApp, SeveralClientsShareACamera) {
  const Server server({camera("left")}, 0, {"--loop"});
  std::vector<std::unique_ptr<CameraSource>> watchers;
  for (int n = 0; n < 3; ++n) {
    watchers.push_back(openSource(server.source("left")));
    LiveImage image;
    double capture_s = 0;
    for (const auto& watcher : watchers) {
      ASSERT_TRUE(watcher->read(image, capture_s));
      EXPECT_GT(psnrDb(image, 0), kLeastPsnrDb);
    }
  }
}

TEST_F(ServeApp, TimestampsExcludeNetworkDelay) {
  const Server server({camera("left")}, 0, {"--loop"});
  const auto source = openSource(server.source("left"));
  LiveImage image;
  double first_s = 0;
  int frames = 0, before = 0;
  std::vector<double> off_s;
  for (int k = 0; k < 60; ++k) {
    double capture_s = 0;
    ASSERT_TRUE(source->read(image, capture_s));
    const int now = frameOf(image);
    if (k == 0) first_s = capture_s;
    if (k > 0) frames += (now - before + kFrames) % kFrames;
    before = now;
    off_s.push_back(capture_s - first_s - frames / 30.0);
  }
  // The delay estimate uses the fastest arrivals, so it decreases; later the times are as regular as the
  // file's.
  const auto [least, most] = std::minmax_element(off_s.end() - 20, off_s.end());
  EXPECT_LT(*most - *least, 0.01) << "timestamps must not follow the arrival jitter";
}

/// Four saturated colours, a quarter each.
constexpr std::uint8_t kQuarters[4][3] = {{200, 40, 40}, {40, 200, 40}, {40, 40, 200}, {40, 200, 200}};

TEST_F(ServeApp, ColoursAreCorrectAtAnySize) {
  for (const ImageSize size : {ImageSize{161, 121}, ImageSize{1280, 720}}) {
    const std::string name = "w" + std::to_string(size.width);
    std::filesystem::create_directory(folder / name);
    for (int k = 0; k < 2; ++k) {
      std::vector<std::uint8_t> rgba;
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          const auto& bgr = kQuarters[(2 * y >= size.height) * 2 + (2 * x >= size.width)];
          rgba.insert(rgba.end(), {bgr[2], bgr[1], bgr[0], 255});
        }
      rgba[0] = std::uint8_t(100 * k);
      writePng(folder / (name + "/00000" + std::to_string(k) + ".png"), size, rgba);
    }
    const Server server({name + "=" + (folder / name).string()}, 0, {"--loop", "--mode", "64x48@10"});
    const auto source = openSource(server.source(name));
    ASSERT_EQ(source->size(), size);
    EXPECT_NEAR(source->rateHz(), 10, 0.01);
    LiveImage image;
    double capture_s = 0;
    ASSERT_TRUE(source->read(image, capture_s));
    for (int q = 0; q < 4; ++q) {
      const int x = size.width * (1 + 2 * (q & 1)) / 4, y = size.height * (1 + 2 * (q >> 1)) / 4;
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(image.bgr[std::size_t(3 * (y * size.width + x) + channel)], kQuarters[q][channel], 5)
            << size.width << ", quarter " << q << ", channel " << channel;
    }
  }
}

TEST_F(ServeApp, KilledServerIsReportedAndRejoins) {
  const Server stays({camera("right")}, 0, {"--loop"});
  auto dies = std::make_unique<Server>(Strings{camera("left")}, 0, Strings{"--loop"});
  const int port = dies->port();
  LiveCameras cameras({liveCamera(dies->source("left")), liveCamera(stays.source("right"))});
  ASSERT_TRUE(completeSet(cameras));
  dies->program().send(SIGKILL);
  ASSERT_EQ(dies->program().waitForExit(), 128 + SIGKILL);
  ASSERT_TRUE(waitUntil([&] { return cameras.status()[0].state == CameraState::kReconnecting; }));
  EXPECT_NE(cameras.status()[0].fault.find("camera \"left\" (rtsp://"), std::string::npos);
  EXPECT_EQ(cameras.status()[0].fault.find('\n'), std::string::npos);
  const std::uint64_t frames = cameras.status()[1].frames;
  EXPECT_TRUE(waitUntil([&] { return cameras.status()[1].frames > frames + 10; }))
      << "the other camera continues";
  EXPECT_EQ(cameras.status()[1].reconnects, 0);
  dies = std::make_unique<Server>(Strings{camera("left")}, port, Strings{"--loop"});
  const auto set = completeSet(cameras);
  ASSERT_TRUE(set) << "it rejoins";
  EXPECT_GT(psnrDb(set->images[0], 0), kLeastPsnrDb);
  EXPECT_GE(cameras.status()[0].reconnects, 1);
}

TEST_F(ServeApp, SilentServerCountsAsLost) {
  Server server({camera("left")}, 0, {"--loop"});
  const auto source = openSource(server.source("left"));
  LiveImage image;
  double capture_s = 0;
  ASSERT_TRUE(source->read(image, capture_s));
  server.program().send(SIGSTOP);
  const std::string message = messageOf([&] {
    while (source->read(image, capture_s)) {
    }
  });
  EXPECT_NE(message.find("camera \"left\" (rtsp://"), std::string::npos) << message;
  EXPECT_NE(messageOf([&] { openSource(server.source("left")); }).find("no stream answers"),
            std::string::npos);
  server.program().send(SIGCONT);
}

TEST_F(ServeApp, LostCameraIsReportedWhileOthersContinue) {
  auto far = std::make_unique<MjpegServer>(ImageSize{64, 48}, 30);
  const int port = far->port();
  const Server server({camera("left"), "far=http://127.0.0.1:" + std::to_string(port) + "/"}, 0, {"--loop"});
  const auto left = openSource(server.source("left"));
  EXPECT_EQ(openSource(server.source("far"))->size(), (ImageSize{64, 48}));
  far.reset();
  ASSERT_TRUE(waitUntil([&] { return server.errors().find("reopening it") != std::string::npos; }));
  EXPECT_NE(server.errors().find("camera \"far\" (http://"), std::string::npos) << server.errors();
  for (const char* path : {"far", "far/"}) {
    const std::string message = messageOf([&] { openSource({"far", parseSource(server.address(path))}); });
    EXPECT_NE(message.find("Service Unavailable"), std::string::npos) << message;
  }
  LiveImage image;
  double capture_s = 0;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(left->read(image, capture_s));
  EXPECT_GT(psnrDb(image, 0), kLeastPsnrDb);
  far = std::make_unique<MjpegServer>(ImageSize{64, 48}, 30, port);
  ASSERT_TRUE(waitUntil([&] { return server.errors().find("\"far\" is back") != std::string::npos; }));
  EXPECT_EQ(openSource(server.source("far"))->size(), (ImageSize{64, 48}));
}

TEST_F(ServeApp, CtrlCEndsServerWithClients) {
  Server server(both(), 0, {"--loop"});
  const auto source = openSource(server.source("left"));
  LiveImage image;
  double capture_s = 0;
  ASSERT_TRUE(source->read(image, capture_s));
  server.program().send(SIGINT);
  EXPECT_EQ(server.program().waitForExit(), 0);
  EXPECT_EQ(server.errors(), "");
  EXPECT_NE(server.output().find("images streamed: left "), std::string::npos) << server.output();
  EXPECT_EQ(server.output().find("streamed: left 0"), std::string::npos) << server.output();
  EXPECT_NE(server.output().find("right 0"), std::string::npos) << "without clients nothing is encoded";
}

TEST_F(ServeApp, EndsAfterSecondsOrWithItsFiles) {
  const auto figures = [&](const Strings& more) {
    Strings arguments = {"serve", "--port", "0", "--json", "--camera", camera("left")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const RunResult result = runAirclay(arguments);
    EXPECT_EQ(result.status, 0) << result.errors;
    return json::parse(result.output)["cameras"][0];
  };
  const json some = figures({"--loop", "--seconds", "0.5"});
  EXPECT_EQ(some["name"], "left");
  EXPECT_EQ(some["streamed"], 0);
  EXPECT_EQ(some["width"], kSize.width);
  EXPECT_EQ(figures({})["frames"], kFrames);
}

void expectRefused(const Strings& arguments, int status, const std::string& expected) {
  const RunResult result = runAirclay(arguments);
  EXPECT_EQ(result.status, status) << result.output;
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find(expected), std::string::npos) << result.errors;
}

TEST_F(ServeApp, InvalidUseIsAOneLineError) {
  const Server server({camera("left")}, 0, {"--loop"});
  const std::string port = std::to_string(server.port()), left = camera("left");
  expectRefused({"cameras", "--camera", "a=" + server.address("nobody")}, 1, "Not Found (404)");
  expectRefused({"cameras", "--camera", "a=rtsp://127.0.0.1:9/left"}, 1, "no stream answers there");
  expectRefused({"serve", "--camera", left, "--port", port}, 2, "127.0.0.1:" + port);
  expectRefused({"serve", "--camera", left, "--camera", left}, 2, "is already used");
  expectRefused({"serve", "--camera", left, "--address", "192.0.2.1"}, 2, "192.0.2.1");
  expectRefused({"serve", "--camera", left, "--address", "camera.example"}, 2, "camera.example");
  expectRefused({"serve", "--camera", left, "--port", "70000"}, 2, "70000");
  expectRefused({"serve", "--camera", left, "--seconds", "-1"}, 2, "--seconds");
  expectRefused({"serve", "--camera", "left=none.mp4", "--port", "0"}, 1, "camera \"left\" (none.mp4)");
  expectRefused({"serve"}, 2, "--camera");
}

TEST_F(ServeApp, ReportsWhoCanConnect) {
  const RunResult result = runAirclay({"serve", "--camera", camera("left"), "--loop", "--address", "0.0.0.0",
                                       "--port", "0", "--seconds", "0.1"});
  EXPECT_EQ(result.status, 0);
  ASSERT_EQ(result.errorLines().size(), 1u) << result.errors;
  EXPECT_NE(result.errors.find("anyone who reaches port "), std::string::npos) << result.errors;
}

// ---------------------------------------------------------------------------------------------- pipelines

TEST(Pipeline, ReportsImagesAndErrors) {
  const auto open = [](const std::string& arguments) { return openSource({"left", parseSource(arguments)}); };
  const std::string red =
      "videotestsrc is-live=true pattern=red ! video/x-raw,width=65,height=49,framerate=20/1";
  for (const std::string& arguments : {red, red + " ! videoconvert ! video/x-raw,format=BGR ! appsink"}) {
    const auto source = open("gst: " + arguments);
    EXPECT_EQ(source->size(), (ImageSize{65, 49}));
    EXPECT_NEAR(source->rateHz(), 20, 1e-9);
    LiveImage image;
    double before_s = 0, capture_s = 0;
    for (int k = 0; k < 5; ++k, before_s = capture_s) {
      ASSERT_TRUE(source->read(image, capture_s));
      EXPECT_GT(capture_s, before_s);
    }
    const std::size_t last = image.bgr.size() - 3;
    ASSERT_EQ(image.bgr.size(), 65u * 49 * 3);
    EXPECT_NEAR(image.bgr[last], 0, 3);
    EXPECT_NEAR(image.bgr[last + 2], 255, 3);
  }
  const auto refused = [&](const std::string& arguments, const std::string& expected) {
    const std::string message = messageOf([&] { open(arguments); });
    EXPECT_EQ(message.find("camera \"left\" ("), 0u) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  refused("gst: noSuchElement", "noSuchElement");
  refused("gst: videotestsrc ! nothing", "cannot be run");
  refused("gst: videotestsrc ! fakesink name=appsink", "has no appsink");
  refused("gst: videotestsrc ! appsink", "not BGR");
  refused("gst: appsrc", "delivers no image");  // OpenCV would wait forever
}

}  // namespace
}  // namespace airclay
