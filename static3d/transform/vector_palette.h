// A palette of many vectors by a tree of 2-means: a part of the vectors is split in two until the
// palette is full, then a few iterations of Lloyd's algorithm compare each vector with entries
// that are near in the tree. There are no random numbers. Source: Y. Linde, A. Buzo and R. M. Gray,
// "An algorithm for vector quantizer design", IEEE Transactions on Communications 28 (1980).
#pragma once
#include <cstdint>
#include <vector>

namespace tessera {

struct VectorPalette {
  int width = 0;                // numbers in an entry
  std::vector<float> entries;   // [count, width], near ones of the tree beside each other
  std::vector<int32_t> labels;  // of each vector
  int64_t count() const { return width == 0 ? 0 : int64_t(entries.size()) / width; }
};

/// Of vectors [n, width] with finite numbers: at most `most` entries, fewer where vectors are
/// equal. With as many entries as vectors each vector has its own.
VectorPalette vector_palette(const std::vector<float>& vectors, int width, int64_t most);

}  // namespace tessera
