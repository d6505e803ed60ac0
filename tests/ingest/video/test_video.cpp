// Encoders set to be lossless or nearly so, through libavcodec and libavformat. Every failure is an
// exception, which fails the test.
#include "tests/ingest/video/test_video.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tessera::testing {
namespace {

constexpr int kCodeBits = 10;

void need(bool fine, const char* what) {
  if (!fine) throw std::runtime_error(std::string("test video: ") + what);
}

struct Luma {
  double red, blue;
};

Luma weights(VideoMatrix matrix) {
  if (matrix == VideoMatrix::kBt709) return {0.2126, 0.0722};
  if (matrix == VideoMatrix::kBt2020) return {0.2627, 0.0593};
  return {0.299, 0.114};
}

/// Y, Cb, Cr of an R'G'B' colour: the definition of BT.601 / 709 / 2020, limited or full range.
std::array<int, 3> ycbcr(const uint8_t* rgb, const TestVideo& video) {
  const auto [kr, kb] = weights(video.used);
  const double r = rgb[0] / 255.0, g = rgb[1] / 255.0, b = rgb[2] / 255.0;
  const double y = kr * r + (1 - kr - kb) * g + kb * b;
  const double cb = (b - y) / (2 - 2 * kb), cr = (r - y) / (2 - 2 * kr);
  const double step = 1 << (video.bits - 8), top = (1 << video.bits) - 1;
  const double luma = video.full_range ? top * y : step * (16 + 219 * y);
  const double chroma = video.full_range ? top : step * 224;
  const auto level = [&](double v) { return int(std::clamp(std::round(v), 0.0, top)); };
  return {level(luma), level(step * 128 + chroma * cb), level(step * 128 + chroma * cr)};
}

void fill(AVFrame& frame, const Image8& image, const TestVideo& video) {
  const int step_x = video.chroma == VideoChroma::k444 ? 1 : 2;
  const int step_y = video.chroma == VideoChroma::k420 ? 2 : 1;
  const auto set = [&](int c, int x, int y, int value) {
    uint8_t* row = frame.data[c] + y * frame.linesize[c];
    if (video.bits == 8) row[x] = uint8_t(value);
    if (video.bits != 8) reinterpret_cast<uint16_t*>(row)[x] = uint16_t(value);
  };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto pixel = ycbcr(&image.data[size_t(3 * (y * image.width + x))], video);
      set(0, x, y, pixel[0]);
      for (int c = 1; c < 3 && x % step_x == 0 && y % step_y == 0; ++c)
        set(c, x / step_x, y / step_y, pixel[size_t(c)]);
    }
}

AVPixelFormat pixel_format(const TestVideo& video) {
  const char* chroma = video.chroma == VideoChroma::k420   ? "yuv420p"
                       : video.chroma == VideoChroma::k422 ? "yuv422p"
                                                           : "yuv444p";
  return av_get_pix_fmt((chroma + std::string(video.bits == 10 ? "10le" : "")).c_str());
}

void set_lossless(AVCodecContext& codec, const TestVideo& video) {
  const auto set = [&](const char* name, const std::string& value) {
    need(av_opt_set(codec.priv_data, name, value.c_str(), 0) >= 0, name);
  };
  const std::string open = video.open_groups ? "1" : "0";
  if (video.encoder == "libx264") {
    set("qp", video.b_frames > 0 ? "1" : "0");  // libx264 has no B-frames without loss
    set("preset", "ultrafast");
    set("x264-params", "open-gop=" + open);
  } else if (video.encoder == "libx265") {
    set("preset", "ultrafast");
    set("x265-params", "lossless=1:log-level=none:pools=none:frame-threads=1:open-gop=" + open +
                           ":keyint=" + std::to_string(video.keyframe_distance) +
                           ":bframes=" + std::to_string(video.b_frames));
  } else if (video.encoder == "libvpx-vp9") {
    set("lossless", "1");
    set("deadline", "realtime");
    set("cpu-used", "8");
  } else {
    set("aom-params", "lossless=1");
    set("cpu-used", "8");
    set("lag-in-frames", "0");
  }
}

void state_colours(AVCodecContext& codec, const TestVideo& video) {
  if (video.stated == VideoMatrix::kBt601) codec.colorspace = AVCOL_SPC_SMPTE170M;
  if (video.stated == VideoMatrix::kBt709) codec.colorspace = AVCOL_SPC_BT709;
  if (video.stated == VideoMatrix::kBt2020) codec.colorspace = AVCOL_SPC_BT2020_NCL;
  if (video.stated == VideoMatrix::kBt2020Constant) codec.colorspace = AVCOL_SPC_BT2020_CL;
  if (video.transfer == VideoTransfer::kBt709) codec.color_trc = AVCOL_TRC_BT709;
  if (video.transfer == VideoTransfer::kHlg) codec.color_trc = AVCOL_TRC_ARIB_STD_B67;
  if (video.transfer == VideoTransfer::kPq) codec.color_trc = AVCOL_TRC_SMPTE2084;
  if (video.transfer == VideoTransfer::kLog) codec.color_trc = AVCOL_TRC_LOG;
  if (video.primaries == VideoPrimaries::kBt601) codec.color_primaries = AVCOL_PRI_SMPTE170M;
  if (video.primaries == VideoPrimaries::kBt709) codec.color_primaries = AVCOL_PRI_BT709;
  if (video.primaries == VideoPrimaries::kBt2020) codec.color_primaries = AVCOL_PRI_BT2020;
}

