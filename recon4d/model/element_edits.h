// Edits of the elements of a set on any backend: elements are kept, taken, appended, selected by
// validity, sorted into blocks of one SH degree and padded to one degree again. Only a TrainState
// has sets with blocks; a model that leaves it is padded.
#pragma once
#include <vector>

#include "recon4d/model/gaussian_set.h"

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

// Density control and relocation need sets whose elements are alike: degrees are decided when
// growth has ended.

/// SH degree of each element in storage order, [N].
std::vector<uint8_t> sh_degrees(const GaussianSet& set);

/// Element n gets the degree degrees[n]: higher bands are dropped, in all levels of time, and
/// elements are sorted, stably, into blocks. Moments and statistics move along; the anchor is
/// forgotten. Returns the element that each element was, [N]. Errors: std::logic_error: a degree
/// above the element's own.
std::vector<int64_t> set_sh_degrees(Backend& backend, const std::vector<uint8_t>& degrees,
                                    GaussianSet& set, SetStatistics& statistics);

/// The elements `elements`, ascending, are left, with their moments and statistics. Errors:
/// std::logic_error where they do not ascend or there is no such element.
void keep_elements(Backend& backend, const std::vector<int64_t>& elements, GaussianSet& set,
                   SetStatistics& statistics);

/// Of `count` elements those that are not among `elements`, which ascend; ascending.
std::vector<int64_t> elements_but(int64_t count, const std::vector<int64_t>& elements);

/// The elements `elements`, ascending, as a set of their own, values alone, where the backend
/// works.
GaussianSet taken_elements(Backend& backend, const GaussianSet& set,
                           const std::vector<int64_t>& elements);

/// Adds the elements of `from`, a set of the same form, K and L in the same memory, with their
/// statistics. They stand behind those of their degree, and their moments are 0.
/// Returns the element that each element was, [N]: of `to`, or, from to's N on, of `from`.
std::vector<int64_t> append_elements(Backend& backend, const GaussianSet& from,
                                     const SetStatistics& from_statistics, GaussianSet& to,
                                     SetStatistics& statistics);

/// The same Gaussians in elements that are alike, K coefficients each: bands that an element does
/// not have are zeros, in the moments too. Of a set in the host's memory; the order of elements
/// stays.
GaussianSet padded(const GaussianSet& set);

/// Whether every stored value of Gaussian n is finite and its quaternions are rotations.
bool is_valid_element(const GaussianSpans<const float>& set, int64_t n);
/// Indices of the sound Gaussians, ascending.
std::vector<int64_t> valid_elements(const GaussianSet& set);
/// The Gaussians at `elements`, in that order, without moments.
GaussianSet select_elements(const GaussianSet& set, const std::vector<int64_t>& elements);

}  // namespace tessera
