// SPDX-License-Identifier: MIT
// Through libavformat. OpenCV, which decodes the images, gives the time of a frame only once it is decoded,
// and loses the times of the last frames.
#include "capture/images/video_index.h"

#include <algorithm>
#include <cmath>
#include <memory>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
}

#include "engine/core/error.h"
#include "engine/core/median.h"

namespace airclay {
namespace {

// Nine hours at 30 Hz.
constexpr int kMaxFrames = 1'000'000;

struct CloseFile {
  void operator()(AVFormatContext* file) const { avformat_close_input(&file); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

int rotationOf(const AVStream& stream) {
  const std::uint8_t* matrix = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
  if (!matrix) return 0;
  const double counterclockwise = av_display_rotation_get(reinterpret_cast<const std::int32_t*>(matrix));
  if (!std::isfinite(counterclockwise)) return 0;
  return ((static_cast<int>(std::lround(-counterclockwise / 90)) % 4 + 4) % 4) * 90;
}

}  // namespace

VideoIndex readVideoIndex(const std::filesystem::path& path) {
  AVFormatContext* opened = nullptr;
  if (avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, nullptr) < 0)
    throw Error(path.string() + ": cannot be opened as a video; expected a complete video file");
  const std::unique_ptr<AVFormatContext, CloseFile> file(opened);
  avformat_find_stream_info(file.get(), nullptr);  // what it misses, the packets tell
  const int number = av_find_best_stream(file.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (number < 0) throw Error(path.string() + ": contains no video stream; expected a video file");
  const AVStream& stream = *file->streams[number];

  VideoIndex index;
  index.rotation_degrees = rotationOf(stream);
  if (const AVPixFmtDescriptor* format =
          av_pix_fmt_desc_get(static_cast<AVPixelFormat>(stream.codecpar->format))) {
    index.pixel_format = format->name;
    index.bits = format->comp[0].depth;
    index.is_mono = format->nb_components == 1;
  }
  const std::unique_ptr<AVPacket, FreePacket> packet(av_packet_alloc());
  std::vector<std::int64_t> ticks;
  while (index.frames < kMaxFrames && av_read_frame(file.get(), packet.get()) >= 0) {
    if (packet->stream_index == number && !(packet->flags & AV_PKT_FLAG_DISCARD)) {
      ++index.frames;
      if (packet->pts != AV_NOPTS_VALUE) ticks.push_back(packet->pts);
    }
    av_packet_unref(packet.get());
  }
  std::sort(ticks.begin(), ticks.end());
  const bool is_timed = static_cast<int>(ticks.size()) == index.frames &&
                        std::adjacent_find(ticks.begin(), ticks.end()) == ticks.end();
  if (is_timed)
    for (const std::int64_t tick : ticks)
      index.times_s.push_back(static_cast<double>(tick - ticks.front()) * av_q2d(stream.time_base));
  return index;
}

int missingFrames(const std::vector<double>& times_s) {
  const double interval_s = medianInterval(times_s);
  int missing = 0;
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    const double gap = (times_s[i] - times_s[i - 1]) / interval_s;
    if (gap > 1.5) missing += static_cast<int>(std::lround(gap)) - 1;
  }
  return missing;
}

double medianInterval(const std::vector<double>& times_s) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < times_s.size(); ++i) intervals.push_back(times_s[i] - times_s[i - 1]);
  return intervals.empty() ? 0 : median(intervals);
}

}  // namespace airclay
