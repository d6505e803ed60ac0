// Decodes all frames, or the wanted frames from the nearest keyframe before each, and converts them
// to RGB on all threads.
#include "ingest/video/video_decoder.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "ingest/video/frame_decoder.h"
#include "ingest/video/video_colour.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// Decoded frames, converted to RGB on all cores, one converter a thread, and handed over in order.
class ImageBatch {
 public:
  ImageBatch(const VideoFile& file, const DecodeOptions& options,
             const std::function<bool(VideoFrame)>& on_frame);

  /// Takes the frame's reference. False once `on_frame` has returned false.
  bool add(AVFrame& frame);
  /// Hands over the waiting frames; false once `on_frame` has returned false. Errors: InputError
  /// for a pixel format without a conversion.
  bool deliver();
  int64_t delivered() const { return delivered_; }

 private:
  std::string name_;
  ImageShape shape_;
  const std::function<bool(VideoFrame)>& on_frame_;
  std::vector<FrameToRgb> converters_;  // one a waiting frame
  std::vector<LibavOwned<AVFrame>> frames_;
  size_t waiting_ = 0;
  int64_t delivered_ = 0;
  bool stopped_ = false;
};

ImageBatch::ImageBatch(const VideoFile& file, const DecodeOptions& options,
                       const std::function<bool(VideoFrame)>& on_frame)
    : name_(file.name()),
      shape_{file.quarter_turns(), options.width, options.height},
      on_frame_(on_frame),
      converters_(size_t(thread_count())) {
  check((options.width > 0) == (options.height > 0) && options.width <= file.width() &&
            options.height <= file.height(),
        "images are handed out in the video's size or smaller");
  for (size_t i = 0; i < converters_.size(); ++i) frames_.push_back(new_frame());
}

bool ImageBatch::add(AVFrame& frame) {
  av_frame_unref(frames_[waiting_].get());
  av_frame_move_ref(frames_[waiting_].get(), &frame);
  return ++waiting_ < frames_.size() || deliver();
}

bool ImageBatch::deliver() {
  std::vector<Image8> images(waiting_);
  parallel_for(int64_t(waiting_), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i) {
      images[i] = converters_[i].convert(*frames_[i], shape_);
      if (images[i].data.empty()) {
        if (const auto refusal = colour_refusal(colour_of(*frames_[i])); !refusal.empty())
          throw InputError(fmt::format("{}: {}", name_, refusal));
        const char* format = av_get_pix_fmt_name(AVPixelFormat(frames_[i]->format));
        throw InputError(
            fmt::format("{}: its pixels ({}) have no conversion to RGB here; encode it again with "
                        "`ffmpeg -i IN -pix_fmt yuv420p OUT`",
                        name_, format != nullptr ? format : "unknown"));
      }
    }
  });
  const size_t count = std::exchange(waiting_, 0);
  for (size_t i = 0; i < count && !stopped_; ++i) {
    ++delivered_;
    stopped_ = !on_frame_({frames_[i]->pts, std::move(images[i]), colour_of(*frames_[i])});
  }
  for (size_t i = 0; i < count; ++i) av_frame_unref(frames_[i].get());
  return !stopped_;
}

VideoStream stream_of(const VideoFile& file) {
  return {file.width(), file.height(), file.time_base(), file.track().nb_frames, {}};
}

/// Checks whether the file ends early. Errors: InputError unless that is to be kept.
void judge_end(const FrameDecoder& decoder, Truncation truncation, VideoStream& stream) {
  const VideoFile& file = decoder.file();
  const int64_t frames = decoder.frames_given();
  const std::string& reason = file.cut_reason();
  const double seconds = decoder.last_ticks() ? file.seconds(*decoder.last_ticks()) : 0;
  if (!reason.empty() && (truncation == Truncation::kRefuse || frames == 0))
    throw InputError(fmt::format(
        "{}: camera {} is truncated ({}), {} frames could be read, up to {:.3f} s; copy or encode "
        "this video again, or pass --frames {}",
        file.name(), file.camera(), reason, frames, seconds, frames));
  if (frames == 0)
    throw InputError(
        fmt::format("{}: camera {} holds no image; encode it again", file.name(), file.camera()));
  if (!reason.empty())
    stream.warnings.push_back(
        fmt::format("{}: camera {} is truncated after {} frames at {:.3f} s ({}); the frames up to "
                    "there are used",
                    file.name(), file.camera(), frames, seconds, reason));
}

/// Where decoding can start: keyframes by their place in the file and their time.
struct EntryPoint {
  int64_t packet = 0;
  int64_t ticks = 0;
};

/// The keyframes up to `last`, read without decoding.
std::vector<EntryPoint> entry_points(const std::filesystem::path& path, int64_t last) {
  VideoFile file(path);
  const LibavOwned<AVPacket> packet = new_packet();
  std::vector<EntryPoint> points;
  for (int64_t i = 0; file.read(*packet) == VideoFile::Read::kPacket; ++i) {
    if (packet->dts != AV_NOPTS_VALUE && packet->dts > last) break;
    if ((packet->flags & AV_PKT_FLAG_KEY) != 0) points.push_back({i, packet->pts});
  }
  return points;
}

