// Sets whose rows differ in SH degree, made from sets of uniform rows, and back. The functions of
// the trainer (recon4d/model/element_edits.h) are compared with them.
#pragma once
#include <algorithm>

#include "tests/support/test_scene.h"

namespace tessera::testing {

/// A degree 0 … 3 for each of `count` rows, all of them there.
inline std::vector<uint8_t> some_degrees(int64_t count, uint64_t seed) {
  Random random(seed);
  std::vector<uint8_t> degrees(static_cast<size_t>(count));
  for (size_t n = 0; n < degrees.size(); ++n)
    degrees[n] = uint8_t(n < 4 ? n : uint64_t(random.below(4)));
  return degrees;
}

inline ShBlocks blocks_of(const std::vector<uint8_t>& degrees) {
  ShBlocks blocks;
  for (const uint8_t degree : degrees) ++blocks.elements[degree];
  return blocks;
}

/// The rows that stand in the blocks, in their order.
inline std::vector<int64_t> block_order(const std::vector<uint8_t>& degrees) {
  std::vector<int64_t> order;
  for (const int degree : {3, 1, 2, 0})
    for (size_t n = 0; n < degrees.size(); ++n)
      if (degrees[n] == degree) order.push_back(int64_t(n));
  return order;
}

/// SH degree of each row of the blocks.
inline std::vector<int> degrees_in(const ShBlocks& blocks) {
  std::vector<int> degrees;
  for (const int degree : {3, 1, 2, 0})
    degrees.insert(degrees.end(), size_t(blocks.elements[degree]), degree);
  return degrees;
}

/// Calls visit(colours with all bands, colours in blocks, scalars) for each row and level; both are
/// offsets into the group.
template <class Visit>
void for_each_colour(const ShBlocks& blocks, int coefficients, int levels, Visit&& visit) {
  int64_t wide = 0, narrow = 0;
  for (const int degree : degrees_in(blocks))
    for (int level = 0; level < levels; ++level) {
      const int scalars = 3 * (degree + 1) * (degree + 1);
      visit(wide, narrow, scalars);
      wide += 3 * coefficients;
      narrow += scalars;
    }
}

/// Rows that are alike and in the order of the blocks, without the bands that they do not have.
template <class Real>
TestGaussians<Real> in_blocks(const TestGaussians<Real>& set, const ShBlocks& blocks) {
  TestGaussians<Real> out(set.form, set.count, set.coefficients, set.time_levels, blocks);
  for (int g = 0; g < kGroupCount; ++g) {
    if (g != kSh && g != kShTime) {
      out.group[g] = set.group[g];
      continue;
    }
    if (set.group[g].empty()) continue;
    for_each_colour(blocks, set.coefficients, g == kSh ? 1 : set.time_levels,
                    [&](int64_t wide, int64_t narrow, int scalars) {
                      std::copy_n(&set.group[g][size_t(wide)], scalars,
                                  &out.group[g][size_t(narrow)]);
                    });
  }
  out.filter_size = set.filter_size;
  return out;
}

/// Rows that are alike, with zeros for the bands that the blocks do not have.
template <class Real>
TestGaussians<Real> held(const TestGaussians<Real>& set, const ShBlocks& blocks) {
  TestGaussians<Real> out = set;
  for (const Group g : {kSh, kShTime})
    if (!set.group[g].empty())
      for_each_colour(blocks, set.coefficients, g == kSh ? 1 : set.time_levels,
                      [&](int64_t wide, int64_t, int scalars) {
                        std::fill_n(out.group[g].begin() + wide + scalars,
                                    3 * set.coefficients - scalars, Real(0));
                      });
  return out;
}

}  // namespace tessera::testing
