// SPDX-License-Identifier: MIT
#include "capture/cameras/gstreamer_source.h"

#include <gst/app/gstappsink.h>
#include <gst/video/video.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <optional>

#include "capture/cameras/gstreamer_objects.h"
#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

// A stream that is silent for this long is lost, and is then reopened.
constexpr double kOpenS = 4, kReadS = 2;
// The interval between checks for errors and for stop().
constexpr double kPollS = 0.05;
// The rate of a stream that does not declare one is measured over this many images.
constexpr std::size_t kImagesForRate = 10;
constexpr double kDefaultRateHz = 30;

// Times are taken from the stream unchanged. Hardware decoders need drivers and delay images.
constexpr const char* kRtsp =
    "rtspsrc name=stream protocols=tcp latency=0 buffer-mode=none ! decodebin force-sw-decoders=true";
// Appended to a pipeline: delivers its newest image as BGR.
constexpr const char* kEnd =
    " ! videoconvert ! video/x-raw,format=BGR ! appsink max-buffers=1 drop=true sync=false";

/// \throw Error starting with `before`
GObjectPtr<GstElement> pipelineFrom(const std::string& description, const std::string& before) {
  GError* error = nullptr;
  GstElement* const pipeline =
      gst_parse_launch_full(description.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error);
  const std::string reason = error ? error->message : "";
  g_clear_error(&error);
  if (!pipeline)
    throw Error(before + "the GStreamer pipeline cannot be run (" + reason +
                "); expected a pipeline that gst-launch-1.0 runs, with its plugins installed");
  return GObjectPtr<GstElement>(GST_ELEMENT(gst_object_ref_sink(pipeline)));
}

/// The first appsink, through which a program receives images; null if there is none.
GObjectPtr<GstElement> appsinkOf(GstElement* pipeline) {
  if (GST_IS_APP_SINK(pipeline)) return GObjectPtr<GstElement>(GST_ELEMENT(g_object_ref(pipeline)));
  if (!GST_IS_BIN(pipeline)) return nullptr;
  GstIterator* const all = gst_bin_iterate_all_by_element_factory_name(GST_BIN(pipeline), "appsink");
  GValue value = G_VALUE_INIT;
  GObjectPtr<GstElement> found;
  if (gst_iterator_next(all, &value) == GST_ITERATOR_OK) found.reset(GST_ELEMENT(g_value_dup_object(&value)));
  g_value_unset(&value);
  gst_iterator_free(all);
  return found;
}

class GStreamerSource : public CameraSource {
 public:
  explicit GStreamerSource(const NamedSource& camera)
      : where_("camera \"" + camera.name + "\" (" + camera.source.text + "): ") {
    const bool rtsp = camera.source.kind == SourceKind::kStream;
    startGStreamer(
        {{"decodebin", "gstreamer1.0-plugins-base"}, {"videoconvert", "gstreamer1.0-plugins-base"}});
    if (rtsp)
      startGStreamer({{"rtspsrc", "gstreamer1.0-plugins-good"}, {"avdec_h264", "gstreamer1.0-libav"}});
    const std::string description = rtsp ? kRtsp : camera.source.text;
    pipeline_ = pipelineFrom(
        description.find("appsink") == std::string::npos ? description + kEnd : description, where_);
    images_ = appsinkOf(pipeline_.get());
    if (!images_)
      throw Error(where_ +
                  "the GStreamer pipeline has no appsink; add one, or leave it out to have it appended");
    if (rtsp) prepareStream(camera.source.text);
    try {
      open(rtsp);
    } catch (...) {
      gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
      throw;
    }
  }
  ~GStreamerSource() override { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }

  ImageSize size() const override { return size_; }
  double rateHz() const override { return rate_hz_; }
  TimeOrigin times() const override { return TimeOrigin::kArrival; }

  bool read(LiveImage& image, double& capture_s) override {
    const GObjectPtr<GstSample> sample = next(kReadS);
    if (stopped_) return false;
    if (!sample)
      throw Error(where_ + "no more images arrive (unplugged, ended, or the network failed" + fault_ + ")");
    const double arrival_s = secondsNow();
    const GstClockTime time = GST_BUFFER_PTS(gst_sample_get_buffer(sample.get()));
    // a pipeline may deliver no times, or invalid ones
    const bool grows = GST_CLOCK_TIME_IS_VALID(time) && time > last_;
    capture_s = grows ? clock_.captureOf(arrival_s, double(time) * 1e-9) : arrival_s;
    if (GST_CLOCK_TIME_IS_VALID(time)) last_ = time;
    copy(sample.get(), image);
    return true;
  }
  void stop() override { stopped_ = true; }

 private:
  void prepareStream(const std::string& address) {
    const GObjectPtr<GstElement> stream = elementOf(pipeline_.get(), "stream");
    g_object_set(stream.get(), "location", address.c_str(), nullptr);
    // otherwise a camera's microphone stream could occupy the decoder
    g_signal_connect(stream.get(), "select-stream",
                     G_CALLBACK(+[](GstElement*, guint, GstCaps* caps, gpointer) -> gboolean {
                       const char* media = gst_structure_get_string(gst_caps_get_structure(caps, 0), "media");
                       return media && std::strcmp(media, "video") == 0;
                     }),
                     nullptr);
    // a client that connects between two key frames waits for the next one: images decoded without it are
    // grey
    g_signal_connect(pipeline_.get(), "deep-element-added",
                     G_CALLBACK(+[](GstBin*, GstBin*, GstElement* element, gpointer) {
                       if (g_object_class_find_property(G_OBJECT_GET_CLASS(element), "output-corrupt"))
                         g_object_set(element, "output-corrupt", FALSE, nullptr);
                     }),
                     nullptr);
  }

