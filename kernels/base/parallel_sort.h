// A sort on all cores.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernels/base/parallel.h"

namespace tessera {

/// In ascending order, as std::sort leaves them where no two are equal.
template <class T>
void parallel_sort(std::vector<T>& values) {
  constexpr int64_t kGrain = 1 << 14;  // that one thread sorts; pairs of ranges are merged after
  const auto count = int64_t(values.size());
  parallel_for(count, kGrain, [&](int64_t begin, int64_t end) {
    std::sort(values.begin() + begin, values.begin() + end);
  });
  for (int64_t sorted = kGrain; sorted < count; sorted *= 2)
    parallel_for(count, 2 * sorted, [&](int64_t begin, int64_t end) {
      if (begin + sorted < end)
        std::inplace_merge(values.begin() + begin, values.begin() + begin + sorted,
                           values.begin() + end);
    });
}

}  // namespace tessera
