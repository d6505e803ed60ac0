// A set of Gaussians in which every number is known and each Gaussian carries a tag, with Adam's
// moments and statistics, for tests of density control. The set is not meant to be rendered.
#pragma once
#include <cmath>
#include <vector>

#include "recon4d/density/density.h"
#include "tests/support/forms.h"

namespace tessera::testing {

using Tag = int;  // a Gaussian's place at first; kept in its first SH coefficient

struct HandmadeSet {
  GaussianSet set;
  SetStatistics statistics;

  HandmadeSet(SetForm form, int64_t count)
      : set(form, 4, host_memory(), form == SetForm::kStatic ? 0 : 1) {
    set.resize(count);
    set.ensure_moments();
    statistics.reset(count);
    for (int g = 0; g < set.groups(); ++g) {
      ParameterGroup& group = set.group(Group(g));
      for (int64_t i = 0; i < group.value.size(); ++i) {
        group.value[i] = float(0.1 + 0.8 * std::fmod(0.618 * double(i + 7 * g), 1.0));
        group.moment1[i] = float(1 + i + 1000 * g);
        if (!packs_moments(Group(g))) group.moment2[i] = float(2 + i + 1000 * g);
      }
    }
    for (int64_t n = 0; n < count; ++n) *set.values().at(kSh, n) = float(n);
  }

  /// Largest scale (the other two are smaller), opacity, mean gradient over three batches.
  void describe(int64_t n, float scale, float opacity, float gradient) {
    const float factor[] = {0.5f, 0.25f, 1};
    for (int k = 0; k < 3; ++k)
      set.values().at(kLogScale, n)[k] = std::log(scale * factor[(k + n) % 3]);
    *set.values().at(kOpacityLogit, n) = std::log(opacity / (1 - opacity));
    statistics.gradient_sum[n] = 3 * gradient;
    statistics.count[n] = 3;
  }

  std::vector<Tag> tags() const {
    std::vector<Tag> result;
    for (int64_t n = 0; n < set.count(); ++n) result.push_back(Tag(*set.values().at(kSh, n)));
    return result;
  }
};

}  // namespace tessera::testing
