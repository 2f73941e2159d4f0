// SPDX-License-Identifier: MIT
// A camera's thread passes its newest image to the pipeline of its clients, if there are any: appsrc,
// x264enc, rtph264pay. GStreamer's RTSP server creates the pipeline for the first client and destroys it
// after the last one.
#include "capture/cameras/stream_server.h"

#include <arpa/inet.h>
#include <gst/app/gstappsrc.h>
#include <gst/rtsp-server/rtsp-server.h>
#include <gst/video/video.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <string_view>
#include <thread>

#include "capture/cameras/gstreamer_objects.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

// How long a camera's thread waits for an image before it updates its state.
constexpr double kWaitS = 0.1;
// The interval of key frames; a new client waits half of it on average.
constexpr double kFullFrameEveryS = 0.5;
// Constant quality: 20 is hard to distinguish from the original. Noise may take up to half a bit per pixel (5
// Mbit/s for 640 x 480 at 30 Hz), averaged over a third of a second.
constexpr int kQuantizer = 20, kBufferMs = 333;
constexpr double kMaxBitsPerPixel = 0.5;
constexpr int kMinKbit = 1000;
// Images queued for the encoder; the oldest is dropped when another arrives.
constexpr int kQueuedImages = 2;
// The number of simultaneous clients, and the interval of checks for clients that are silent for a minute.
constexpr guint kMaxSessions = 64, kCleanupS = 5;

/// Connects a signal with shared data, which lives as long as the connection.
template <typename T>
void connect(gpointer object, const char* signal, GCallback callback, const std::shared_ptr<T>& data) {
  g_signal_connect_data(
      object, signal, callback, new std::shared_ptr<T>(data),
      [](gpointer owner, GClosure*) { delete static_cast<std::shared_ptr<T>*>(owner); }, GConnectFlags(0));
}

// ------------------------------------------------------------------------------------------------ a camera

/// Makes all files begin at the same time, although they are opened one after the other.
class SynchronizedSource : public CameraSource {
 public:
  SynchronizedSource(std::unique_ptr<CameraSource> source, Clock::time_point start)
      : source_(std::move(source)), start_(start) {}
  ImageSize size() const override { return source_->size(); }
  double rateHz() const override { return source_->rateHz(); }
  TimeOrigin times() const override { return source_->times(); }
  void begin(Clock::time_point) override { source_->begin(start_); }
  bool read(LiveImage& image, double& capture_s) override { return source_->read(image, capture_s); }
  void stop() override { source_->stop(); }

 private:
  std::unique_ptr<CameraSource> source_;
  Clock::time_point start_;
};

LiveCamera synchronizedCamera(const NamedSource& camera, const SourceOptions& options,
                              Clock::time_point start) {
  return {camera.name,
          [=] { return std::make_unique<SynchronizedSource>(openSource(camera, options), start); }};
}

/// Moves the image's bytes to a GStreamer buffer.
GstBuffer* bufferOf(LiveImage image) {
  const auto width = static_cast<guint>(image.size.width), height = static_cast<guint>(image.size.height);
  auto* const bytes = new std::vector<std::uint8_t>(std::move(image.bgr));
  GstBuffer* const buffer = gst_buffer_new_wrapped_full(
      GST_MEMORY_FLAG_READONLY, bytes->data(), bytes->size(), 0, bytes->size(), bytes,
      [](gpointer p) { delete static_cast<std::vector<std::uint8_t>*>(p); });
  // our rows have no padding; GStreamer would align them to four bytes
  gsize offsets[GST_VIDEO_MAX_PLANES] = {};
  gint strides[GST_VIDEO_MAX_PLANES] = {3 * image.size.width};
  gst_buffer_add_video_meta_full(buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_BGR, width, height, 1,
                                 offsets, strides);
  return buffer;
}

class StreamedCamera {
 public:
  StreamedCamera(const NamedSource& camera, const SourceOptions& options, Clock::time_point start)
      : cameras_(std::make_unique<LiveCameras>(std::vector{synchronizedCamera(camera, options, start)})),
        status_(cameras_->status()[0]) {}

