// Medians of 8-bit images, value by value.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

constexpr size_t kMostOfByteMedian = 255;  // images, whose counts are bytes

/// The lower median of the images at each of their values. `images`: one to kMostOfByteMedian of
/// the same size.
std::vector<uint8_t> lower_medians(const std::vector<const std::vector<uint8_t>*>& images);

}  // namespace tessera
