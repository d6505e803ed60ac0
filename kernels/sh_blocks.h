// Blocks of a set: elements of one SH degree stand together, and every stage takes a block as a set
// of its own. The degrees are assigned in recon4d/model/element_edits.h.
#pragma once
#include <cstdint>

#include "kernels/math/spherical_harmonics.h"

namespace tessera {

/// Elements of one degree.
struct ShBlock {
  int coefficients = 0;          // K of each of its elements
  int64_t first = 0, count = 0;  // elements
  int64_t sh_first = 0;          // coefficients of the elements before it
};

/// Where the blocks of a set are. The order of degrees is that of storage: with it elements of 48
/// and of 12 scalars begin at multiples of 16 bytes, whatever the counts, and nothing is padded.
struct ShBlocks {
  static constexpr int kOrder[kMaxShDegree + 1] = {3, 1, 2, 0};

  /// By degree. All 0: every element has as many coefficients as the set states.
  int64_t elements[kMaxShDegree + 1] = {};

  TESSERA_HD bool mixed() const { return count() > 0; }
  TESSERA_HD int64_t count() const {
    int64_t sum = 0;
    for (const int64_t some : elements) sum += some;
    return sum;
  }
  /// Of all elements together.
  int64_t coefficients() const {
    int64_t sum = 0;
    for (int degree = 0; degree <= kMaxShDegree; ++degree)
      sum += elements[degree] * sh_coefficients(degree);
    return sum;
  }
  bool operator==(const ShBlocks&) const = default;
};

/// Calls visit(block) for the blocks that have elements, in storage order; for one of all `count`
/// elements, of `coefficients` each, where they are alike.
template <class Visit>
void for_each_block(const ShBlocks& blocks, int64_t count, int coefficients, Visit&& visit) {
  if (!blocks.mixed()) {
    if (count > 0) visit(ShBlock{coefficients, 0, count, 0});
    return;
  }
  ShBlock block;
  for (const int degree : ShBlocks::kOrder) {
    block.coefficients = sh_coefficients(degree);
    block.count = blocks.elements[degree];
    if (block.count > 0) visit(block);
    block.first += block.count;
    block.sh_first += block.count * block.coefficients;
  }
}

}  // namespace tessera
