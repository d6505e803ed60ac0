// How many windows a clip is cut into: --windows.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// "none", "auto", a length: "5s", or "auto:5s".
struct WindowWish {
  enum class Kind { kNone, kAuto, kLength };
  Kind kind = Kind::kNone;
  double seconds = 0;  // of kLength; of kAuto: of every clip that can be cut; 0: of long ones
};

/// Errors: InputError naming --windows.
WindowWish parse_windows(const std::string& text);

struct WindowChoice {
  int64_t count = 1;   // 1: the clip is trained as a whole
  std::string reason;  // in words; "" where nothing is to be said
};

/// `scene` lists the frames, without pixels. `memory`: bytes that a program can have. `auto`
/// cuts a rig of fixed cameras where the clip is longer than 20 s, or where its images and masks
/// would take more than half of the memory: into windows of about 5 s, shorter ones where these
/// would not fit; with a length any such rig into windows of about that. Errors: InputError: a
/// length for a capture that cannot be cut, or that makes windows of less than a few timesteps.
WindowChoice choose_windows(const WindowWish& wish, const Scene& scene, int64_t memory);

/// Of all splits together, by the numbers of their frames.
int64_t timesteps_of(const Scene& scene);

/// Why a capture cannot be cut into windows that share what stands still; "" where it can.
std::string reason_against_windows(const Scene& scene);
/// In words for such a reason.
std::string whole_clip_text(const std::string& reason);

}  // namespace tessera
