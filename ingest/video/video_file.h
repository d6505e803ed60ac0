// Reads the video track of a container as packets with presentation times in decoding order, and
// reports an early end of the file. Also holds the owners of libav objects.
#pragma once
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "ingest/video/frame_timing.h"

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

class VideoFile {
 public:
  /// Errors: InputError, one line: no such file, a folder, a link onto itself, no permission,
  /// empty, not a video, no video track, flipped or turned by no multiple of 90 degrees.
  explicit VideoFile(const std::filesystem::path& path);

  enum class Read {
    kPacket,  // `packet` is the next one
    kEnd,     // the file is at its end, with all that it states
    kCut      // it ends early, see cut_reason()
  };
  /// Edit lists are applied: packets outside carry AV_PKT_FLAG_DISCARD. Packets before the first
  /// keyframe are left out. Errors: InputError for a packet without a presentation time or one
  /// that is damaged although later packets can be read.
  Read read(AVPacket& packet);
  const std::string& cut_reason() const { return cut_reason_; }
  /// Before the first packet: whether this is an MP4 or Matroska file, whose times are those of its
  /// packets wherever reading begins, with an index of all keyframes.
  bool find_index();
  /// The time of the last keyframe at or before `ticks`, in decoding order, that the index knows.
  std::optional<int64_t> indexed_key(int64_t ticks) const;
  /// Reads on at a keyframe at or before `ticks`, by the index. An early end of the file is not
  /// noticed any more. False: it cannot, and where reading continues is not known.
  bool seek(int64_t ticks);

  const std::string& name() const { return name_; }      // the path
  const std::string& camera() const { return camera_; }  // file name without extension
  const AVFormatContext& format() const { return *format_; }
  const AVStream& track() const { return *track_; }
  Rational time_base() const { return {track_->time_base.num, track_->time_base.den}; }
  double seconds(int64_t ticks) const { return time_base().at(ticks); }
  /// Clockwise quarter turns that make the coded image upright, 0 to 3.
  int quarter_turns() const { return quarter_turns_; }
  int width() const;  // of the upright image
  int height() const;
  /// Width of a pixel of the upright image by its height; 1 where the file states none.
  double pixel_aspect() const;

 private:
  void open(const std::filesystem::path& path);
  void find_track();
  void read_display_matrix();
  int64_t stated_packets() const;
  double stated_end() const;
  Read end_of_file();
  Read cut(const std::string& reason);
  int read_track_packet(AVPacket& packet);
  void give_time(AVPacket& packet) const;

  std::string name_, camera_, cut_reason_;
  LibavOwned<AVFormatContext> format_;
  LibavOwned<AVPacket> ahead_;  // read to find out whether the file continues after damage
  AVStream* track_ = nullptr;
  int quarter_turns_ = 0;
  int64_t packets_ = 0;
  bool seen_key_ = false, sought_ = false;
  std::vector<int64_t> times_;  // of the packets so far, ticks
  int64_t last_duration_ = 0;
};

}  // namespace tessera
