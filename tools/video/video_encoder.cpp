// Video by libavformat, libavcodec (libx264) and libswscale, JPEG by libavcodec in the colours that
// JFIF states. Every handle has an owner.
#include "tools/video/video_encoder.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

struct AvRelease {
  void operator()(AVFormatContext* c) const {
    if (c->pb != nullptr) avio_closep(&c->pb);
    avformat_free_context(c);
  }
  void operator()(AVCodecContext* c) const { avcodec_free_context(&c); }
  void operator()(AVFrame* f) const { av_frame_free(&f); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* c) const { sws_freeContext(c); }
};
template <class T>
using Owned = std::unique_ptr<T, AvRelease>;

constexpr int kHighDefinitionLines = 720;  // from here on players assume BT.709
constexpr int kEncoderThreads = 4;         // fixed: x264's bytes depend on it
constexpr int kMostErrno = 4096;           // FFmpeg's own codes are beyond

std::string reason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof(text));
  return text;
}

constexpr AVPixelFormat kJpegFormat = AV_PIX_FMT_YUVJ444P;  // full range

/// The image in the colours of JFIF: BT.601, full range.
Owned<AVFrame> jpeg_frame(const Image8& image) {
  Owned<AVFrame> frame(av_frame_alloc());
  Owned<SwsContext> to_yuv(sws_getContext(
      image.width, image.height, AV_PIX_FMT_RGB24, image.width, image.height, kJpegFormat,
      SWS_POINT | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr));
  check(frame != nullptr && to_yuv != nullptr, "FFmpeg is out of memory");
  frame->width = image.width;
  frame->height = image.height;
  frame->format = kJpegFormat;
  frame->color_range = AVCOL_RANGE_JPEG;
  check(av_frame_get_buffer(frame.get(), 0) >= 0, "FFmpeg is out of memory");
  const int* matrix = sws_getCoefficients(SWS_CS_ITU601);
  sws_setColorspaceDetails(to_yuv.get(), matrix, 1, matrix, 1, 0, 1 << 16, 1 << 16);
  const uint8_t* from[] = {image.data.data()};
  const int stride[] = {3 * image.width};
  sws_scale(to_yuv.get(), from, stride, 0, image.height, frame->data, frame->linesize);
  return frame;
}

}  // namespace

struct VideoEncoder::State {
  explicit State(const std::filesystem::path& target) : path(target.string()), whole(target) {}

  std::string path;
  AtomicFile whole;  // made first and let go last: libav writes into its temporary
  Owned<AVFormatContext> file;
  Owned<AVCodecContext> codec;
  Owned<SwsContext> to_yuv;
  Owned<AVFrame> frame;
  Owned<AVPacket> packet;
  AVStream* stream = nullptr;  // of file
  int64_t count = 0;

  /// Throws for a negative FFmpeg result: errno is in those of writing.
  void require(int result, const char* what) const {
    if (result < 0 && !path_is_at_fault(AVUNERROR(result)) && AVUNERROR(result) < kMostErrno)
      fail_to_write(path, AVUNERROR(result));
    if (result < 0)
      throw InputError(path + ": cannot be written (" + what + ": " + reason(result) +
                       "); free space or choose another folder");
  }

  void open_codec(const VideoFormat& format);
  void open_file();
  void open_conversion();
  void set_option(void* object, const char* name, const std::string& value) const {
    require(av_opt_set(object, name, value.c_str(), 0), name);
  }
  void encode(const AVFrame* input);
};

void VideoEncoder::State::open_codec(const VideoFormat& format) {
  const AVCodec* h264 = avcodec_find_encoder_by_name("libx264");
  if (h264 == nullptr)
    throw InputError(path +
                     ": cannot be written: this FFmpeg has no libx264; install one that has, "
                     "or leave video out");
  codec.reset(avcodec_alloc_context3(h264));
  check(codec != nullptr, "avcodec_alloc_context3 returned null");
  const bool high = format.colour == VideoColour::kBt709 || format.height >= kHighDefinitionLines;
  codec->width = format.width;
  codec->height = format.height;
  codec->pix_fmt = AV_PIX_FMT_YUV420P;
  codec->framerate = {format.fps.numerator, format.fps.denominator};
  codec->time_base = av_inv_q(codec->framerate);
  codec->color_range = AVCOL_RANGE_MPEG;
  codec->colorspace = high ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  codec->color_primaries = high ? AVCOL_PRI_BT709 : AVCOL_PRI_SMPTE170M;
  codec->color_trc = high ? AVCOL_TRC_BT709 : AVCOL_TRC_SMPTE170M;
  codec->chroma_sample_location = AVCHROMA_LOC_CENTER;
  codec->thread_count = kEncoderThreads;
  codec->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
  set_option(codec->priv_data, "preset", "medium");
  set_option(codec->priv_data, "crf", std::to_string(format.quality));
  set_option(codec->priv_data, "mbtree", "0");  // x264's reads memory that it has not written
  require(avcodec_open2(codec.get(), h264, nullptr), "opening libx264");
}

