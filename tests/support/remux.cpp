// SPDX-License-Identifier: MIT
#include "tests/support/remux.h"

#include <cmath>
#include <stdexcept>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/display.h>
}

namespace airclay {
namespace {

void require(bool succeeded, const char* what) {
  if (!succeeded) throw std::runtime_error(std::string("remux: ") + what);
}

}  // namespace

void remuxVideo(const std::filesystem::path& from, const std::filesystem::path& to,
                const RemuxOptions& options) {
  AVFormatContext *in = nullptr, *out = nullptr;
  require(avformat_open_input(&in, from.c_str(), nullptr, nullptr) >= 0, "open");
  require(avformat_find_stream_info(in, nullptr) >= 0, "streams");
  require(avformat_alloc_output_context2(&out, nullptr, nullptr, to.c_str()) >= 0, "format");
  AVStream* stream = avformat_new_stream(out, nullptr);
  require(avcodec_parameters_copy(stream->codecpar, in->streams[0]->codecpar) >= 0, "codec");
  stream->codecpar->codec_tag = 0;
  stream->time_base = in->streams[0]->time_base;
  stream->avg_frame_rate = in->streams[0]->avg_frame_rate;
  if (options.rotation_degrees != 0) {
    auto* matrix = reinterpret_cast<std::int32_t*>(
        av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(std::int32_t)));
    av_display_rotation_set(matrix, options.rotation_degrees);
  }
  require(avio_open(&out->pb, to.c_str(), AVIO_FLAG_WRITE) >= 0, "create");
  require(avformat_write_header(out, nullptr) >= 0, "header");
  AVPacket* packet = av_packet_alloc();
  for (int frame = 0; av_read_frame(in, packet) >= 0; ++frame) {
    if (options.keep(frame)) {
      if (options.time_s)
        packet->pts = packet->dts = std::llround(options.time_s(frame) / av_q2d(in->streams[0]->time_base));
      av_packet_rescale_ts(packet, in->streams[0]->time_base, stream->time_base);
      packet->stream_index = 0;
      packet->pos = -1;
      require(av_interleaved_write_frame(out, packet) >= 0, "write");
    }
    av_packet_unref(packet);
  }
  av_packet_free(&packet);
  require(av_write_trailer(out) >= 0, "trailer");
  avio_closep(&out->pb);
  avformat_free_context(out);
  avformat_close_input(&in);
}

}  // namespace airclay
