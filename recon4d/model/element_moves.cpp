// What: every buffer of a set and its statistics, gathered move by move.
// Not: a rule about elements or degrees.
#include "recon4d/model/element_moves.h"

#include <algorithm>
#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// The elements `index` of the moves as elements of one coefficient each, RGB: the first `wanted`
/// of `stored`, in each of `levels`.
Buffer<int64_t> coefficient_elements(Memory& memory, const Buffer<int64_t>& index, int stored,
                                     int wanted, int levels) {
  Buffer<int64_t> elements, out(index.size() * levels * wanted);
  elements.copy_from(index);
  int64_t position = 0;
  for (const int64_t element : elements)
    for (int64_t level = element * levels; level < (element + 1) * levels; ++level)
      for (int k = 0; k < wanted; ++k) out[position++] = level * stored + k;
  Buffer<int64_t> copy(memory);
  copy.copy_from(out);
  return copy;
}

/// A buffer of a group in its next state. `scalars`: of an element, or, of colours, by coefficient.
class Gatherer {
 public:
  Gatherer(Backend& backend, const std::vector<ElementMove>& moves, int scalars, bool colours)
      : backend_(backend), moves_(moves), scalars_(scalars), colours_(colours) {
    for (const ElementMove& move : moves_) {
      size_ += move.index.size() * width(move.coefficients);
      shorter_.emplace_back(backend.memory());
      if (colours && move.coefficients < move.from.coefficients)
        shorter_.back() = coefficient_elements(backend.memory(), move.index, move.from.coefficients,
                                               move.coefficients, scalars / 3);
    }
  }

  void operator()(Buffer<float>& buffer) const {
    {
      Buffer<float> to = gathered(buffer);
      buffer = std::move(to);  // swaps: `to` frees the old elements at the end of this block
    }
    // the old elements of a large group are not kept beside the new ones of the next
    constexpr int64_t kLarge = int64_t{1} << 22;
    if (buffer.size() > kLarge) backend_.memory().trim();
  }

 private:
  /// The elements of `from` after the moves.
  Buffer<float> gathered(const Buffer<float>& from) const {
    Buffer<float> to(size_, backend_.memory());
    int64_t position = 0;
    for (size_t i = 0; i < moves_.size(); ++i) {
      const ElementMove& move = moves_[i];
      const int stored = width(move.from.coefficients);
      const Span<const float> part =
          part_of(from.span(), (colours_ ? move.from.sh_first : move.from.first) * scalars_,
                  move.from.count * stored);
      const bool whole = shorter_[i].empty();
      const Span<const int64_t> index = whole ? move.index.span() : shorter_[i].span();
      const int width = whole ? stored : 3;
      backend_.gather_elements(part, index, width, index.size,
                               part_of(to.span(), position, index.size * width));
      position += index.size * width;
    }
    return to;
  }

  int width(int coefficients) const { return colours_ ? coefficients * scalars_ : scalars_; }

  Backend& backend_;
  const std::vector<ElementMove>& moves_;
  int scalars_;
  bool colours_;
  int64_t size_ = 0;
  std::vector<Buffer<int64_t>> shorter_;  // by move, where coefficients are dropped
};

/// The layout that the moves lead to.
ShBlocks next_blocks(const std::vector<ElementMove>& moves, const GaussianSet& set) {
  ShBlocks blocks;
  for (const ElementMove& move : moves)
    blocks.elements[sh_degree_of(move.coefficients)] += move.index.size();
  const bool alike = std::all_of(moves.begin(), moves.end(), [&](const ElementMove& move) {
    return move.coefficients == set.coefficients();
  });
  return alike ? ShBlocks{} : blocks;
}

}  // namespace

void move_elements(Backend& backend, const std::vector<ElementMove>& moves, GaussianSet& set,
                   SetStatistics& statistics) {
  int64_t count = 0;
  for (const ElementMove& move : moves) count += move.index.size();
  const ShBlocks blocks = next_blocks(moves, set);
  const bool has_moments = set.has_moments();
  for (int g = 0; g < set.groups(); ++g) {
    const bool colours = g == kSh || g == kShTime;
    const int scalars = group_width(Group(g), 1, set.form(), set.time_levels());
    const Gatherer gather(backend, moves, scalars, colours);
    ParameterGroup& group = set.group(Group(g));
    gather(group.value);
    if (!has_moments) continue;
    if (moment_buffers(Group(g)) > 0) gather(group.moment1);
    if (moment_buffers(Group(g)) > 1) gather(group.moment2);
  }
  set.set_count(count, blocks);
  const Gatherer gather(backend, moves, 1, false);
  for (Buffer<float>* values :
       {&statistics.gradient_sum, &statistics.count, &statistics.filter_size})
    if (!values->empty()) gather(*values);
}

}  // namespace tessera
