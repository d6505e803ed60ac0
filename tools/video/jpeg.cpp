// The JPEG encoder of libavcodec; colours are converted by the matrix and range that JFIF states.
#include "tools/video/jpeg.h"

#include "kernels/base/errors.h"
#include "tools/video/av_handles.h"

namespace tessera {
namespace {

constexpr AVPixelFormat kFormat = AV_PIX_FMT_YUVJ444P;  // full range

/// The image in the colours of JFIF: BT.601, full range.
Owned<AVFrame> frame_of(const Image8& image) {
  Owned<AVFrame> frame(av_frame_alloc());
  Owned<SwsContext> to_yuv(sws_getContext(
      image.width, image.height, AV_PIX_FMT_RGB24, image.width, image.height, kFormat,
      SWS_POINT | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr));
  check(frame != nullptr && to_yuv != nullptr, "FFmpeg is out of memory");
  frame->width = image.width;
  frame->height = image.height;
  frame->format = kFormat;
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
  codec->pix_fmt = kFormat;
  codec->color_range = AVCOL_RANGE_JPEG;
  codec->time_base = {1, 25};
  codec->thread_count = 1;  // slices would change the bytes
  codec->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_BITEXACT;
  codec->global_quality = quantiser * FF_QP2LAMBDA;
  if (avcodec_open2(codec.get(), encoder, nullptr) < 0) return std::nullopt;
  const Owned<AVFrame> frame = frame_of(image);
  frame->quality = codec->global_quality;
  if (avcodec_send_frame(codec.get(), frame.get()) < 0 ||
      avcodec_receive_packet(codec.get(), packet.get()) < 0)
    return std::nullopt;
  return std::string(reinterpret_cast<const char*>(packet->data), size_t(packet->size));
}

}  // namespace tessera
