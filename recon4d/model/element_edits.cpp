// Edits of elements as gathers of every buffer of a set and its statistics, and as copies that join
// two sets block by block. Elements are copied as they are.
#include "recon4d/model/element_edits.h"

#include <algorithm>
#include <array>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/load_gaussian.h"

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

Buffer<int64_t> in_memory(Memory& memory, const std::vector<int64_t>& elements) {
  Buffer<int64_t> host(int64_t(elements.size()));
  Buffer<int64_t> copy(memory);
  std::copy(elements.begin(), elements.end(), host.begin());
  copy.copy_from(host);
  return copy;
}

/// By degree; no elements of one that is not there.
std::array<ShBlock, kMaxShDegree + 1> blocks_by_degree(const GaussianSet& set) {
  std::array<ShBlock, kMaxShDegree + 1> blocks{};
  for_each_block(
      set, [&](const ShBlock& block) { blocks[size_t(sh_degree_of(block.coefficients))] = block; });
  return blocks;
}

/// Two sets element by element: of each degree the elements of `to`, then those of `from`.
class Joiner {
 public:
  Joiner(const GaussianSet& from, const GaussianSet& to)
      : memory_(to.memory()), from_(blocks_by_degree(from)), to_(blocks_by_degree(to)) {}

  /// `scalars`: of an element, or, of colours, by coefficient. Without `added` what is added is
  /// zeros.
  void join(Backend& backend, int scalars, bool colours, const Buffer<float>* added,
            Buffer<float>& buffer) const {
    const auto first_of = [&](const ShBlock& block) {
      return (colours ? block.sh_first : block.first) * scalars;
    };
    const auto size_of = [&](const ShBlock& block) {
      return block.count * scalars * (colours ? block.coefficients : 1);
    };
    int64_t size = 0, position = 0;
    for (const auto* blocks : {&from_, &to_})
      for (const ShBlock& block : *blocks) size += size_of(block);
    Buffer<float> joined(size, memory_);
    const auto append = [&](const Buffer<float>* elements, const ShBlock& block) {
      const Span<float> place = part_of(joined.span(), position, size_of(block));
      position += place.size;
      if (place.empty()) return;
      if (elements == nullptr) return backend.fill_zero(place);
      memory_.copy(place.data, part_of(elements->span(), first_of(block), place.size).data,
                   sizeof(float) * size_t(place.size));
    };
    for (const int degree : ShBlocks::kOrder) {
      append(&buffer, to_[size_t(degree)]);
      append(added, from_[size_t(degree)]);
    }
    buffer = std::move(joined);
  }

  /// The elements of both, those of `from` numbered on.
  std::vector<int64_t> order(int64_t count) const {
    std::vector<int64_t> elements;
    for (const int degree : ShBlocks::kOrder) {
      const ShBlock &to = to_[size_t(degree)], &from = from_[size_t(degree)];
      for (int64_t n = 0; n < to.count; ++n) elements.push_back(to.first + n);
      for (int64_t n = 0; n < from.count; ++n) elements.push_back(count + from.first + n);
    }
    return elements;
  }

  ShBlocks blocks() const {
    ShBlocks sum;
    for (size_t degree = 0; degree <= kMaxShDegree; ++degree)
      sum.elements[degree] = to_[degree].count + from_[degree].count;
    return sum;
  }

 private:
  Memory& memory_;
  std::array<ShBlock, kMaxShDegree + 1> from_, to_;
};

/// Statistics of joined sets; `before`: elements of the one that grew.
void join_statistics(Backend& backend, const Joiner& joiner, const SetStatistics& from,
                     int64_t before, SetStatistics& to) {
  joiner.join(backend, 1, false, &from.gradient_sum, to.gradient_sum);
  joiner.join(backend, 1, false, &from.count, to.count);
  if ((before == 0 || !to.filter_size.empty()) && !from.filter_size.empty())
    joiner.join(backend, 1, false, &from.filter_size, to.filter_size);
  else
    to.filter_size.resize(0);  // to be measured
}

