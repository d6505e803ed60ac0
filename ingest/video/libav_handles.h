// What: owners of libav's objects, and what its error numbers mean.
// Not: a wrapper of libav; the functions are called by their names.
#pragma once
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <memory>
#include <new>
#include <string>

namespace tessera {

struct LibavRelease {
  void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
template <class T>
using LibavOwned = std::unique_ptr<T, LibavRelease>;

inline LibavOwned<AVPacket> new_packet() {
  LibavOwned<AVPacket> packet(av_packet_alloc());
  if (packet == nullptr) throw std::bad_alloc();
  return packet;
}

inline LibavOwned<AVFrame> new_frame() {
  LibavOwned<AVFrame> frame(av_frame_alloc());
  if (frame == nullptr) throw std::bad_alloc();
  return frame;
}

inline std::string libav_reason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

}  // namespace tessera
