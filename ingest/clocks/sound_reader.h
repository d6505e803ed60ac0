// Reads the sound of a video file as one channel, timed on the clock of its frames.
#pragma once
#include <filesystem>
#include <optional>
#include <vector>

namespace tessera {

struct Sound {
  double begin = 0;  // presentation time of the first sample, seconds, on the container's clock
  int rate = 0;      // samples a second
  std::vector<float> samples;  // gaps of the track are silence
};

/// The first `seconds` of sound, all channels averaged; nothing where the file has no sound track
/// that can be decoded.
std::optional<Sound> read_sound(const std::filesystem::path& path, int rate, double seconds);

}  // namespace tessera
