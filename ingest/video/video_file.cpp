// Opens local files with the demuxers of libavformat, and distinguishes the reasons of a failure.
#include "ingest/video/video_file.h"

extern "C" {
#include <libavutil/display.h>
#include <libavutil/parseutils.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// What keeps a path from being opened at all; returns where nothing does.
void check_path(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string name = path.string();
  if (error == std::errc::too_many_symbolic_link_levels)
    throw InputError(fmt::format(
        "{}: cannot be opened, its links lead in a circle; put the video in its place", name));
  if (!fs::exists(status))
    throw InputError(fmt::format("{}: cannot be opened ({}); check the path", name,
                                 error ? error.message() : "no such file"));
  if (fs::is_directory(status))
    throw InputError(
        fmt::format("{}: cannot be opened as a video, it is a folder; move or rename it", name));
  if (fs::is_regular_file(status) && fs::file_size(path, error) == 0 && !error)
    throw InputError(
        fmt::format("{}: cannot be opened as a video, it is empty; copy it again", name));
}

/// 9 int32, or null. FFmpeg 6.1 moved it from the stream to its codec's parameters.
const uint8_t* display_matrix_of(const AVStream& track) {
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 102)
  const AVPacketSideData* found =
      av_packet_side_data_get(track.codecpar->coded_side_data, track.codecpar->nb_coded_side_data,
                              AV_PKT_DATA_DISPLAYMATRIX);
  return found == nullptr ? nullptr : found->data;
#else
  return av_stream_get_side_data(&track, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
#endif
}

}  // namespace

VideoFile::VideoFile(const std::filesystem::path& path)
    : name_(path.string()), camera_(path.stem().string()), ahead_(new_packet()) {
  check_path(path);
  open(path);
  find_track();
  read_display_matrix();
}

void VideoFile::open(const std::filesystem::path& path) {
  av_log_set_level(AV_LOG_QUIET);  // failures are returned as errors
  AVFormatContext* opened = nullptr;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  const std::string url = "file:" + path.string();  // else "a:b.mp4" names a protocol
  int error = avformat_open_input(&opened, url.c_str(), nullptr, &options);
  av_dict_free(&options);
  format_.reset(opened);
  if (error >= 0) error = avformat_find_stream_info(opened, nullptr);
  if (error == AVERROR(EACCES))
    throw InputError(fmt::format(
        "{}: cannot be opened, reading it is not permitted; run chmod +r on it", name_));
  if (error < 0)
    throw InputError(fmt::format(
        "{}: cannot be opened as a video ({}); it may be truncated or no video: copy or encode it "
        "again",
        name_, libav_reason(error)));
}

void VideoFile::find_track() {
  const int index = av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0 || format_->streams[index]->codecpar->width <= 0)
    throw InputError(fmt::format("{}: has no video track that can be decoded ({}); encode it again",
                                 name_, index < 0 ? libav_reason(index) : "no image size"));
  track_ = format_->streams[index];
  for (unsigned i = 0; i < format_->nb_streams; ++i)
    if (int(i) != index) format_->streams[i]->discard = AVDISCARD_ALL;
}

/// The matrix (a b; c d) maps the coded image to the shown one.
void VideoFile::read_display_matrix() {
  const uint8_t* data = display_matrix_of(*track_);
  if (data == nullptr) return;
  const auto* matrix = reinterpret_cast<const int32_t*>(data);
  const double a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  if (a * d - b * c < 0)
    throw InputError(
        fmt::format("{}: is flagged as mirrored, which no camera is; encode it as it shall be seen "
                    "(`ffmpeg -i IN OUT` does)",
                    name_));
  const double degrees = -av_display_rotation_get(matrix);  // clockwise
  const double turns = std::round(degrees / 90);
  if (!(std::abs(degrees - 90 * turns) < 0.5))
    throw InputError(fmt::format(
        "{}: is flagged as turned by {:.0f} degrees; only quarter turns are undone, encode it "
        "upright (`ffmpeg -i IN OUT` does)",
        name_, degrees));
  quarter_turns_ = ((int(turns) % 4) + 4) % 4;
}

int VideoFile::width() const {
  return quarter_turns_ % 2 == 0 ? track_->codecpar->width : track_->codecpar->height;
}

int VideoFile::height() const {
  return quarter_turns_ % 2 == 0 ? track_->codecpar->height : track_->codecpar->width;
}

double VideoFile::pixel_aspect() const {
  const AVRational stated = av_guess_sample_aspect_ratio(format_.get(), track_, nullptr);
  if (stated.num <= 0 || stated.den <= 0) return 1;
  return av_q2d(quarter_turns_ % 2 == 0 ? stated : av_inv_q(stated));
}

