// Small lossless videos for tests, with colours converted by the textbook formula and without
// swscale, which the decoder under test uses.
#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera::testing {

enum class VideoMatrix { kUnstated, kBt601, kBt709, kBt2020, kBt2020Constant };
enum class VideoTransfer { kUnstated, kBt709, kHlg, kPq, kLog };
enum class VideoPrimaries { kUnstated, kBt601, kBt709, kBt2020 };
enum class VideoChroma { k420, k422, k444 };

struct TestVideo {
  std::vector<Image8> frames;  // RGB, one size
  std::vector<int64_t> ticks;  // presentation times, 1/12800 s; 25 frames/s when empty
  std::string encoder = "libx264";
  VideoMatrix stated = VideoMatrix::kUnstated;
  VideoMatrix used = VideoMatrix::kBt601;             // what the numbers really are
  VideoTransfer transfer = VideoTransfer::kUnstated;  // stated; the numbers are those of `frames`
  VideoPrimaries primaries = VideoPrimaries::kUnstated;  // likewise
  bool interlaced = false;                               // libx264
  bool full_range = false;
  VideoChroma chroma = VideoChroma::k420;
  int bits = 8;
  int b_frames = 2;
  int keyframe_distance = 12;
  bool open_groups = false;
  std::array<int, 2> pixel_aspect{1, 1};  // stated width and height of a pixel
  bool index_first = true;                // mp4: the index before the images, so a cut file opens
  /// The display matrix (a b; c d): a point (x, y) is shown at (a x + c y, b x + d y), y down.
  std::optional<std::array<int, 4>> display_matrix;
  std::map<std::string, std::string> tags;  // of the video track
};

inline constexpr int64_t kTestTicksPerFrame = 512;  // 25 frames/s in 1/12800 s

/// False where this FFmpeg has no such encoder.
bool can_encode_video(const std::string& encoder = "libx264");
/// Frames before tick 0 are cut off by an edit list where the container has such (mp4, mov).
void write_video(const std::filesystem::path& path, const TestVideo& video);
/// `count` frames of 32×24 whose grey value encodes frame and camera.
TestVideo numbered_video(int count, int camera = 0);
/// The grey that numbered_video gives to a frame.
int numbered_grey(int frame, int camera = 0);

/// An image that encodes its number: ten bits as black or white blocks in the upper half, the
/// first one left, and coded_colours() as patches in the lower half.
Image8 coded_image(int width, int height, int number);
int coded_number(const Image8& image);
const std::vector<std::vector<uint8_t>>& coded_colours();
/// The largest difference of a channel from coded_colours(), in the middles of the patches.
int coded_colour_error(const Image8& image);

}  // namespace tessera::testing
