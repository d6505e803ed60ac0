// A codebook of 256 numbers for many scalars, by Lloyd's algorithm in one dimension on sorted
// values. Source: S. P. Lloyd, "Least squares quantization in PCM", IEEE Transactions on
// Information Theory 28 (1982).
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace tessera {

class ScalarCodebook {
 public:
  static constexpr int kEntries = 256;

  /// Of finite values. At most 256 different ones are kept exactly.
  explicit ScalarCodebook(std::vector<float> values);

  /// Ascending; entries that are not needed repeat the last one.
  const std::array<float, kEntries>& entries() const { return entries_; }
  /// Index of the nearest entry.
  uint8_t nearest(float value) const;

 private:
  std::array<float, kEntries> entries_{};
};

}  // namespace tessera