class WantedFrames {
 public:
  WantedFrames(const std::filesystem::path& path, const std::vector<int64_t>& wanted,
               const std::function<bool(VideoFrame)>& on_frame, const DecodeOptions& options)
      : path_(path), wanted_(wanted), decoder_(path), batch_(decoder_.file(), options, on_frame) {}

  /// Decodes from the keyframes of the container's index where that saves packets. False when there
  /// is none, or it is wrong, or a wanted frame did not come although it was decoded from a
  /// keyframe.
  bool decode_by_index() {
    return decoder_.find_index() && decode([&](int64_t ticks) {
             const FrameDecoder::Seek seek = decoder_.seek_towards(ticks);
             jumped_ = jumped_ || seek != FrameDecoder::Seek::kStays;
             return seek != FrameDecoder::Seek::kFailed;
           });
  }
  /// The same from the keyframes in `points`, all packets without any.
  bool decode_from(const std::vector<EntryPoint>& points) {
    return decode([&](int64_t ticks) {
      jump_if_it_pays(points, ticks);
      return true;
    });
  }
  /// Goes back to the beginning of the file; frames handed over already do not come again.
  void start_again() {
    decoder_ = FrameDecoder(path_);
    jumped_ = false;
  }

 private:
  /// `go_towards`: tells the decoder where the next wanted frame is; false: it cannot go there.
  bool decode(const std::function<bool(int64_t)>& go_towards) {
    const LibavOwned<AVFrame> frame = new_frame();
    for (; next_ < wanted_.size(); ++next_) {
      if (!go_towards(wanted_[next_])) return false;
      bool found = false;
      try {
        found = decode_until(*frame, wanted_[next_]);
      } catch (const InputError&) {
        if (jumped_) return false;  // damage, or a keyframe that needs earlier frames
        if (!batch_.deliver()) return true;
        throw;
      }
      if (!found && jumped_) return false;
      if (!found && !batch_.deliver()) return true;
      if (!found) refuse_missing();
      if (!batch_.add(*frame)) return true;
    }
    batch_.deliver();
    return true;
  }

  /// A restart costs the frames that the codec's threads have begun: less than this many packets.
  static constexpr int64_t kLeastJump = 24;

  void jump_if_it_pays(const std::vector<EntryPoint>& points, int64_t ticks) {
    int64_t packet = -1;
    for (const EntryPoint& point : points)
      if (point.ticks <= ticks) packet = std::max(packet, point.packet);
    if (packet < decoder_.packets_read() + kLeastJump) return;
    decoder_.jump_to(packet);
    jumped_ = true;
  }

  /// False where the frame after `ticks` came without one at it.
  bool decode_until(AVFrame& frame, int64_t ticks) {
    while (decoder_.last_ticks().value_or(INT64_MIN) < ticks)
      if (!decoder_.next(frame)) return false;
    return frame.pts == ticks;
  }

  [[noreturn]] void refuse_missing() const {
    const VideoFile& file = decoder_.file();
    throw InputError(fmt::format(
        "{}: camera {} has no frame at {:.6f} s{}; copy or encode this video again", file.name(),
        file.camera(), file.seconds(wanted_[next_]),
        file.cut_reason().empty() ? "" : fmt::format(", it is truncated ({})", file.cut_reason())));
  }

  const std::filesystem::path& path_;
  const std::vector<int64_t>& wanted_;
  FrameDecoder decoder_;
  ImageBatch batch_;
  size_t next_ = 0;
  bool jumped_ = false;
};

}  // namespace

VideoStream probe_video(const std::filesystem::path& path) {
  return stream_of(VideoFile(path));
}

VideoStream decode_video(const std::filesystem::path& path,
                         const std::function<bool(VideoFrame)>& on_frame,
                         const DecodeOptions& options) {
  FrameDecoder decoder(path);
  VideoStream stream = stream_of(decoder.file());
  ImageBatch batch(decoder.file(), options, on_frame);
  const LibavOwned<AVFrame> frame = new_frame();
  bool goes_on = true;
  try {
    while (goes_on && decoder.next(*frame)) goes_on = batch.add(*frame);
  } catch (const InputError&) {  // all wanted frames may lie before the damage
    if (batch.deliver()) throw;
    goes_on = false;
  }
  if (goes_on && batch.deliver()) judge_end(decoder, options.truncation, stream);
  stream.frames = batch.delivered();
  return stream;
}

void decode_frames(const std::filesystem::path& path, const std::vector<int64_t>& wanted,
                   const std::function<bool(VideoFrame)>& on_frame, const DecodeOptions& options) {
  if (wanted.empty()) return;
  check(std::adjacent_find(wanted.begin(), wanted.end(), std::greater_equal<>()) == wanted.end(),
        "wanted times increase");
  WantedFrames frames(path, wanted, on_frame, options);
  if (frames.decode_by_index()) return;
  frames.start_again();
  if (frames.decode_from(entry_points(path, wanted.back()))) return;
  frames.start_again();  // with all packets from the first: what is missing then is missing
  frames.decode_from({});
}

}  // namespace tessera
