// What: libx264 without loss (qp 0) through libavcodec and libavformat.
// Not: robust; every failure is a test failure by exception.
#include "tests/ingest/test_video.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tessera::testing {
namespace {

void need(bool fine, const char* what) {
  if (!fine) throw std::runtime_error(std::string("test video: ") + what);
}

/// Y, Cb, Cr of an sRGB colour: the definition of BT.601 / BT.709, limited or full range.
std::array<uint8_t, 3> ycbcr(const uint8_t* rgb, const TestVideo& video) {
  const double kr = video.used == VideoMatrix::kBt709 ? 0.2126 : 0.299;
  const double kb = video.used == VideoMatrix::kBt709 ? 0.0722 : 0.114;
  const double r = rgb[0] / 255.0, g = rgb[1] / 255.0, b = rgb[2] / 255.0;
  const double y = kr * r + (1 - kr - kb) * g + kb * b;
  const double cb = (b - y) / (2 - 2 * kb), cr = (r - y) / (2 - 2 * kr);
  const double luma = video.full_range ? 255 * y : 16 + 219 * y;
  const double chroma = video.full_range ? 255 : 224;
  const auto byte = [](double v) { return uint8_t(std::clamp(std::lround(v), 0l, 255l)); };
  return {byte(luma), byte(128 + chroma * cb), byte(128 + chroma * cr)};
}

void fill(AVFrame& frame, const Image8& image, const TestVideo& video) {
  const int step = video.half_chroma ? 2 : 1;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto pixel = ycbcr(&image.data[size_t(3 * (y * image.width + x))], video);
      frame.data[0][y * frame.linesize[0] + x] = pixel[0];
      for (int c = 1; c < 3 && x % step == 0 && y % step == 0; ++c)
        frame.data[c][y / step * frame.linesize[c] + x / step] = pixel[size_t(c)];
    }
}

AVCodecContext* open_encoder(const TestVideo& video) {
  const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
  need(encoder != nullptr, "no libx264");
  AVCodecContext* codec = avcodec_alloc_context3(encoder);
  codec->width = video.frames.front().width, codec->height = video.frames.front().height;
  codec->time_base = {1, 12800};
  codec->pix_fmt = video.half_chroma ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV444P;
  codec->max_b_frames = video.b_frames;
  codec->gop_size = 12;
  codec->color_range = video.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  if (video.stated == VideoMatrix::kBt601) codec->colorspace = AVCOL_SPC_SMPTE170M;
  if (video.stated == VideoMatrix::kBt709) codec->colorspace = AVCOL_SPC_BT709;
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  codec->thread_count = 1;
  av_opt_set(codec->priv_data, "qp", "0", 0);
  av_opt_set(codec->priv_data, "preset", "ultrafast", 0);
  av_opt_set_int(codec->priv_data, "bf", video.b_frames, 0);
  need(avcodec_open2(codec, encoder, nullptr) == 0, "encoder does not open");
  return codec;
}

void drain(AVCodecContext* codec, AVFormatContext* format, const AVFrame* frame) {
  need(avcodec_send_frame(codec, frame) == 0, "send_frame");
  AVPacket* packet = av_packet_alloc();
  while (avcodec_receive_packet(codec, packet) == 0) {
    packet->duration = kTestTicksPerFrame;
    av_packet_rescale_ts(packet, codec->time_base, format->streams[0]->time_base);
    need(av_interleaved_write_frame(format, packet) == 0, "write_frame");
  }
  av_packet_free(&packet);
}

}  // namespace

bool can_encode_video() {
  return avcodec_find_encoder_by_name("libx264") != nullptr;
}

void write_video(const std::filesystem::path& path, const TestVideo& video) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* format = nullptr;
  need(avformat_alloc_output_context2(&format, nullptr, nullptr, path.c_str()) >= 0, "container");
  AVCodecContext* codec = open_encoder(video);
  AVStream* stream = avformat_new_stream(format, nullptr);
  stream->time_base = codec->time_base;
  need(avcodec_parameters_from_context(stream->codecpar, codec) >= 0, "parameters");
  need(avio_open(&format->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0, "open");
  AVDictionary* options = nullptr;
  if (video.index_first) av_dict_set(&options, "movflags", "faststart", 0);
  need(avformat_write_header(format, &options) >= 0, "header");
  av_dict_free(&options);
  AVFrame* frame = av_frame_alloc();
  frame->width = codec->width, frame->height = codec->height, frame->format = codec->pix_fmt;
  need(av_frame_get_buffer(frame, 0) == 0, "frame");
  for (size_t i = 0; i < video.frames.size(); ++i) {
    need(av_frame_make_writable(frame) == 0, "writable");
    fill(*frame, video.frames[i], video);
    frame->pts = video.ticks.empty() ? int64_t(i) * kTestTicksPerFrame : video.ticks[i];
    drain(codec, format, frame);
  }
  drain(codec, format, nullptr);
  need(av_write_trailer(format) == 0, "trailer");
  av_frame_free(&frame);
  avcodec_free_context(&codec);
  avio_closep(&format->pb);
  avformat_free_context(format);
}

int numbered_grey(int frame, int camera) {
  return 30 + 9 * frame + 40 * camera;
}

TestVideo numbered_video(int count, int camera) {
  TestVideo video;
  for (int i = 0; i < count; ++i) {
    Image8 image{32, 24, 3, {}};
    image.data.assign(32 * 24 * 3, uint8_t(numbered_grey(i, camera)));
    video.frames.push_back(std::move(image));
  }
  return video;
}

}  // namespace tessera::testing
