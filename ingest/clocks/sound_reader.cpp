// Decodes and resamples the sound with libavformat, libavcodec and libswresample. A damaged track
// ends at the damage, without an error.
#include "ingest/clocks/sync_audio.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/channel_layout.h>
#include <libswresample/swresample.h>
}

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "ingest/video/video_file.h"

namespace tessera {
namespace {

struct ReleaseResampler {
  void operator()(SwrContext* resampler) const { swr_free(&resampler); }
};

class SoundTrack {
 public:
  bool open(const std::filesystem::path& path);
  Sound read(int rate, double seconds);

 private:
  bool receive_frames(Sound& sound, size_t most);
  bool start_resampler(const AVFrame& frame, int rate);
  void append(const uint8_t** data, int count, Sound& sound);

  LibavOwned<AVFormatContext> format_;
  LibavOwned<AVCodecContext> codec_;
  std::unique_ptr<SwrContext, ReleaseResampler> resampler_;
  LibavOwned<AVFrame> frame_ = new_frame();
  AVStream* track_ = nullptr;
};

bool SoundTrack::open(const std::filesystem::path& path) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* opened = nullptr;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);  // a playlist must not reach the network
  const std::string url = "file:" + path.string();         // else "a:b.mp4" names a protocol
  const int error = avformat_open_input(&opened, url.c_str(), nullptr, &options);
  av_dict_free(&options);
  format_.reset(opened);
  if (error < 0 || avformat_find_stream_info(opened, nullptr) < 0) return false;
  const AVCodec* decoder = nullptr;
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_AUDIO, -1, -1, &decoder, 0);
  if (index < 0 || decoder == nullptr) return false;
  for (unsigned i = 0; i < opened->nb_streams; ++i)
    if (int(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
  track_ = opened->streams[index];
  codec_.reset(avcodec_alloc_context3(decoder));
  codec_->pkt_timebase = track_->time_base;
  return avcodec_parameters_to_context(codec_.get(), track_->codecpar) >= 0 &&
         avcodec_open2(codec_.get(), decoder, nullptr) >= 0;
}

bool SoundTrack::start_resampler(const AVFrame& frame, int rate) {
  if (resampler_) return true;
  SwrContext* made = nullptr;
  AVChannelLayout one, from;
  av_channel_layout_default(&one, 1);
  if (frame.ch_layout.order == AV_CHANNEL_ORDER_UNSPEC)
    av_channel_layout_default(&from, frame.ch_layout.nb_channels);
  else
    from = frame.ch_layout;
  const int error =
      swr_alloc_set_opts2(&made, &one, AV_SAMPLE_FMT_FLT, rate, &from, AVSampleFormat(frame.format),
                          frame.sample_rate, 0, nullptr);
  resampler_.reset(made);
  return error >= 0 && swr_init(made) >= 0;
}

void SoundTrack::append(const uint8_t** data, int count, Sound& sound) {
  const size_t before = sound.samples.size();
  sound.samples.resize(before + size_t(swr_get_out_samples(resampler_.get(), count)));
  uint8_t* to = reinterpret_cast<uint8_t*>(sound.samples.data() + before);
  const int written =
      swr_convert(resampler_.get(), &to, int(sound.samples.size() - before), data, count);
  sound.samples.resize(before + size_t(std::max(0, written)));
}

/// False when there is enough or no more can be read.
bool SoundTrack::receive_frames(Sound& sound, size_t most) {
  constexpr double kGap = 0.02;  // seconds; smaller differences are rounding of time stamps
  while (true) {
    const int error = avcodec_receive_frame(codec_.get(), frame_.get());
    if (error == AVERROR(EAGAIN)) return true;
    if (error < 0 || !start_resampler(*frame_, sound.rate)) return false;
    if (frame_->best_effort_timestamp != AV_NOPTS_VALUE) {
      const double seconds = double(frame_->best_effort_timestamp) * av_q2d(track_->time_base);
      if (sound.samples.empty()) sound.begin = seconds;
      const double expected = std::min((seconds - sound.begin) * sound.rate, double(most));
      const double waiting = double(swr_get_delay(resampler_.get(), sound.rate));
      if (expected > double(sound.samples.size()) + waiting + kGap * sound.rate)
        sound.samples.resize(size_t(expected - waiting));
    }
    append(const_cast<const uint8_t**>(frame_->extended_data), frame_->nb_samples, sound);
    if (sound.samples.size() >= most) return false;
  }
}

Sound SoundTrack::read(int rate, double seconds) {
  Sound sound;
  sound.rate = rate;
  const size_t most = size_t(seconds * rate);
  const LibavOwned<AVPacket> packet = new_packet();
  bool more = true;
  while (more && av_read_frame(format_.get(), packet.get()) >= 0) {
    if (packet->stream_index == track_->index) {
      avcodec_send_packet(codec_.get(), packet.get());
      more = receive_frames(sound, most);
    }
    av_packet_unref(packet.get());
  }
  if (more) {
    avcodec_send_packet(codec_.get(), nullptr);
    receive_frames(sound, most);
  }
  if (resampler_) append(nullptr, 0, sound);
  sound.samples.resize(std::min(sound.samples.size(), most));
  return sound;
}

}  // namespace

std::optional<Sound> read_sound(const std::filesystem::path& path, int rate, double seconds) {
  SoundTrack track;
  if (!track.open(path)) return std::nullopt;
  Sound sound = track.read(rate, seconds);
  if (sound.samples.empty()) return std::nullopt;
  return sound;
}

std::optional<Sound> read_clip_sound(const RigClip& clip, int rate, double seconds) {
  std::optional<Sound> sound = read_sound(clip.video, rate, seconds);
  const size_t most = size_t(seconds * rate);
  for (size_t i = 0; sound && i < clip.chapters.size() && sound->samples.size() < most; ++i) {
    const std::optional<Sound> next = read_sound(clip.chapters[i], rate, seconds);
    if (!next) break;
    const double begin =
        next->begin + clip.timeline.time_base.at(clip.timeline.chapters[i].shift) - sound->begin;
    sound->samples.resize(std::min(most, size_t(std::lround(std::max(0.0, begin) * rate))));
    sound->samples.insert(sound->samples.end(), next->samples.begin(), next->samples.end());
    sound->samples.resize(std::min(most, sound->samples.size()));
  }
  return sound;
}

}  // namespace tessera
