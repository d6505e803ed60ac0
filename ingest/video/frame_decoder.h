// Decodes packets to frames in the order of presentation, with jumps to later keyframes. A damaged
// frame is an error.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "ingest/video/video_file.h"

namespace tessera {

class FrameDecoder {
 public:
  /// Codecs run on thread_count() + 1 threads, at most 16, by frame and by slice as they can.
  /// Errors: InputError.
  explicit FrameDecoder(const std::filesystem::path& path);

  /// The next frame that is shown; its `pts` is the packet's. False at the end of the file;
  /// file().cut_reason() is not empty where that was early. Errors: InputError naming camera and
  /// time.
  bool next(AVFrame& frame);
  /// Passes over packets until `packet` (counted from the first keyframe on), a keyframe, and goes
  /// on decoding there: frames shown before it are left out.
  void jump_to(int64_t packet);
  enum class Seek {
    kStays,  // the container's index knows no later keyframe before `ticks` that saves decoding
    kMoved,  // decoding continues at a keyframe shown at or before `ticks`
    kFailed  // the index is wrong: where decoding continues is not known
  };
  /// Towards a frame that is later than those given. Frames shown before the keyframe are left out.
  Seek seek_towards(int64_t ticks);
  /// Before the first frame: whether the container has an index of all keyframes.
  bool find_index() { return file_.find_index(); }
  int64_t packets_read() const { return packets_; }
  int64_t frames_given() const { return frames_; }
  std::optional<int64_t> last_ticks() const { return last_ticks_; }
  const VideoFile& file() const { return file_; }

 private:
  [[noreturn]] void fail(const std::string& seen) const;
  void open_codec();
  void send_packet();
  bool is_shown(const AVFrame& frame);

  VideoFile file_;
  LibavOwned<AVCodecContext> codec_;
  LibavOwned<AVPacket> packet_;
  bool drained_ = false, has_packet_ = false;
  int64_t packets_ = 0, frames_ = 0;
  std::optional<int64_t> first_shown_;  // time of the keyframe that decoding started at
  std::optional<int64_t> last_ticks_;
};

}  // namespace tessera