  void open(bool rtsp) {
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
    const GObjectPtr<GstSample> first = next(kOpenS);
    const std::string why = fault_.empty() ? "" : " (" + fault_.substr(2) + ")";
    if (!first && rtsp)
      throw Error(where_ + "no stream answers there" + why +
                  "; expected the address of a running camera or server");
    if (!first)
      throw Error(where_ + "the GStreamer pipeline delivers no image" + why +
                  "; expected a pipeline that gst-launch-1.0 runs, with its plugins installed");
    const GstVideoInfo info = infoOf(first.get());
    size_ = {info.width, info.height};
    const double declared_hz = info.fps_d > 0 ? double(info.fps_n) / info.fps_d : 0;
    rate_hz_ = declared_hz > 0 && declared_hz <= 1000 ? declared_hz : measuredRate();
  }

  double measuredRate() {
    std::vector<double> periods_s;
    for (std::optional<double> before_s; periods_s.size() < kImagesForRate;) {
      const GObjectPtr<GstSample> sample = next(kReadS);
      if (!sample) break;
      const double time_s = double(GST_BUFFER_PTS(gst_sample_get_buffer(sample.get()))) * 1e-9;
      if (before_s && time_s > *before_s) periods_s.push_back(time_s - *before_s);
      before_s = time_s;
    }
    if (periods_s.size() < kImagesForRate) return kDefaultRateHz;
    return std::clamp(1 / median(std::move(periods_s)), 1.0, 1000.0);
  }

  /// The next image; null on a timeout, at the end, or after stop(). `fault_` has the reason, if known.
  GObjectPtr<GstSample> next(double wait_s) {
    const double until_s = secondsNow() + wait_s;
    const GObjectPtr<GstBus> bus(gst_element_get_bus(pipeline_.get()));
    while (!stopped_ && secondsNow() < until_s) {
      if (GObjectPtr<GstSample> sample{
              gst_app_sink_try_pull_sample(GST_APP_SINK(images_.get()), GstClockTime(kPollS * GST_SECOND))})
        return sample;
      const GObjectPtr<GstMessage> message(
          gst_bus_pop_filtered(bus.get(), GstMessageType(GST_MESSAGE_ERROR | GST_MESSAGE_EOS)));
      if (!message) continue;
      if (GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR) {
        GError* error = nullptr;
        gchar* details = nullptr;
        gst_message_parse_error(message.get(), &error, &details);
        // "Not Found (404)": the last line of the details; the others are locations in GStreamer's code
        fault_ = ": " + (details ? std::string(details) : std::string(error->message));
        if (const std::size_t line = fault_.rfind('\n'); line != std::string::npos)
          fault_ = ": " + fault_.substr(line + 1);
        g_error_free(error);
        g_free(details);
      }
      break;
    }
    return nullptr;
  }

  GstVideoInfo infoOf(GstSample* sample) const {
    GstVideoInfo info;
    if (!gst_video_info_from_caps(&info, gst_sample_get_caps(sample)) ||
        GST_VIDEO_INFO_FORMAT(&info) != GST_VIDEO_FORMAT_BGR)
      throw Error(where_ +
                  "the images are not BGR; insert videoconvert ! video/x-raw,format=BGR before the appsink");
    return info;
  }

  void copy(GstSample* sample, LiveImage& image) const {
    GstVideoInfo info = infoOf(sample);
    image.size = {info.width, info.height};
    if (image.size != size_)
      throw Error(where_ + "the image's size changed to " + std::to_string(info.width) + " x " +
                  std::to_string(info.height) + "; expected the same size throughout");
    GstVideoFrame frame;
    if (!gst_video_frame_map(&frame, &info, gst_sample_get_buffer(sample), GST_MAP_READ))
      throw Error(where_ + "an image cannot be read");
    const std::size_t row = 3 * std::size_t(info.width);
    image.bgr.resize(row * std::size_t(info.height));
    const auto* const pixels = static_cast<const std::uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
    for (std::size_t y = 0; y < std::size_t(info.height); ++y)
      std::memcpy(&image.bgr[row * y], pixels + y * std::size_t(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)),
                  row);
    gst_video_frame_unmap(&frame);
  }

  std::string where_;
  GObjectPtr<GstElement> pipeline_, images_;
  ImageSize size_;
  double rate_hz_ = kDefaultRateHz;
  ArrivalClock clock_;
  GstClockTime last_ = 0;
  std::string fault_;  ///< ": " and GStreamer's message, or empty
  std::atomic<bool> stopped_ = false;
};

}  // namespace

std::unique_ptr<CameraSource> openGStreamerSource(const NamedSource& camera) {
  return std::make_unique<GStreamerSource>(camera);
}

}  // namespace airclay