/// Colours of a set, `levels` of each element, with as many coefficients in every element.
Buffer<float> padded_elements(const Buffer<float>& from, const GaussianSet& set, int64_t levels) {
  const int64_t wide = 3 * int64_t{set.coefficients()};
  Buffer<float> to(set.count() * levels * wide);
  std::fill(to.begin(), to.end(), 0.0f);
  for_each_block(set, [&](const ShBlock& block) {
    const int64_t scalars = 3 * int64_t{block.coefficients};
    const float* element = from.data() + 3 * levels * block.sh_first;
    for (int64_t i = levels * block.first; i < levels * (block.first + block.count); ++i) {
      std::copy_n(element, scalars, to.data() + i * wide);
      element += scalars;
    }
  });
  return to;
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

std::vector<uint8_t> sh_degrees(const GaussianSet& set) {
  std::vector<uint8_t> degrees;
  for_each_block(set, [&](const ShBlock& block) {
    degrees.insert(degrees.end(), size_t(block.count), uint8_t(sh_degree_of(block.coefficients)));
  });
  return degrees;
}

std::vector<int64_t> set_sh_degrees(Backend& backend, const std::vector<uint8_t>& degrees,
                                    GaussianSet& set, SetStatistics& statistics) {
  check(int64_t(degrees.size()) == set.count(), "set_sh_degrees: one degree an element");
  check(sh_coefficients(sh_degree_of(set.coefficients())) == set.coefficients(),
        "set_sh_degrees: of a set whose SH are no whole bands");
  std::vector<ElementMove> moves;
  std::vector<int64_t> order;
  for (const int degree : ShBlocks::kOrder)
    for_each_block(set, [&](const ShBlock& block) {
      std::vector<int64_t> elements;
      for (int64_t n = 0; n < block.count; ++n) {
        const int wanted = degrees[size_t(block.first + n)];
        check(sh_coefficients(wanted) <= block.coefficients,
              "set_sh_degrees: a degree above the element's own");
        if (wanted != degree) continue;
        elements.push_back(n);
        order.push_back(block.first + n);
      }
      if (!elements.empty())
        moves.push_back({block, sh_coefficients(degree), in_memory(backend.memory(), elements)});
    });
  move_elements(backend, moves, set, statistics);
  return order;
}

void keep_elements(Backend& backend, const std::vector<int64_t>& elements, GaussianSet& set,
                   SetStatistics& statistics) {
  for (size_t i = 0; i < elements.size(); ++i)
    check(
        elements[i] >= 0 && elements[i] < set.count() && (i == 0 || elements[i - 1] < elements[i]),
        "keep_elements: elements that ascend");
  std::vector<ElementMove> moves;
  auto next = elements.begin();
  for_each_block(set, [&](const ShBlock& block) {
    std::vector<int64_t> of_block;
    for (; next != elements.end() && *next < block.first + block.count; ++next)
      of_block.push_back(*next - block.first);
    moves.push_back({block, block.coefficients, in_memory(backend.memory(), of_block)});
  });
  move_elements(backend, moves, set, statistics);
}

std::vector<int64_t> elements_but(int64_t count, const std::vector<int64_t>& elements) {
  std::vector<int64_t> others;
  auto next = elements.begin();
  for (int64_t n = 0; n < count; ++n)
    if (next != elements.end() && *next == n)
      ++next;
    else
      others.push_back(n);
  return others;
}

GaussianSet taken_elements(Backend& backend, const GaussianSet& set,
                           const std::vector<int64_t>& elements) {
  GaussianSet part = set.clone_values(backend.memory());
  SetStatistics none(backend.memory());
  keep_elements(backend, elements, part, none);
  return part;
}

std::vector<int64_t> append_elements(Backend& backend, const GaussianSet& from,
                                     const SetStatistics& from_statistics, GaussianSet& to,
                                     SetStatistics& statistics) {
  check(from.form() == to.form() && from.coefficients() == to.coefficients() &&
            from.time_levels() == to.time_levels(),
        "append_elements: sets of two layouts");
  const Joiner joiner(from, to);
  const int64_t before = to.count(), count = before + from.count();
  const bool has_moments = to.has_moments();
  for (int g = 0; g < to.groups(); ++g) {
    const bool colours = g == kSh || g == kShTime;
    const int scalars = group_width(Group(g), 1, to.form(), to.time_levels());
    ParameterGroup& group = to.group(Group(g));
    joiner.join(backend, scalars, colours, &from.group(Group(g)).value, group.value);
    if (!has_moments) continue;
    const int buffers = moment_buffers(Group(g));
    if (buffers > 0) joiner.join(backend, scalars, colours, nullptr, group.moment1);
    if (buffers > 1) joiner.join(backend, scalars, colours, nullptr, group.moment2);
  }
  to.set_count(count, joiner.blocks());
  join_statistics(backend, joiner, from_statistics, before, statistics);
  return joiner.order(before);
}

GaussianSet padded(const GaussianSet& set) {
  check(&set.memory() == &host_memory(), "padded: of a set on the host");
  GaussianSet out = set.like();
  out.resize(set.count());
  for (int g = 0; g < set.groups(); ++g)
    for (auto member :
         {&ParameterGroup::value, &ParameterGroup::moment1, &ParameterGroup::moment2}) {
      const Buffer<float>& from = set.group(Group(g)).*member;
      Buffer<float>& to = out.group(Group(g)).*member;
      if (g != kSh && g != kShTime)
        to.copy_from(from);
      else if (!from.empty())
        to =
            padded_elements(from, set, group_width(Group(g), 1, set.form(), set.time_levels()) / 3);
    }
  return out;
}

bool is_valid_element(const GaussianSpans<const float>& set, int64_t n) {
  for (int g = 0; g < group_count(set.form); ++g) {
    const float* const values = set.at(Group(g), n);
    for (int i = 0; i < set.width(Group(g)); ++i)
      if (!std::isfinite(values[i])) return false;
  }
  const auto has_length = [&](Group group) {
    const Vec4<float> q = load4(set.at(group, n));
    return dot(q, q) >= kMinQuaternionNorm2<float>;
  };
  return has_length(kRotation) && (set.form != SetForm::kPair || has_length(kRotationRight));
}

std::vector<int64_t> valid_elements(const GaussianSet& set) {
  const GaussianSpans<const float> values = set.values();
  std::vector<int64_t> elements;
  elements.reserve(size_t(set.count()));
  for (int64_t n = 0; n < set.count(); ++n)
    if (is_valid_element(values, n)) elements.push_back(n);
  return elements;
}

GaussianSet select_elements(const GaussianSet& set, const std::vector<int64_t>& elements) {
  GaussianSet selected = set.like();
  selected.resize(int64_t(elements.size()));
  const GaussianSpans<const float> from = set.values();
  const GaussianSpans<float> to = selected.values();
  for (int g = 0; g < set.groups(); ++g)
    for (size_t i = 0; i < elements.size(); ++i)
      std::copy_n(from.at(Group(g), elements[i]), set.width(Group(g)), to.at(Group(g), int64_t(i)));
  return selected;
}

}  // namespace tessera
