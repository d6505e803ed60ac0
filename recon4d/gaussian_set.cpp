// What: sizes and copies of parameter groups.
// Not: initial values (initialise.cpp) or density control.
#include "recon4d/gaussian_set.h"

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {

void GaussianSet::resize(int64_t count) {
  count_ = count;
  for (int g = 0; g < groups(); ++g) {
    ParameterGroup& group = groups_[size_t(g)];
    group.value.resize(count * width(Group(g)));
    group.moment1 = Buffer<float>();
    group.moment2 = Buffer<float>();
  }
}

void GaussianSet::set_count(int64_t count) {
  for (int g = 0; g < groups(); ++g)
    check(groups_[size_t(g)].value.size() == count * width(Group(g)),
          "GaussianSet: rows of a group");
  count_ = count;
}

void GaussianSet::ensure_moments() {
  if (has_moments()) return;
  for (int g = 0; g < groups(); ++g) {
    ParameterGroup& group = groups_[size_t(g)];
    group.moment1.resize(group.value.size());
    group.moment2.resize(group.value.size());
    std::fill(group.moment1.begin(), group.moment1.end(), 0.0f);
    std::fill(group.moment2.begin(), group.moment2.end(), 0.0f);
  }
}

GaussianSet GaussianSet::clone_values() const {
  GaussianSet copy(dim_, coefficients_);
  copy.resize(count_);
  for (int g = 0; g < groups(); ++g)
    std::copy(groups_[size_t(g)].value.begin(), groups_[size_t(g)].value.end(),
              copy.groups_[size_t(g)].value.begin());
  return copy;
}

int64_t GaussianSet::value_bytes() const {
  int64_t scalars = 0;
  for (int g = 0; g < groups(); ++g) scalars += width(Group(g));
  return count_ * scalars * int64_t(sizeof(float));
}

}  // namespace tessera
