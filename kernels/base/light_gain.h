// Light that changes between two images of one fixed camera: clouds, a dimmer, automatic exposure.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace tessera {

/// Factors of red, green and blue. Values are those of the files, whose curve a factor of the
/// light passes as another factor.
using LightGain = std::array<double, 3>;
inline constexpr LightGain kSameLight = {1, 1, 1};

/// What most pixels of `image` are, by those of `reference`, both RGB of 8 bits and of one size:
/// the medians of their ratios, so that less than half of the pixels may show something else.
/// Pixels that are nearly black or white in either do not tell. kSameLight where that is the same,
/// or where too few pixels tell.
LightGain light_gain(const std::vector<uint8_t>& image, const std::vector<uint8_t>& reference);

/// Each value times its factor, up to 255.
std::vector<uint8_t> times_light(const std::vector<uint8_t>& image, const LightGain& gain);

LightGain inverse(const LightGain& gain);

/// Whether all factors are 1 within 1 %.
bool is_same(const LightGain& gain);

}  // namespace tessera