  /// Runs on a separate thread.
  void run() {
    while (!stopping_) {
      std::optional<LiveSet> set = cameras_->next(kWaitS);
      const CameraStatus status = cameras_->status()[0];
      const std::lock_guard lock(mutex_);
      status_ = status;
      if (set) push(std::move(set->images[0]), set->time_s);
      if (!set && cameras_->ended()) break;
    }
    cameras_.reset();
    const std::lock_guard lock(mutex_);
    status_.state = CameraState::kEnded;
    ended_ = true;
    if (images_) gst_app_src_end_of_stream(images_.get());
  }
  void stop() { stopping_ = true; }

  void statusTo(StreamStatus& status) const {
    const std::lock_guard lock(mutex_);
    status.camera = status_;
    status.watched = images_ != nullptr;
    status.streamed = streamed_;
  }
  CameraStatus status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  bool ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
  }
  /// Whether a new client would get images.
  bool runs() const {
    const CameraState state = status().state;
    return !ended() && (state == CameraState::kLive || state == CameraState::kLate);
  }

  /// Sends the images to this appsrc from now on.
  void setOutput(GObjectPtr<GstAppSrc> images) {
    const std::lock_guard lock(mutex_);
    images_ = std::move(images);
    last_ = 0;
    // The camera may have ended after runs() was checked: without this, the client would wait for its
    // timeout.
    if (ended_) gst_app_src_end_of_stream(images_.get());
  }
  void leave(const GstAppSrc* images) {
    const std::lock_guard lock(mutex_);
    if (images_.get() == images) images_.reset();
  }

 private:
  /// Called with the mutex locked. The pipeline's clock is CLOCK_MONOTONIC, like that of capture times.
  void push(LiveImage image, double capture_s) {
    if (!images_) return;
    const GstClockTime base = gst_element_get_base_time(GST_ELEMENT(images_.get()));
    const auto captured = static_cast<GstClockTime>(std::llround(capture_s * 1e9));
    if (base == 0 || captured < base + last_) return;  // not running yet
    last_ = captured - base + 1;
    GstBuffer* const buffer = bufferOf(std::move(image));
    GST_BUFFER_PTS(buffer) = captured - base;
    if (gst_app_src_push_buffer(images_.get(), buffer) == GST_FLOW_OK) ++streamed_;
  }

  std::unique_ptr<LiveCameras> cameras_;  ///< only this camera
  std::atomic<bool> stopping_ = false;
  mutable std::mutex mutex_;
  CameraStatus status_;
  bool ended_ = false;
  GObjectPtr<GstAppSrc> images_;  ///< null: no clients
  GstClockTime last_ = 0;         ///< the earliest time of the next image
  std::uint64_t streamed_ = 0;
};

// ------------------------------------------------------------------------------------------- its pipeline

/// The encoding pipeline. Colours are BT.601 for all sizes, as OpenCV assumes.
std::string pipelineOf(const CameraStatus& camera) {
  const auto number = [](double value) { return std::to_string(std::lround(value)); };
  const ImageSize size = camera.size;
  const double pixels_hz = double(size.width) * size.height * camera.rate_hz;
  const bool even = size.width % 2 == 0 && size.height % 2 == 0;  // I420 subsamples colours by two
  return "( appsrc name=images is-live=true format=time block=false leaky-type=downstream max-bytes=0 "
         "max-buffers=" +
         std::to_string(kQueuedImages) +
         " caps=\"video/x-raw,format=BGR,width=" + std::to_string(size.width) +
         ",height=" + std::to_string(size.height) + ",framerate=" + number(1000 * camera.rate_hz) +
         "/1000\" ! videoconvert ! video/x-raw,colorimetry=bt601,format=" + (even ? "I420" : "Y444") +
         " ! x264enc tune=zerolatency speed-preset=veryfast bframes=0 threads=1 pass=qual quantizer=" +
         std::to_string(kQuantizer) + " vbv-buf-capacity=" + std::to_string(kBufferMs) +
         " bitrate=" + number(std::clamp(kMaxBitsPerPixel * pixels_hz / 1000, double(kMinKbit), 1e6)) +
         " key-int-max=" + number(std::max(1.0, kFullFrameEveryS * camera.rate_hz)) +
         " ! rtph264pay name=pay0 pt=96 config-interval=-1 aggregate-mode=zero-latency )";
}

GObjectPtr<GstAppSrc> imagesOf(GstRTSPMedia* media) {
  const GObjectPtr<GstElement> bin(gst_rtsp_media_get_element(media));
  return GObjectPtr<GstAppSrc>(GST_APP_SRC(elementOf(bin.get(), "images").release()));
}

