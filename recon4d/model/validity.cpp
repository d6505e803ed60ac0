// What: the test of one Gaussian and the copy of a selection.
// Not: a repair: an unsound Gaussian is left out and counted by the caller.
#include "recon4d/model/validity.h"

#include <algorithm>

#include "kernels/elements/load_gaussian.h"

namespace tessera {

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
  return has_length(kRotation) && (set.form != Form::kPair || has_length(kRotationRight));
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
