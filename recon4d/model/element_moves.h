// What: elements of a set gathered block by block into its next state: a part of them, or another
//       order, or fewer SH coefficients.
// Not: the choice of elements (density.cpp, sh_blocks.cpp), nor growth: no element is taken twice.
#pragma once
#include <vector>

#include "recon4d/model/set_statistics.h"

namespace tessera {

/// Elements of a block that follow one another in the next state of a set.
struct ElementMove {
  ShBlock from;
  int coefficients;       // K of the elements in the next state, at most that of the block
  Buffer<int64_t> index;  // elements of the block, in the backend's memory
};

/// The elements of all moves become the set, with their moments and statistics; the anchor is
/// forgotten. Moves are in the order of storage: that of ShBlocks::kOrder, by `coefficients`.
void move_elements(Backend& backend, const std::vector<ElementMove>& moves, GaussianSet& set,
                   SetStatistics& statistics);

/// Calls visit(block) for the blocks of a set that have elements.
template <class Visit>
void for_each_block(const GaussianSet& set, Visit&& visit) {
  for_each_block(set.blocks(), set.count(), set.coefficients(), visit);
}

}  // namespace tessera
