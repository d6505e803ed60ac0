// Medians of 8-bit images, value by value, and how far still values lie from theirs.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

constexpr size_t kMostOfByteMedian = 255;  // images, whose counts are bytes

/// The lower median of the images at each of their values. `images`: one to kMostOfByteMedian of
/// the same size.
std::vector<uint8_t> lower_medians(const std::vector<const std::vector<uint8_t>*>& images);

constexpr int kStillLimit = 10;    // 8-bit units
constexpr double kStillNoise = 3;  // standard deviations of a channel, measured a little low

/// Most that a value of a still pixel differs from its median, 8-bit units: kStillLimit, or
/// kStillNoise standard deviations of the images' noise. Of that by the quarter of the images that
/// is noisy least, as light that changes is no noise. `median`: of these images, or of more of the
/// same place.
int still_limit(const std::vector<const std::vector<uint8_t>*>& images,
                const std::vector<uint8_t>& median);

}  // namespace tessera
