// What: every group made longer, values copied, moments zeroed.
// Not: any change of what is there.
#include "recon4d/model/set_rows.h"

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {

void append_rows(GaussianSet& to, const GaussianSet& from) {
  check(to.form() == from.form() && to.coefficients() == from.coefficients() &&
            to.time_levels() == from.time_levels(),
        "append_rows: sets that store differently");
  const bool has_moments = to.has_moments();
  const int64_t count = to.count() + from.count();
  for (int g = 0; g < to.groups(); ++g) {
    ParameterGroup& group = to.group(Group(g));
    const Buffer<float>& added = from.group(Group(g)).value;
    const int64_t before = group.value.size();
    group.value.grow_keep(before + added.size());
    std::copy(added.begin(), added.end(), group.value.begin() + before);
    if (!has_moments) continue;
    for (Buffer<float>* moment : {&group.moment1, &group.moment2}) {
      moment->grow_keep(before + added.size());
      std::fill(moment->begin() + before, moment->end(), 0.0f);
    }
  }
  to.set_count(count);
}

std::vector<int64_t> rows_but(int64_t count, const std::vector<int64_t>& rows) {
  std::vector<int64_t> others;
  auto next = rows.begin();
  for (int64_t n = 0; n < count; ++n)
    if (next != rows.end() && *next == n)
      ++next;
    else
      others.push_back(n);
  return others;
}

}  // namespace tessera