void VideoEncoder::State::open_file() {
  AVFormatContext* made = nullptr;
  const std::string temporary = whole.temporary_path().string();
  require(avformat_alloc_output_context2(&made, nullptr, "mp4", temporary.c_str()), "mp4");
  file.reset(made);
  file->flags |= AVFMT_FLAG_BITEXACT;  // no library version in the file
  stream = avformat_new_stream(made, nullptr);
  check(stream != nullptr, "avformat_new_stream returned null");
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  require(avcodec_parameters_from_context(stream->codecpar, codec.get()), "codec parameters");
  require(avio_open(&file->pb, temporary.c_str(), AVIO_FLAG_WRITE), "opening");
  set_option(file->priv_data, "movflags", "+faststart");
  require(avformat_write_header(made, nullptr), "header");
}

void VideoEncoder::State::open_conversion() {
  to_yuv.reset(sws_alloc_context());
  check(to_yuv != nullptr, "sws_alloc_context returned null");
  SwsContext* sws = to_yuv.get();
  const auto number = [&](const char* name, int value) {
    require(av_opt_set_int(sws, name, value, 0), name);
  };
  number("srcw", codec->width);
  number("srch", codec->height);
  number("dstw", codec->width);
  number("dsth", codec->height);
  number("src_format", AV_PIX_FMT_RGB24);
  number("dst_format", AV_PIX_FMT_YUV420P);
  number("sws_flags", SWS_AREA | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT);
  number("dst_h_chr_pos", 128);
  number("dst_v_chr_pos", 128);  // the centre of 2 × 2 pixels
  require(sws_init_context(sws, nullptr, nullptr), "colour conversion");
  const int matrix = codec->colorspace == AVCOL_SPC_BT709 ? SWS_CS_ITU709 : SWS_CS_ITU601;
  const int* table = sws_getCoefficients(matrix);
  require(sws_setColorspaceDetails(sws, table, 1, table, 0, 0, 1 << 16, 1 << 16),
          "colour conversion");
}

/// Hands a frame (null: the end) to the encoder and writes what it gives back.
void VideoEncoder::State::encode(const AVFrame* input) {
  require(avcodec_send_frame(codec.get(), input), "encoding");
  while (true) {
    const int result = avcodec_receive_packet(codec.get(), packet.get());
    if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
    require(result, "encoding");
    packet->duration = 1;
    packet->stream_index = stream->index;
    av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
    require(av_interleaved_write_frame(file.get(), packet.get()), "writing");
  }
}

VideoEncoder::VideoEncoder(const std::filesystem::path& path, const VideoFormat& format)
    : state_(std::make_unique<State>(path)) {
  av_log_set_level(AV_LOG_FATAL);  // of the process: libraries do not print, errors come as codes
  State& s = *state_;
  s.open_codec(format);
  s.open_file();
  s.open_conversion();
  s.packet.reset(av_packet_alloc());
  s.frame.reset(av_frame_alloc());
  check(s.packet != nullptr && s.frame != nullptr, "FFmpeg is out of memory");
  s.frame->width = format.width;
  s.frame->height = format.height;
  s.frame->format = AV_PIX_FMT_YUV420P;
  s.require(av_frame_get_buffer(s.frame.get(), 0), "frame");
}

VideoEncoder::~VideoEncoder() = default;

void VideoEncoder::add(const Image8& image) {
  State& s = *state_;
  check(image.width == s.frame->width && image.height == s.frame->height && image.channels == 3,
        "a video frame is RGB and of the video's size");
  s.require(av_frame_make_writable(s.frame.get()), "frame");
  const uint8_t* from[] = {image.data.data()};
  const int stride[] = {3 * image.width};
  sws_scale(s.to_yuv.get(), from, stride, 0, image.height, s.frame->data, s.frame->linesize);
  s.frame->pts = s.count++;
  s.encode(s.frame.get());
}

void VideoEncoder::finish() {
  state_->encode(nullptr);
  state_->require(av_write_trailer(state_->file.get()), "trailer");
  avio_flush(state_->file->pb);
  const int written = state_->file->pb->error;  // avio_closep may not return it
  const int closed = avio_closep(&state_->file->pb);
  state_->require(written, "writing");
  state_->require(closed, "closing");
  state_->whole.commit();
}

bool video_encoder_available() {
  return true;
}

std::optional<std::string> jpeg_bytes(const Image8& image, int quantiser) {
  check(image.channels == 3 && image.width > 0 && image.height > 0, "a JPEG of an RGB image");
  av_log_set_level(AV_LOG_FATAL);  // of the process: libraries do not print
  const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_MJPEG);
  if (encoder == nullptr) return std::nullopt;
  Owned<AVCodecContext> codec(avcodec_alloc_context3(encoder));
  Owned<AVPacket> packet(av_packet_alloc());
  check(codec != nullptr && packet != nullptr, "FFmpeg is out of memory");
  codec->width = image.width;
  codec->height = image.height;
  codec->pix_fmt = kJpegFormat;
  codec->color_range = AVCOL_RANGE_JPEG;
  codec->time_base = {1, 25};
  codec->thread_count = 1;  // slices would change the bytes
  codec->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_BITEXACT;
  codec->global_quality = quantiser * FF_QP2LAMBDA;
  if (avcodec_open2(codec.get(), encoder, nullptr) < 0) return std::nullopt;
  const Owned<AVFrame> frame = jpeg_frame(image);
  frame->quality = codec->global_quality;
  if (avcodec_send_frame(codec.get(), frame.get()) < 0 ||
      avcodec_receive_packet(codec.get(), packet.get()) < 0)
    return std::nullopt;
  return std::string(reinterpret_cast<const char*>(packet->data), size_t(packet->size));
}

}  // namespace tessera