/// 0 where the container states none. MP4's own count holds packets that edit lists leave out.
int64_t VideoFile::stated_packets() const {
  const bool is_mp4 = std::string_view(format_->iformat->name).find("mp4") != std::string::npos;
  return is_mp4 ? avformat_index_get_entries_count(track_) : track_->nb_frames;
}

/// Matroska counts no frames, but states when a track ends, in seconds; 0 where it does not.
double VideoFile::stated_end() const {
  if (std::string_view(format_->iformat->name).find("matroska") == std::string::npos) return 0;
  if (const AVDictionaryEntry* tag = av_dict_get(track_->metadata, "DURATION", nullptr, 0)) {
    int64_t microseconds = 0;
    if (av_parse_time(&microseconds, tag->value, 1) >= 0) return double(microseconds) * 1e-6;
  }
  if (format_->nb_streams > 1 || format_->duration == AV_NOPTS_VALUE) return 0;
  return double(format_->start_time + format_->duration) * 1e-6;
}

VideoFile::Read VideoFile::cut(const std::string& reason) {
  cut_reason_ = reason;
  return Read::kCut;
}

VideoFile::Read VideoFile::end_of_file() {
  if (sought_) return Read::kEnd;
  const int64_t stated = stated_packets();
  if (packets_ < stated) return cut(fmt::format("it states {} frames", stated));
  // The last frame has its stated duration, or that of the longest other frame.
  std::sort(times_.begin(), times_.end());
  int64_t frame = last_duration_;
  for (size_t i = 1; i < times_.size(); ++i) frame = std::max(frame, times_[i] - times_[i - 1]);
  if (!times_.empty() && seconds(times_.back()) + 1.5 * seconds(frame) < stated_end())
    return cut(fmt::format("it states {:.3f} s", stated_end()));
  return Read::kEnd;
}

/// libav's result for the next packet of the track.
int VideoFile::read_track_packet(AVPacket& packet) {
  av_packet_unref(&packet);
  if (ahead_->data != nullptr) {
    av_packet_move_ref(&packet, ahead_.get());
    return 0;
  }
  int error = 0;
  while ((error = av_read_frame(format_.get(), &packet)) >= 0) {
    if (packet.stream_index == track_->index) return 0;
    av_packet_unref(&packet);
  }
  return error;
}

/// Containers with decoding times only are in order of presentation unless frames are reordered.
void VideoFile::give_time(AVPacket& packet) const {
  if (packet.pts != AV_NOPTS_VALUE) return;
  if (packet.dts == AV_NOPTS_VALUE || track_->codecpar->video_delay > 0)
    throw InputError(fmt::format(
        "{}: states no presentation times of its frames; encode it again as .mp4 or .mkv", name_));
  packet.pts = packet.dts;
}

VideoFile::Read VideoFile::read(AVPacket& packet) {
  while (true) {
    const int error = read_track_packet(packet);
    if (error == AVERROR_EOF) return end_of_file();
    if (error < 0) return cut(libav_reason(error));
    if ((packet.flags & AV_PKT_FLAG_CORRUPT) != 0) {
      if (read_track_packet(*ahead_) < 0) return cut("its last frame is incomplete");
      throw InputError(
          fmt::format("{}: camera {} is damaged at {:.3f} s; copy or encode this video again",
                      name_, camera_, packet.pts == AV_NOPTS_VALUE ? 0 : seconds(packet.pts)));
    }
    ++packets_;
    seen_key_ = seen_key_ || (packet.flags & AV_PKT_FLAG_KEY) != 0;
    if (!seen_key_) continue;
    give_time(packet);
    times_.push_back(packet.pts);
    last_duration_ = packet.duration;
    return Read::kPacket;
  }
}

bool VideoFile::find_index() {
  const std::string_view format = format_->iformat->name;
  if (format.find("mp4") != std::string_view::npos)  // but for fragments, which state no count
    return track_->nb_frames > 0 && avformat_index_get_entries_count(track_) >= track_->nb_frames;
  if (format.find("matroska") == std::string_view::npos) return false;
  // the first seek reads the cues
  return seek(std::max<int64_t>(track_->start_time, 0)) &&
         avformat_index_get_entries_count(track_) > 1;
}

std::optional<int64_t> VideoFile::indexed_key(int64_t ticks) const {
  const AVIndexEntry* const entry =
      avformat_index_get_entry_from_timestamp(track_, ticks, AVSEEK_FLAG_BACKWARD);
  if (entry == nullptr) return std::nullopt;
  return entry->timestamp;
}

bool VideoFile::seek(int64_t ticks) {
  sought_ = true;
  seen_key_ = false;
  av_packet_unref(ahead_.get());
  return av_seek_frame(format_.get(), track_->index, ticks, AVSEEK_FLAG_BACKWARD) >= 0;
}

}  // namespace tessera
