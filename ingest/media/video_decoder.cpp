// What: libavformat and libavcodec behind one callback; every failure names file and frame.
// Not: error concealment: a damaged frame is an error, because training would learn it.
#include "ingest/media/video_decoder.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
}

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <new>
#include <string>

#include "ingest/media/video_colour.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

struct Release {
  void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
template <class T>
using Owned = std::unique_ptr<T, Release>;

std::string reason_of(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

class Video {
 public:
  explicit Video(const std::filesystem::path& path);
  VideoStream stream() const;
  int64_t decode(const std::function<bool(VideoFrame)>& on_frame);

 private:
  [[noreturn]] void fail(const std::string& seen) const;
  void refuse_rotation() const;
  void open_codec();
  bool read_packet(AVPacket& packet);
  bool receive_frames(const std::function<bool(VideoFrame)>& on_frame);
  VideoFrame take_frame(const AVFrame& frame);

  std::string name_;
  Owned<AVFormatContext> format_;
  Owned<AVCodecContext> codec_;
  AVStream* track_ = nullptr;
  FrameToRgb to_rgb_;
  int64_t packets_ = 0, frames_ = 0, last_ticks_ = 0;
};

void Video::fail(const std::string& seen) const {
  throw InputError(fmt::format(
      "{}: {}, {} frames could be read; copy or encode this video again, or pass --frames {}",
      name_, seen, frames_, frames_));
}

Video::Video(const std::filesystem::path& path) : name_(path.string()) {
  av_log_set_level(AV_LOG_QUIET);  // what matters comes back as an error
  AVFormatContext* opened = nullptr;
  int error = avformat_open_input(&opened, path.c_str(), nullptr, nullptr);
  format_.reset(opened);
  if (error >= 0) error = avformat_find_stream_info(opened, nullptr);
  if (error < 0)
    throw InputError(fmt::format(
        "{}: cannot be opened as a video ({}); it may be truncated: copy or encode it again", name_,
        reason_of(error)));
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0)
    throw InputError(fmt::format("{}: has no video track that can be decoded ({}); encode it again",
                                 name_, reason_of(index)));
  track_ = opened->streams[index];
  for (unsigned i = 0; i < opened->nb_streams; ++i)
    if (int(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
  refuse_rotation();
}

void Video::refuse_rotation() const {
  const uint8_t* matrix = av_stream_get_side_data(track_, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
  if (matrix == nullptr) return;
  const double degrees = av_display_rotation_get(reinterpret_cast<const int32_t*>(matrix));
  if (std::abs(degrees) > 0.5)
    throw InputError(fmt::format(
        "{}: is flagged as turned by {:.0f} degrees, so the poses' axes are uncertain; encode it "
        "upright (`ffmpeg -i IN OUT` does) and use poses of the upright picture",
        name_, degrees));
}

VideoStream Video::stream() const {
  return {track_->codecpar->width,
          track_->codecpar->height,
          {track_->time_base.num, track_->time_base.den},
          track_->nb_frames};
}

void Video::open_codec() {
  const AVCodec* decoder = avcodec_find_decoder(track_->codecpar->codec_id);
  if (decoder == nullptr)
    throw InputError(fmt::format("{}: its codec '{}' cannot be decoded here; encode it as H.264",
                                 name_, avcodec_get_name(track_->codecpar->codec_id)));
  codec_.reset(avcodec_alloc_context3(decoder));
  if (codec_ == nullptr) throw std::bad_alloc();
  codec_->thread_count = 0;  // as many as there are cores
  int error = avcodec_parameters_to_context(codec_.get(), track_->codecpar);
  codec_->pkt_timebase = track_->time_base;
  if (error >= 0) error = avcodec_open2(codec_.get(), decoder, nullptr);
  if (error < 0) fail(fmt::format("its decoder does not start ({})", reason_of(error)));
}

/// The next packet of the video track; false at the end of the file.
bool Video::read_packet(AVPacket& packet) {
  while (true) {
    av_packet_unref(&packet);
    const int error = av_read_frame(format_.get(), &packet);
    if (error == AVERROR_EOF) {
      if (packets_ < track_->nb_frames)
        fail(fmt::format("is truncated: it states {} frames", track_->nb_frames));
      return false;
    }
    if (error < 0) fail(fmt::format("cannot be read further ({})", reason_of(error)));
    if (packet.stream_index != track_->index) continue;
    if ((packet.flags & AV_PKT_FLAG_CORRUPT) != 0) fail("is truncated or damaged");
    ++packets_;
    return true;
  }
}

VideoFrame Video::take_frame(const AVFrame& frame) {
  if ((frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0)
    fail("is damaged");
  if (frame.width != track_->codecpar->width || frame.height != track_->codecpar->height)
    fail(fmt::format("changes its picture size from {}x{} to {}x{}", track_->codecpar->width,
                     track_->codecpar->height, frame.width, frame.height));
  const int64_t ticks = frame.best_effort_timestamp;
  if (ticks == AV_NOPTS_VALUE) fail("has a frame without a presentation time");
  if (frames_ > 0 && ticks <= last_ticks_)
    fail(fmt::format("has presentation times that do not increase ({} after {})", ticks,
                     last_ticks_));
  VideoFrame taken{ticks, to_rgb_.convert(frame)};
  if (taken.image.data.empty()) fail("has a pixel format without a conversion to RGB");
  last_ticks_ = ticks;
  ++frames_;
  return taken;
}

/// Hands over all frames the decoder has ready; false when `on_frame` wants no more.
bool Video::receive_frames(const std::function<bool(VideoFrame)>& on_frame) {
  const Owned<AVFrame> frame(av_frame_alloc());
  if (frame == nullptr) throw std::bad_alloc();
  while (true) {
    const int error = avcodec_receive_frame(codec_.get(), frame.get());
    if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return true;
    if (error < 0) fail(fmt::format("is damaged ({})", reason_of(error)));
    if (!on_frame(take_frame(*frame))) return false;
  }
}

int64_t Video::decode(const std::function<bool(VideoFrame)>& on_frame) {
  open_codec();
  const Owned<AVPacket> packet(av_packet_alloc());
  if (packet == nullptr) throw std::bad_alloc();
  while (read_packet(*packet)) {
    const int error = avcodec_send_packet(codec_.get(), packet.get());
    if (error < 0) fail(fmt::format("is damaged ({})", reason_of(error)));
    if (!receive_frames(on_frame)) return frames_;
  }
  avcodec_send_packet(codec_.get(), nullptr);  // no more packets: the decoder gives what it holds
  receive_frames(on_frame);
  if (frames_ == 0) fail("holds no picture");
  return frames_;
}

}  // namespace

VideoStream probe_video(const std::filesystem::path& path) {
  return Video(path).stream();
}

VideoStream decode_video(const std::filesystem::path& path,
                         const std::function<bool(VideoFrame)>& on_frame) {
  Video video(path);
  VideoStream stream = video.stream();
  stream.frames = video.decode(on_frame);
  return stream;
}

}  // namespace tessera
