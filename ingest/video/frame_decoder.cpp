// Combines send and receive of libavcodec in one next(). Jumps skip packets without decoding them,
// which is exact in every container; a seek by its index reads nothing in between and is checked.
#include "ingest/video/frame_decoder.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {

FrameDecoder::FrameDecoder(const std::filesystem::path& path) : file_(path), packet_(new_packet()) {
  open_codec();
}

void FrameDecoder::fail(const std::string& seen) const {
  const double seconds = last_ticks_ ? file_.seconds(*last_ticks_) : 0;
  throw InputError(fmt::format(
      "{}: camera {} {} after {:.3f} s, {} frames could be read; copy or encode this video again, "
      "or pass --frames {}",
      file_.name(), file_.camera(), seen, seconds, frames_, frames_));
}

void FrameDecoder::open_codec() {
  constexpr int kMostThreads = 16;         // codecs gain nothing from more
  const int threads = thread_count() + 1;  // one waits while its frame is taken
  const AVCodecParameters& parameters = *file_.track().codecpar;
  const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
  if (decoder == nullptr)
    throw InputError(fmt::format("{}: its codec '{}' cannot be decoded here; encode it as H.264",
                                 file_.name(), avcodec_get_name(parameters.codec_id)));
  codec_.reset(avcodec_alloc_context3(decoder));
  if (codec_ == nullptr) throw std::bad_alloc();
  codec_->thread_count = thread_count() == 1 ? 1 : std::min(threads, kMostThreads);
  codec_->thread_type = FF_THREAD_FRAME | FF_THREAD_SLICE;
  codec_->pkt_timebase = file_.track().time_base;
  int error = avcodec_parameters_to_context(codec_.get(), &parameters);
  if (error >= 0) error = avcodec_open2(codec_.get(), decoder, nullptr);
  if (error < 0)
    throw InputError(fmt::format("{}: its decoder does not start ({}); encode it again",
                                 file_.name(), libav_reason(error)));
}

void FrameDecoder::send_packet() {
  if (!has_packet_) {
    if (file_.read(*packet_) != VideoFile::Read::kPacket) {
      drained_ = true;
      avcodec_send_packet(codec_.get(), nullptr);  // the decoder gives what it holds
      return;
    }
    ++packets_;
  }
  has_packet_ = false;
  if (!first_shown_) first_shown_ = packet_->pts;
  const int error = avcodec_send_packet(codec_.get(), packet_.get());
  if (error < 0) fail(fmt::format("is damaged ({})", libav_reason(error)));
}

void FrameDecoder::jump_to(int64_t packet) {
  check(packet > packets_, "a jump goes forward");
  avcodec_flush_buffers(codec_.get());
  while (packets_ < packet + 1) {
    if (file_.read(*packet_) != VideoFile::Read::kPacket) fail("became shorter while it was read");
    ++packets_;
  }
  has_packet_ = true;
  first_shown_ = packet_->pts;
}

FrameDecoder::Seek FrameDecoder::seek_towards(int64_t ticks) {
  // a restart costs the frames that the codec's threads have begun
  constexpr double kLeastFrames = 24;
  const double rate = av_q2d(file_.track().avg_frame_rate);
  const double here = last_ticks_ ? file_.seconds(*last_ticks_)
                                  : file_.seconds(std::max<int64_t>(file_.track().start_time, 0));
  const auto pays = [&](int64_t key) {
    return file_.seconds(key) - here > kLeastFrames / (rate > 0 ? rate : 30);
  };
  const std::optional<int64_t> known = file_.indexed_key(ticks);
  if (!known || !pays(*known)) return Seek::kStays;
  avcodec_flush_buffers(codec_.get());
  // an index has times of decoding: the keyframe may be shown after `ticks`, and one before is due
  for (int64_t key = *known; true;) {
    if (!file_.seek(key) || file_.read(*packet_) != VideoFile::Read::kPacket) return Seek::kFailed;
    if (packet_->pts <= ticks) break;
    const std::optional<int64_t> earlier = file_.indexed_key(key - 1);
    if (!earlier || *earlier >= key || !pays(*earlier)) return Seek::kFailed;
    key = *earlier;
  }
  if (last_ticks_ && packet_->pts <= *last_ticks_) return Seek::kFailed;
  ++packets_;
  has_packet_ = true;
  drained_ = false;
  first_shown_ = packet_->pts;
  return Seek::kMoved;
}

/// False for what edit lists cut off, what was decoded without its references, and duplicates.
bool FrameDecoder::is_shown(const AVFrame& frame) {
  if (frame.pts == AV_NOPTS_VALUE) fail("has a frame without a presentation time");
  if ((frame.flags & AV_FRAME_FLAG_DISCARD) != 0 || frame.pts < *first_shown_) return false;
  if ((frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0)
    fail("is damaged");
  const AVCodecParameters& stated = *file_.track().codecpar;
  if (frame.width != stated.width || frame.height != stated.height)
    fail(fmt::format("changes its image size from {}x{} to {}x{}", stated.width, stated.height,
                     frame.width, frame.height));
  if (last_ticks_ && frame.pts == *last_ticks_) return false;
  if (last_ticks_ && frame.pts < *last_ticks_)
    fail(fmt::format("has presentation times that go back ({} after {})", frame.pts, *last_ticks_));
  return true;
}

bool FrameDecoder::next(AVFrame& frame) {
  while (true) {
    av_frame_unref(&frame);
    const int error = avcodec_receive_frame(codec_.get(), &frame);
    if (error == AVERROR_EOF) return false;
    if (error == AVERROR(EAGAIN)) {
      check(!drained_, "a drained decoder gives frames or ends");
      send_packet();
    } else if (error < 0) {
      fail(fmt::format("is damaged ({})", libav_reason(error)));
    } else if (is_shown(frame)) {
      last_ticks_ = frame.pts;
      ++frames_;
      return true;
    }
  }
}

}  // namespace tessera