void addStream(GstRTSPMountPoints* mounts, const std::shared_ptr<StreamedCamera>& camera) {
  const CameraStatus status = camera->status();
  GstRTSPMediaFactory* const factory = gst_rtsp_media_factory_new();
  gst_rtsp_media_factory_set_launch(factory, pipelineOf(status).c_str());
  gst_rtsp_media_factory_set_shared(factory, TRUE);
  gst_rtsp_media_factory_set_protocols(factory, GST_RTSP_LOWER_TRANS_TCP);
  const GObjectPtr<GstClock> clock(gst_system_clock_obtain());
  gst_rtsp_media_factory_set_clock(factory, clock.get());
  connect(
      factory, "media-configure",
      G_CALLBACK(+[](GstRTSPMediaFactory*, GstRTSPMedia* media, std::shared_ptr<StreamedCamera>* watched) {
        connect(media, "unprepared",
                G_CALLBACK(+[](GstRTSPMedia* gone, std::shared_ptr<StreamedCamera>* left) {
                  (*left)->leave(imagesOf(gone).get());
                }),
                *watched);
        (*watched)->setOutput(imagesOf(media));
      }),
      camera);
  gst_rtsp_mount_points_add_factory(mounts, ("/" + status.name).c_str(), factory);
}

/// Whether a request is for this stream; like GStreamer's mount points, ignores a trailing slash.
bool requests(const GstRTSPContext& request, const std::string& name) {
  std::string_view path = request.uri->abspath;
  while (path.ends_with('/')) path.remove_suffix(1);
  return path == "/" + name;
}

std::string inUrl(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

/// \throw Error (Fault::kUsage) unless the address is numeric: looking up a name can take long.
void checkAddress(const StreamServerOptions& options) {
  in6_addr place;
  if (inet_pton(AF_INET, options.address.c_str(), &place) != 1 &&
      inet_pton(AF_INET6, options.address.c_str(), &place) != 1)
    throw Error(
        "address " + options.address +
            ": expected 127.0.0.1 (only this machine), 0.0.0.0 (all machines that reach it) or another "
            "address of this machine",
        Fault::kUsage);
  if (options.port < 0 || options.port > 65535)
    throw Error("port " + std::to_string(options.port) + ": expected 1 to 65535, or 0 for any free port",
                Fault::kUsage);
}

}  // namespace

// ------------------------------------------------------------------------------------------- StreamServer

struct StreamServer::Parts {
  using Cameras = std::vector<std::shared_ptr<StreamedCamera>>;

  StreamServerOptions options;
  std::shared_ptr<Cameras> cameras = std::make_shared<Cameras>();
  GMainContext* context = g_main_context_new();
  GMainLoop* loop = g_main_loop_new(context, FALSE);
  GObjectPtr<GstRTSPServer> server;
  GObjectPtr<GSource> connections;
  int port = 0;
  std::thread accepting;               ///< runs `loop`: accepts connections
  std::vector<std::thread> streaming;  ///< one per camera

  explicit Parts(const StreamServerOptions& given) : options(given) {}
  ~Parts();
  void bindPort();
  void begin();
};

/// Clients that connect wait until begin().
void StreamServer::Parts::bindPort() {
  server.reset(gst_rtsp_server_new());
  gst_rtsp_server_set_address(server.get(), options.address.c_str());
  gst_rtsp_server_set_service(server.get(), std::to_string(options.port).c_str());
  GError* fault = nullptr;
  connections.reset(gst_rtsp_server_create_source(server.get(), nullptr, &fault));
  if (!connections) {
    const bool taken = g_error_matches(fault, G_IO_ERROR, G_IO_ERROR_ADDRESS_IN_USE);
    const std::string what = fault->message;
    g_error_free(fault);
    throw Error("cannot listen at " + inUrl(options.address) + ":" + std::to_string(options.port) + ": " +
                    (taken ? "another program uses the port; use another --port"
                           : what + "; expected an address of this machine and a port of at least 1024"),
                Fault::kUsage);
  }
  port = gst_rtsp_server_get_bound_port(server.get());
}

