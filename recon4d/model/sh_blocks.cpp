// What: degrees turned into moves of rows; sets joined block by block; rows padded.
// Not: arithmetic on Gaussians: rows are copied as they are.
#include "recon4d/model/sh_blocks.h"

#include <algorithm>
#include <array>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/model/row_moves.h"

namespace tessera {
namespace {

Buffer<int64_t> in_memory(Memory& memory, const std::vector<int64_t>& rows) {
  Buffer<int64_t> host(int64_t(rows.size())), there(memory);
  std::copy(rows.begin(), rows.end(), host.begin());
  there.copy_from(host);
  return there;
}

/// By degree; no rows of one that is not there.
std::array<ShBlock, kMaxShDegree + 1> blocks_by_degree(const GaussianSet& set) {
  std::array<ShBlock, kMaxShDegree + 1> blocks{};
  for_each_block(
      set, [&](const ShBlock& block) { blocks[size_t(sh_degree_of(block.coefficients))] = block; });
  return blocks;
}

/// Two sets row by row: of each degree the rows of `to`, then those of `from`.
class Joiner {
 public:
  Joiner(const GaussianSet& from, const GaussianSet& to)
      : memory_(to.memory()), from_(blocks_by_degree(from)), to_(blocks_by_degree(to)) {}

  /// `scalars`: of a row, or, of colours, by coefficient. Without `added` what is added is zeros.
  void join(Backend& backend, int scalars, bool colours, const Buffer<float>* added,
            Buffer<float>& buffer) const {
    const auto first_of = [&](const ShBlock& block) {
      return (colours ? block.sh_first : block.first) * scalars;
    };
    const auto size_of = [&](const ShBlock& block) {
      return block.count * scalars * (colours ? block.coefficients : 1);
    };
    int64_t size = 0, at = 0;
    for (const auto* blocks : {&from_, &to_})
      for (const ShBlock& block : *blocks) size += size_of(block);
    Buffer<float> joined(size, memory_);
    const auto append = [&](const Buffer<float>* rows, const ShBlock& block) {
      const Span<float> place = part_of(joined.span(), at, size_of(block));
      at += place.size;
      if (place.empty()) return;
      if (rows == nullptr) return backend.fill_zero(place);
      memory_.copy(place.data, part_of(rows->span(), first_of(block), place.size).data,
                   sizeof(float) * size_t(place.size));
    };
    for (const int degree : ShBlocks::kOrder)
      append(&buffer, to_[size_t(degree)]), append(added, from_[size_t(degree)]);
    buffer = std::move(joined);
  }

  /// The rows of both, those of `from` numbered on.
  std::vector<int64_t> order(int64_t count) const {
    std::vector<int64_t> rows;
    for (const int degree : ShBlocks::kOrder) {
      const ShBlock &to = to_[size_t(degree)], &from = from_[size_t(degree)];
      for (int64_t n = 0; n < to.count; ++n) rows.push_back(to.first + n);
      for (int64_t n = 0; n < from.count; ++n) rows.push_back(count + from.first + n);
    }
    return rows;
  }

  ShBlocks blocks() const {
    ShBlocks sum;
    for (size_t degree = 0; degree <= kMaxShDegree; ++degree)
      sum.rows[degree] = to_[degree].count + from_[degree].count;
    return sum;
  }

 private:
  Memory& memory_;
  std::array<ShBlock, kMaxShDegree + 1> from_, to_;
};

/// Statistics of joined sets; `before`: rows of the one that grew.
void join_statistics(Backend& backend, const Joiner& joiner, const SetStatistics& from,
                     int64_t before, SetStatistics& to) {
  joiner.join(backend, 1, false, &from.gradient_sum, to.gradient_sum);
  joiner.join(backend, 1, false, &from.count, to.count);
  if ((before == 0 || !to.filter_size.empty()) && !from.filter_size.empty())
    joiner.join(backend, 1, false, &from.filter_size, to.filter_size);
  else
    to.filter_size.resize(0);  // to be measured
}

/// Colours of a set, `levels` of each row, with as many coefficients in every row.
Buffer<float> padded_rows(const Buffer<float>& from, const GaussianSet& set, int64_t levels) {
  const int64_t wide = 3 * int64_t{set.coefficients()};
  Buffer<float> to(set.count() * levels * wide);
  std::fill(to.begin(), to.end(), 0.0f);
  for_each_block(set, [&](const ShBlock& block) {
    const int64_t scalars = 3 * int64_t{block.coefficients};
    const float* row = from.data() + 3 * levels * block.sh_first;
    for (int64_t i = levels * block.first; i < levels * (block.first + block.count); ++i)
      std::copy_n(row, scalars, to.data() + i * wide), row += scalars;
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
  check(int64_t(degrees.size()) == set.count(), "set_sh_degrees: one degree a row");
  check(sh_coefficients(sh_degree_of(set.coefficients())) == set.coefficients(),
        "set_sh_degrees: of a set whose SH are no whole bands");
  std::vector<RowMove> moves;
  std::vector<int64_t> order;
  for (const int degree : ShBlocks::kOrder)
    for_each_block(set, [&](const ShBlock& block) {
      std::vector<int64_t> rows;
      for (int64_t n = 0; n < block.count; ++n) {
        const int wanted = degrees[size_t(block.first + n)];
        check(sh_coefficients(wanted) <= block.coefficients,
              "set_sh_degrees: a degree above the row's own");
        if (wanted != degree) continue;
        rows.push_back(n), order.push_back(block.first + n);
      }
      if (!rows.empty())
        moves.push_back({block, sh_coefficients(degree), in_memory(backend.memory(), rows)});
    });
  move_rows(backend, moves, set, statistics);
  return order;
}

void keep_rows(Backend& backend, const std::vector<int64_t>& rows, GaussianSet& set,
               SetStatistics& statistics) {
  for (size_t i = 0; i < rows.size(); ++i)
    check(rows[i] >= 0 && rows[i] < set.count() && (i == 0 || rows[i - 1] < rows[i]),
          "keep_rows: rows that ascend");
  std::vector<RowMove> moves;
  auto next = rows.begin();
  for_each_block(set, [&](const ShBlock& block) {
    std::vector<int64_t> of_block;
    for (; next != rows.end() && *next < block.first + block.count; ++next)
      of_block.push_back(*next - block.first);
    moves.push_back({block, block.coefficients, in_memory(backend.memory(), of_block)});
  });
  move_rows(backend, moves, set, statistics);
}

std::vector<int64_t> append_rows(Backend& backend, const GaussianSet& from,
                                 const SetStatistics& from_statistics, GaussianSet& to,
                                 SetStatistics& statistics) {
  check(from.form() == to.form() && from.coefficients() == to.coefficients() &&
            from.time_levels() == to.time_levels(),
        "append_rows: sets of two layouts");
  const Joiner joiner(from, to);
  const int64_t before = to.count(), count = before + from.count();
  const bool has_moments = to.has_moments();
  for (int g = 0; g < to.groups(); ++g) {
    const bool colours = g == kSh || g == kShTime;
    const int scalars = group_width(Group(g), 1, to.form(), to.time_levels());
    ParameterGroup& group = to.group(Group(g));
    joiner.join(backend, scalars, colours, &from.group(Group(g)).value, group.value);
    if (!has_moments) continue;
    joiner.join(backend, scalars, colours, nullptr, group.moment1);
    joiner.join(backend, scalars, colours, nullptr, group.moment2);
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
        to = padded_rows(from, set, group_width(Group(g), 1, set.form(), set.time_levels()) / 3);
    }
  return out;
}

}  // namespace tessera
