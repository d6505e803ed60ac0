// The tree is made level by level, the parts of a level on all cores. The share of entries of a
// part is that of its sum of squared distances, which is the optimum of many entries in many
// dimensions.
#include "static3d/transform/vector_palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int kSplitIterations = 4, kRefinements = 3;
constexpr int64_t kNearEntries = 64;  // that a vector is compared with after the tree is made

struct Rows {
  const std::vector<float>& values;  // [n, width]
  int width;
  const float* operator[](int64_t n) const { return values.data() + n * width; }
  int64_t count() const { return int64_t(values.size()) / width; }
};

/// Vectors order[begin, end), which get `entries` entries.
struct Part {
  int64_t begin, end, entries;
};

/// Sums over some vectors.
struct VectorSums {
  std::vector<double> sum, squares;  // of each component
  int64_t count = 0;

  explicit VectorSums(int width) : sum(size_t(width)), squares(size_t(width)) {}
  void add(const float* row) {
    for (size_t k = 0; k < sum.size(); ++k) {
      sum[k] += double(row[k]);
      squares[k] += double(row[k]) * double(row[k]);
    }
    ++count;
  }
  double mean(size_t k) const { return sum[k] / double(count); }
  /// Sum of squared distances to the mean, of one component.
  double spread(size_t k) const { return std::max(0.0, squares[k] - sum[k] * mean(k)); }
  double spread() const {
    double total = 0;
    for (size_t k = 0; k < sum.size(); ++k) total += spread(k);
    return total;
  }
};

/// A plane between two halves: `normal` · x > `offset` on the second side.
struct Plane {
  std::vector<float> normal;
  double offset = 0;

  bool is_beyond(const float* row) const {
    std::array<float, 4> sums{};
    size_t k = 0;
    for (; k + 4 <= normal.size(); k += 4)
      for (size_t lane = 0; lane < 4; ++lane) sums[lane] += normal[k + lane] * row[k + lane];
    for (; k < normal.size(); ++k) sums[0] += normal[k] * row[k];
    return double(sums[0]) + sums[1] + sums[2] + sums[3] > offset;
  }
};

/// Through the mean, across the component that varies most.
Plane first_plane(const VectorSums& all) {
  Plane plane;
  plane.normal.assign(all.sum.size(), 0);
  size_t widest = 0;
  for (size_t k = 1; k < all.sum.size(); ++k)
    if (all.spread(k) > all.spread(widest)) widest = k;
  plane.normal[widest] = 1;
  plane.offset = all.mean(widest);
  return plane;
}

/// Half way between the means of two halves.
Plane middle_plane(const std::array<VectorSums, 2>& halves) {
  Plane plane;
  for (size_t k = 0; k < halves[0].sum.size(); ++k) {
    const double a = halves[0].mean(k), b = halves[1].mean(k);
    plane.normal.push_back(float(b - a));
    plane.offset += double(float(b - a)) * 0.5 * (a + b);
  }
  return plane;
}

/// Two parts by 2-means, or one of a single entry where all vectors are equal.
std::vector<Part> split_part(const Rows& rows, std::vector<int64_t>& order, const Part& part) {
  const int64_t size = part.end - part.begin;
  if (part.entries <= 1 || size <= 1) return {{part.begin, part.end, 1}};
  VectorSums all(rows.width);
  for (int64_t i = part.begin; i < part.end; ++i) all.add(rows[order[size_t(i)]]);
  Plane plane = first_plane(all);
  std::array<VectorSums, 2> halves{VectorSums(rows.width), VectorSums(rows.width)};
  for (int iteration = 0;; ++iteration) {
    halves = {VectorSums(rows.width), VectorSums(rows.width)};
    for (int64_t i = part.begin; i < part.end; ++i) {
      const float* const row = rows[order[size_t(i)]];
      halves[plane.is_beyond(row) ? 1 : 0].add(row);
    }
    if (halves[0].count == 0 || halves[1].count == 0) return {{part.begin, part.end, 1}};
    if (iteration == kSplitIterations) break;
    plane = middle_plane(halves);
  }
  std::stable_partition(order.begin() + part.begin, order.begin() + part.end,
                        [&](int64_t n) { return !plane.is_beyond(rows[n]); });
  const double spread = halves[0].spread() + halves[1].spread();
  const double share = spread > 0 ? halves[0].spread() / spread : 0.5;
  const int64_t first =
      std::clamp(std::llround(share * double(part.entries)),
                 static_cast<long long>(std::max<int64_t>(1, part.entries - halves[1].count)),
                 static_cast<long long>(std::min(halves[0].count, part.entries - 1)));
  const int64_t middle = part.begin + halves[0].count;
  return {{part.begin, middle, first}, {middle, part.end, part.entries - first}};
}

