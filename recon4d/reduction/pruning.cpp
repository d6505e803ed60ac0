// The order of Gaussians by price, its running sum, and the elements that remain.
#include "recon4d/reduction/pruning.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/parallel_sort.h"
#include "recon4d/model/element_edits.h"

namespace tessera {

double ByteRates::bytes_of(bool dynamic, int sh_degree) const {
  return still + (dynamic ? time : 0) + band * 3 * (sh_coefficients(sh_degree) - 1);
}

std::vector<Removal> removal_order(const GaussianModel& model, const Contributions& contributions,
                                   bool static_is_frozen, const ByteRates& rates) {
  struct Ranked {
    double error_per_byte;
    bool is_lit;
    int64_t place;  // static set first

    bool operator<(const Ranked& b) const {
      return std::tie(error_per_byte, is_lit, place) <
             std::tie(b.error_per_byte, b.is_lit, b.place);
    }
  };
  std::vector<Ranked> ranked;
  ranked.reserve(size_t(model.count()));
  const int64_t statics = model.static_set.count();
  double bytes[2];
  for (int k = 0; k < 2; ++k) {
    const SetContributions& set = contributions.sets[k];
    bytes[k] = rates.bytes_of(k == 1, model.drawing.sh_degree);
    if (k == 0 && static_is_frozen) continue;
    for (size_t n = 0; n < set.weight.size(); ++n)
      ranked.push_back(
          {set.removal_cost(n) / bytes[k], set.weight[n] > 0, k * statics + int64_t(n)});
  }
  parallel_sort(ranked);
  std::vector<Removal> order;
  order.reserve(ranked.size());
  for (const Ranked& r : ranked) {
    const int k = r.place < statics ? 0 : 1;
    const int64_t element = r.place - k * statics;
    order.push_back({k, element, contributions.sets[k].removal_cost(size_t(element)), bytes[k],
                     r.is_lit || contributions.share >= 1});
  }
  return order;
}

std::vector<int64_t> still_dynamic(const Contributions& contributions) {
  constexpr float kLeastMoving = 0.4F;  // of the light
  std::vector<int64_t> elements;
  const SetContributions& set = contributions.sets[1];
  for (size_t n = 0; contributions.motion_known && n < set.weight.size(); ++n)
    if (set.weight[n] > 0 && set.moving[n] < kLeastMoving * set.weight[n])
      elements.push_back(int64_t(n));
  return elements;
}

int64_t knee_count(const std::vector<Removal>& order, const Contributions& contributions,
                   double least_share) {
  const auto count = int64_t(order.size());
  if (count < 2) return count;
  double all = 0;
  for (const Removal& removal : order) all += removal.bytes;
  std::vector<double> size{all}, psnr{0};  // sums of bytes and errors; then ln and dB of these
  for (int64_t i = 0; i + 1 < count; ++i) {
    const double bytes = size.back() - order[size_t(i)].bytes;
    if (bytes < least_share * all) break;
    size.push_back(bytes);
    psnr.push_back(psnr.back() + order[size_t(i)].error);
  }
  parallel_for(int64_t(size.size()), 1 << 13, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i) {
      size[i] = std::log(size[i]);
      psnr[i] = contributions.psnr_after(psnr[i]);
    }
  });
  const double wide = size.front() - size.back(), high = psnr.front() - psnr.back();
  if (!(wide > 0)) return count;
  if (!(high > 0)) return count - int64_t(size.size()) + 1;  // none of these does anything
  size_t best = 0;
  double most = 0;
  for (size_t i = 0; i < size.size(); ++i) {
    const double above = (psnr[i] - psnr.back()) / high - (size[i] - size.back()) / wide;
    if (above > most) {
      most = above;
      best = i;
    }
  }
  return count - int64_t(best);
}

double error_per_byte_at(const std::vector<Removal>& order, int64_t count) {
  const int64_t gone = int64_t(order.size()) - count;
  return gone <= 0 ? 0 : order[size_t(gone - 1)].error_per_byte();
}

KeptElements kept_elements(const GaussianModel& model, const std::vector<Removal>& order,
                           int64_t count) {
  const auto removable = int64_t(order.size());
  check(removable == model.count() || removable == model.dynamic_set.count(),
        "kept_elements: an order of another model");
  const auto gone = size_t(std::clamp<int64_t>(model.count() - count, 0, removable));
  std::vector<uint8_t> goes[2];
  goes[0].resize(size_t(model.static_set.count()));
  goes[1].resize(size_t(model.dynamic_set.count()));
  for (size_t i = 0; i < gone; ++i) goes[order[i].set][size_t(order[i].element)] = 1;
  KeptElements elements;
  for (int k = 0; k < 2; ++k)
    for (size_t n = 0; n < goes[k].size(); ++n)
      if (goes[k][n] == 0) elements.set_elements[k].push_back(int64_t(n));
  return elements;
}

int64_t seen_count(const std::vector<Removal>& order) {
  return std::count_if(order.begin(), order.end(), [](const Removal& r) { return r.seen; });
}

StateEdit cut_to(const std::vector<Removal>& order, int64_t count) {
  StateEdit edit;
  int64_t gone = seen_count(order) - std::max<int64_t>(0, count);
  for (size_t i = 0; i < order.size() && gone > 0; ++i) {
    if (!order[i].seen) continue;
    edit.dropped[order[i].set].push_back(order[i].element);
    --gone;
  }
  for (std::vector<int64_t>& elements : edit.dropped) std::sort(elements.begin(), elements.end());
  return edit;
}

GaussianModel with_elements(const GaussianModel& model, const KeptElements& elements) {
  GaussianModel thinned = model.clone_values();
  thinned.static_set = select_elements(model.static_set, elements.set_elements[0]);
  thinned.dynamic_set = select_elements(model.dynamic_set, elements.set_elements[1]);
  return thinned;
}

}  // namespace tessera
