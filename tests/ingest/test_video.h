// What: small lossless videos for tests, with colours converted by the textbook formula.
// Not: an encoder for users, and no use of swscale, which the decoder under test uses.
#pragma once
#include <filesystem>
#include <vector>

#include "ingest/scene.h"

namespace tessera::testing {

enum class VideoMatrix { kUnstated, kBt601, kBt709 };

struct TestVideo {
  std::vector<Image8> frames;  // RGB, one size
  std::vector<int64_t> ticks;  // presentation times, 1/12800 s; 25 frames/s when empty
  VideoMatrix stated = VideoMatrix::kUnstated;
  VideoMatrix used = VideoMatrix::kBt601;  // what the numbers really are
  bool full_range = false;
  bool half_chroma = true;  // 4:2:0, else 4:4:4
  int b_frames = 2;
  bool index_first = true;  // mp4: the index before the pictures, so a cut file opens
};

inline constexpr int64_t kTestTicksPerFrame = 512;  // 25 frames/s in 1/12800 s

/// False where this FFmpeg cannot encode H.264.
bool can_encode_video();
void write_video(const std::filesystem::path& path, const TestVideo& video);
/// `count` frames of 32×24 whose grey says which frame of which camera it is.
TestVideo numbered_video(int count, int camera = 0);
/// The grey that numbered_video gives to a frame.
int numbered_grey(int frame, int camera = 0);

}  // namespace tessera::testing
