// What: the box of the means, a code each, a stable sort.
// Not: the code (kernels/math/locality.h).
#include "static3d/transform/morton_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/math/locality.h"

namespace tessera {

std::vector<int64_t> morton_order(const GaussianSpans<const float>& set) {
  LocalityBox box{{INFINITY, INFINITY, INFINITY, 0}, {-INFINITY, -INFINITY, -INFINITY, 0}};
  for (int64_t n = 0; n < set.count; ++n)
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], set.at(kMean, n)[k]);
      box.high[k] = std::max(box.high[k], set.at(kMean, n)[k]);
    }
  std::vector<uint64_t> codes(size_t(set.count));
  for (int64_t n = 0; n < set.count; ++n) {
    const float* const mean = set.at(kMean, n);
    codes[size_t(n)] = morton_code(box, mean[0], mean[1], mean[2]);
  }
  std::vector<int64_t> order(size_t(set.count));
  std::iota(order.begin(), order.end(), int64_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return codes[size_t(a)] < codes[size_t(b)]; });
  return order;
}

}  // namespace tessera