/// Parts of the vectors in the order of the tree, one for each entry.
std::vector<Part> leaves_of(const Rows& rows, std::vector<int64_t>& order, int64_t most) {
  std::vector<Part> parts{{0, rows.count(), std::min(most, rows.count())}};
  for (bool is_larger = true; is_larger;) {
    std::vector<std::vector<Part>> halves(parts.size());
    parallel_for(int64_t(parts.size()), 1, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i)
        halves[size_t(i)] = split_part(rows, order, parts[size_t(i)]);
    });
    std::vector<Part> next;
    for (const std::vector<Part>& pair : halves) next.insert(next.end(), pair.begin(), pair.end());
    is_larger = next.size() > parts.size();
    parts = std::move(next);
  }
  return parts;
}

/// Entries become the means of their vectors; those without vectors stay.
void move_entries(const Rows& rows, VectorPalette& palette) {
  std::vector<double> sums(palette.entries.size());
  std::vector<int64_t> counts(size_t(palette.count()));
  for (int64_t n = 0; n < rows.count(); ++n) {
    const int64_t label = palette.labels[size_t(n)];
    ++counts[size_t(label)];
    for (int k = 0; k < rows.width; ++k) sums[size_t(label * rows.width + k)] += double(rows[n][k]);
  }
  for (size_t i = 0; i < sums.size(); ++i)
    if (const int64_t count = counts[i / size_t(rows.width)]; count > 0)
      palette.entries[i] = float(sums[i] / double(count));
}

float squared_distance(const float* a, const float* b, int width) {
  std::array<float, 4> sums{};
  int k = 0;
  for (; k + 4 <= width; k += 4)
    for (int lane = 0; lane < 4; ++lane) {
      const float d = a[k + lane] - b[k + lane];
      sums[size_t(lane)] += d * d;
    }
  for (; k < width; ++k) sums[0] += (a[k] - b[k]) * (a[k] - b[k]);
  return sums[0] + sums[1] + sums[2] + sums[3];
}

/// The nearest of the entries of a block of the tree; blocks begin `shift` later.
void refine_labels(const Rows& rows, VectorPalette& palette, int64_t shift) {
  constexpr int64_t kGrain = 1024;
  parallel_for(rows.count(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      int32_t& label = palette.labels[size_t(n)];
      const int64_t block = (label + shift) / kNearEntries * kNearEntries - shift;
      const int64_t last = std::min(block + kNearEntries, palette.count());
      const auto distance = [&](int64_t entry) {
        return squared_distance(rows[n], palette.entries.data() + entry * rows.width, rows.width);
      };
      float least = distance(label);
      for (int64_t entry = std::max<int64_t>(block, 0); entry < last; ++entry)
        if (const float d = distance(entry); d < least) {
          least = d;
          label = int32_t(entry);
        }
    }
  });
}

}  // namespace

VectorPalette vector_palette(const std::vector<float>& vectors, int width, int64_t most) {
  check(width > 0 && vectors.size() % size_t(width) == 0 && most > 0, "vector_palette: shape");
  VectorPalette palette;
  palette.width = width;
  if (vectors.empty()) return palette;
  const Rows rows{vectors, width};
  std::vector<int64_t> order(size_t(rows.count()));
  std::iota(order.begin(), order.end(), int64_t{0});
  const std::vector<Part> leaves = leaves_of(rows, order, most);
  palette.labels.resize(order.size());
  palette.entries.resize(leaves.size() * size_t(width));
  for (size_t leaf = 0; leaf < leaves.size(); ++leaf)
    for (int64_t i = leaves[leaf].begin; i < leaves[leaf].end; ++i)
      palette.labels[size_t(order[size_t(i)])] = int32_t(leaf);
  move_entries(rows, palette);
  for (int i = 0; i < kRefinements; ++i) {
    refine_labels(rows, palette, i % 2 * kNearEntries / 2);
    move_entries(rows, palette);
  }
  return palette;
}

}  // namespace tessera
