// Clock offsets from the sound tracks of the videos, which are read as one channel on the clock of
// the frames. Source: GCC-PHAT (Knapp, Carter 1976).
#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "ingest/clocks/clock_sync.h"

namespace tessera {

struct Sound {
  double begin = 0;  // presentation time of the first sample, seconds, on the container's clock
  int rate = 0;      // samples a second
  std::vector<float> samples;  // gaps of the track are silence
};

/// The first `seconds` of sound, all channels averaged; nothing where the file has no sound track
/// that can be decoded.
std::optional<Sound> read_sound(const std::filesystem::path& path, int rate, double seconds);

/// The same of a clip with its chapters, on the clip's clock.
std::optional<Sound> read_clip_sound(const RigClip& clip, int rate, double seconds);

struct SoundDelay {
  double seconds = 0;     // how much later than b's stamps a's stamps show the same sound
  double confidence = 0;  // the peak by the highest one more than 10 ms beside it; noise has 1
};

/// Delay of each pair (a < b, in the order 01, 02, …, 12, …) of sounds of one rate.
/// Memory: 8 MB a minute of each sound at 8 kHz.
std::vector<SoundDelay> sound_delays(const std::vector<Sound>& sounds);

/// One clock a clip, their median 0; one within its error of that stays at 0. Nothing, with one
/// line about the first camera at fault in `reason`, unless all clips have sound and clear peaks
/// connect them all.
std::optional<std::vector<ClipClock>> synchronise_by_audio(const std::vector<RigClip>& clips,
                                                           const IngestProgress& progress,
                                                           std::string& reason);

}  // namespace tessera