AVCodecContext* open_encoder(const TestVideo& video) {
  const AVCodec* encoder = avcodec_find_encoder_by_name(video.encoder.c_str());
  need(encoder != nullptr, video.encoder.c_str());
  AVCodecContext* codec = avcodec_alloc_context3(encoder);
  codec->width = video.frames.front().width;
  codec->height = video.frames.front().height;
  codec->time_base = {1, 12800};
  codec->sample_aspect_ratio = {video.pixel_aspect[0], video.pixel_aspect[1]};
  codec->pix_fmt = pixel_format(video);
  codec->max_b_frames = video.b_frames;
  codec->gop_size = video.keyframe_distance;
  codec->color_range = video.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  state_colours(*codec, video);
  if (video.interlaced) codec->flags |= AV_CODEC_FLAG_INTERLACED_DCT;
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  codec->thread_count = 1;
  set_lossless(*codec, video);
  need(avcodec_open2(codec, encoder, nullptr) == 0, "encoder does not open");
  return codec;
}

/// 9 int32; FFmpeg 6.1 moved it from the stream to its codec's parameters.
uint8_t* new_display_matrix(AVStream& stream) {
  constexpr size_t kBytes = 9 * sizeof(int32_t);
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 102)
  return av_packet_side_data_new(&stream.codecpar->coded_side_data,
                                 &stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX,
                                 kBytes, 0)
      ->data;
#else
  return av_stream_new_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, kBytes);
#endif
}

void describe(AVStream& stream, const TestVideo& video) {
  for (const auto& [name, value] : video.tags)
    av_dict_set(&stream.metadata, name.c_str(), value.c_str(), 0);
  if (!video.display_matrix) return;
  auto* matrix = reinterpret_cast<int32_t*>(new_display_matrix(stream));
  std::fill(matrix, matrix + 9, 0);
  const auto& [a, b, c, d] = *video.display_matrix;
  matrix[0] = a * 65536;
  matrix[1] = b * 65536;
  matrix[3] = c * 65536;
  matrix[4] = d * 65536;
  matrix[8] = 1 << 30;
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

bool can_encode_video(const std::string& encoder) {
  return avcodec_find_encoder_by_name(encoder.c_str()) != nullptr;
}

void write_video(const std::filesystem::path& path, const TestVideo& video) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* format = nullptr;
  need(avformat_alloc_output_context2(&format, nullptr, nullptr, path.c_str()) >= 0, "container");
  AVCodecContext* codec = open_encoder(video);
  AVStream* stream = avformat_new_stream(format, nullptr);
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = {25, 1};
  stream->sample_aspect_ratio = codec->sample_aspect_ratio;
  format->avoid_negative_ts = AVFMT_AVOID_NEG_TS_DISABLED;
  need(avcodec_parameters_from_context(stream->codecpar, codec) >= 0, "parameters");
  describe(*stream, video);
  need(avio_open(&format->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0, "open");
  AVDictionary* options = nullptr;
  if (video.index_first) av_dict_set(&options, "movflags", "faststart", 0);
  need(avformat_write_header(format, &options) >= 0, "header");
  av_dict_free(&options);
  AVFrame* frame = av_frame_alloc();
  frame->width = codec->width;
  frame->height = codec->height;
  frame->format = codec->pix_fmt;
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

Image8 coded_image(int width, int height, int number) {
  Image8 image{width, height, 3, {}};
  const auto& colours = coded_colours();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        const bool bit = (number >> (x * kCodeBits / width) & 1) != 0;
        const auto patch = size_t(x) * colours.size() / size_t(width);
        image.data.push_back(2 * y >= height ? colours[patch][c] : bit ? 255 : 0);
      }
  return image;
}

int coded_number(const Image8& image) {
  int number = 0;
  for (int bit = 0; bit < kCodeBits; ++bit) {
    const int x = (2 * bit + 1) * image.width / (2 * kCodeBits);
    if (image.data[size_t(3 * (image.height / 4 * image.width + x))] > 127) number |= 1 << bit;
  }
  return number;
}

const std::vector<std::vector<uint8_t>>& coded_colours() {
  static const std::vector<std::vector<uint8_t>> kColours{
      {220, 30, 40}, {20, 200, 60}, {30, 40, 210}, {128, 128, 128}, {240, 230, 20}};
  return kColours;
}

int coded_colour_error(const Image8& image) {
  int worst = 0;
  const auto count = int(coded_colours().size());
  for (int patch = 0; patch < count; ++patch)
    for (int c = 0; c < 3; ++c) {
      const int x = (2 * patch + 1) * image.width / (2 * count), y = image.height * 3 / 4;
      const int seen = image.data[size_t(3 * (y * image.width + x) + c)];
      worst = std::max(worst, std::abs(seen - coded_colours()[size_t(patch)][size_t(c)]));
    }
  return worst;
}

}  // namespace tessera::testing
