// What: degrees turned into moves of elements; sets joined block by block; elements padded.
// Not: arithmetic on Gaussians: elements are copied as they are.
#include "recon4d/model/sh_blocks.h"

#include <algorithm>
#include <array>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/model/element_moves.h"

namespace tessera {
namespace {

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

}  // namespace tessera
