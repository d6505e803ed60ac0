// What: a container's video track as packets with presentation times, in order of decoding.
// Not: decoding (frame_decoder.h); what is wrong with a file's end is told, not judged.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/video/libav_handles.h"
#include "ingest/video/rational.h"

namespace tessera {

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
  /// that is damaged although the file goes on.
  Read read(AVPacket& packet);
  const std::string& cut_reason() const { return cut_reason_; }

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
  LibavOwned<AVPacket> ahead_;  // read to learn whether the file goes on after damage
  AVStream* track_ = nullptr;
  int quarter_turns_ = 0;
  int64_t packets_ = 0;
  bool seen_key_ = false;
  std::vector<int64_t> times_;  // of the packets so far, ticks
  int64_t last_duration_ = 0;
};

}  // namespace tessera