void StreamServer::Parts::begin() {
  // One thread per client, so that a request for a camera without images does not block others.
  const GObjectPtr<GstRTSPThreadPool> pool(gst_rtsp_server_get_thread_pool(server.get()));
  gst_rtsp_thread_pool_set_max_threads(pool.get(), -1);
  const GObjectPtr<GstRTSPSessionPool> sessions(gst_rtsp_server_get_session_pool(server.get()));
  gst_rtsp_session_pool_set_max_sessions(sessions.get(), kMaxSessions);
  const GObjectPtr<GstRTSPMountPoints> mounts(gst_rtsp_server_get_mount_points(server.get()));
  for (const std::shared_ptr<StreamedCamera>& camera : *cameras) addStream(mounts.get(), camera);
  connect(server.get(), "client-connected",
          G_CALLBACK(+[](GstRTSPServer*, GstRTSPClient* client, std::shared_ptr<Cameras>* all) {
            connect(client, "pre-describe-request",
                    G_CALLBACK(+[](GstRTSPClient*, GstRTSPContext* asked, std::shared_ptr<Cameras>* those) {
                      for (const std::shared_ptr<StreamedCamera>& camera : **those)
                        if (requests(*asked, camera->status().name) && !camera->runs())
                          return GST_RTSP_STS_SERVICE_UNAVAILABLE;
                      return GST_RTSP_STS_OK;
                    }),
                    *all);
          }),
          cameras);
  const GObjectPtr<GSource> cleanup(g_timeout_source_new_seconds(kCleanupS));
  g_source_set_callback(
      cleanup.get(),
      [](gpointer all) -> gboolean {
        gst_rtsp_session_pool_cleanup(static_cast<GstRTSPSessionPool*>(all));
        return TRUE;
      },
      g_object_ref(sessions.get()), g_object_unref);
  g_source_attach(cleanup.get(), context);
  g_source_attach(connections.get(), context);
  accepting = std::thread([this] {
    g_main_context_push_thread_default(context);
    g_main_loop_run(loop);
    g_main_context_pop_thread_default(context);
  });
  for (const std::shared_ptr<StreamedCamera>& camera : *cameras)
    streaming.emplace_back([camera] { camera->run(); });
}

StreamServer::Parts::~Parts() {
  for (const std::shared_ptr<StreamedCamera>& camera : *cameras) camera->stop();
  // Quit from within the loop: a loop that has not started yet would miss the call.
  const GObjectPtr<GSource> end(g_idle_source_new());
  g_source_set_callback(
      end.get(),
      [](gpointer running) -> gboolean {
        g_main_loop_quit(static_cast<GMainLoop*>(running));
        return FALSE;
      },
      loop, nullptr);
  g_source_attach(end.get(), context);
  if (accepting.joinable()) accepting.join();
  // After the loop has ended, or a client that connects meanwhile would stay.
  if (server)
    gst_rtsp_server_client_filter(
        server.get(), [](GstRTSPServer*, GstRTSPClient*, gpointer) { return GST_RTSP_FILTER_REMOVE; },
        nullptr);
  for (std::thread& thread : streaming) thread.join();
  server.reset();
  g_main_loop_unref(loop);
  g_main_context_unref(context);
}

StreamServer::StreamServer(const std::vector<NamedSource>& cameras, const StreamServerOptions& options) {
  checkAddress(options);
  startGStreamer({{"appsrc", "gstreamer1.0-plugins-base"},
                  {"videoconvert", "gstreamer1.0-plugins-base"},
                  {"rtpbin", "gstreamer1.0-plugins-good"},
                  {"rtph264pay", "gstreamer1.0-plugins-good"},
                  {"x264enc", "gstreamer1.0-plugins-ugly"}});
  parts_ = std::make_unique<Parts>(options);
  parts_->bindPort();
  const Clock::time_point start = Clock::now();
  for (const NamedSource& camera : cameras)
    parts_->cameras->push_back(std::make_shared<StreamedCamera>(camera, options.sources, start));
  parts_->begin();
}

StreamServer::~StreamServer() = default;

int StreamServer::port() const {
  return parts_->port;
}

std::vector<StreamStatus> StreamServer::status() const {
  std::vector<StreamStatus> all;
  for (const std::shared_ptr<StreamedCamera>& camera : *parts_->cameras) {
    camera->statusTo(all.emplace_back());
    all.back().address = "rtsp://" + inUrl(parts_->options.address) + ":" + std::to_string(port()) + "/" +
                         all.back().camera.name;
  }
  return all;
}

bool StreamServer::ended() const {
  return std::all_of(parts_->cameras->begin(), parts_->cameras->end(),
                     [](const std::shared_ptr<StreamedCamera>& camera) { return camera->ended(); });
}

}  // namespace airclay
