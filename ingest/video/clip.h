// The clip of one camera: a video or numbered images, with the times and colours of its frames and,
// where it is known, the pose of the camera. Reading one needs the media libraries; this does not.
#pragma once
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/images/image_paths.h"
#include "ingest/poses/lens.h"
#include "ingest/video/frame_timing.h"

namespace tessera {

/// How code values stand for light. ITU-R BT.2100 (HLG, PQ).
enum class TransferCurve {
  kSdr,  // BT.709, BT.601, sRGB, BT.2020 and what is unstated; values are taken as sRGB
  kHlg,  // ARIB STD-B67
  kPq,   // SMPTE ST 2084
  kNone  // linear, logarithmic, DCDM: has no conversion to sRGB here
};

enum class ColourPrimaries {
  kBt709,  // also SMPTE 170M, BT.470BG and whatever else differs little from BT.709, and unstated
  kBt2020  // of HLG and PQ where none are stated
};

struct FrameColour {
  int matrix = 0;           // swscale's SWS_CS_…; kNoMatrix where it has no conversion to RGB
  bool full_range = false;  // black and white are the least and the greatest code
  TransferCurve transfer = TransferCurve::kSdr;
  ColourPrimaries primaries = ColourPrimaries::kBt709;
  bool interlaced = false;                // the lines of two times alternate
  const char* transfer_name = "unknown";  // as FFmpeg names what is stated
  const char* matrix_name = "unknown";

  static constexpr int kNoMatrix = -1;
  /// Its values are sRGB with BT.709 primaries as they are.
  bool is_srgb() const {
    return transfer == TransferCurve::kSdr && primaries == ColourPrimaries::kBt709;
  }
};

/// Where a further file of a recording begins in the clip.
struct ChapterStart {
  int64_t first = 0;  // ticks of its first frame in the clip
  int64_t shift = 0;  // ticks that are added to those of the file
};

/// A time that a container states.
struct ContainerClock {
  double seconds = 0;  // since any common origin
  double day = 0;      // of a timecode: after so many seconds it restarts; 0: never
  /// Seconds since `other`, by the shorter way where both restart.
  double since(const ContainerClock& other) const {
    const double difference = seconds - other.seconds;
    return day > 0 && other.day > 0 ? std::remainder(difference, day) : difference;
  }
};

/// The presentation times of the frames, and the defects of their clock.
struct VideoTimeline {
  int width = 0, height = 0;   // of the upright image: a rotation flag is undone
  int quarter_turns = 0;       // by which frames were turned for that, clockwise, 0 to 3
  double pixel_aspect = 1;     // width of a pixel by its height, as shown
  Rational time_base;          // seconds a tick
  std::vector<int64_t> ticks;  // presentation times of the frames that are shown, increasing
  double frame_seconds = 0;    // median distance of two frames; 0 for one frame
  std::optional<ContainerClock> clock;  // at tick 0; absent where the container states none
  FrameColour colour;                   // as the container and the headers state it
  bool has_audio = false;
  bool has_alpha = false;  // which is not read
  bool truncated = false;  // the file ends before what it states; `ticks` are what is there
  std::vector<std::string> warnings;  // each with the file: gaps, duplicates, truncation, with
                                      // seconds

  std::vector<ChapterStart> chapters{};  // one a further file; empty where there is one file

  double seconds(size_t frame) const { return time_base.at(ticks[frame]); }
  /// Anamorphic video (HDV: 4:3) is kept in the pixels that it has, with two focal lengths.
  bool has_square_pixels() const { return std::abs(pixel_aspect - 1) < 1e-3; }
  int shown_width() const { return int(std::lround(width * pixel_aspect)); }
};

/// A camera's video or numbered images, with its pose where that is known.
struct RigClip {
  std::string name;             // "cam02"
  std::filesystem::path video;  // of images: their folder, or that and what their names begin with
  VideoTimeline timeline;
  std::optional<RigCamera> camera;
  std::vector<NumberedImage> images{};            // numbers are ticks; empty for a video
  std::optional<Rational> number_seconds{};       // where these are times
  std::vector<std::filesystem::path> chapters{};  // further files of the recording, in their order
};

}  // namespace tessera
