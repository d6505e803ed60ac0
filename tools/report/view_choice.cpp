// Spreads views over time and finds those that tell most about a model.
#include "tools/report/view_choice.h"

#include <algorithm>
#include <numeric>

namespace tessera {

std::vector<CameraViews> strip_views(const std::vector<ScoredView>& views, size_t most) {
  std::vector<CameraViews> cameras;
  for (size_t i = 0; i < views.size(); ++i) {
    const auto same = [&](const CameraViews& known) { return known.camera == views[i].camera; };
    auto found = std::find_if(cameras.begin(), cameras.end(), same);
    if (found == cameras.end()) found = cameras.insert(cameras.end(), {views[i].camera, {}});
    found->views.push_back(i);
  }
  for (CameraViews& camera : cameras) {
    const size_t count = camera.views.size();
    if (count <= most) continue;
    std::vector<size_t> kept;
    for (size_t k = 0; k < most; ++k)
      kept.push_back(camera.views[(k * (count - 1) + (most - 1) / 2) / (most - 1)]);
    camera.views = std::move(kept);
  }
  return cameras;
}

std::vector<ChosenView> telling_views(const std::vector<ScoredView>& views) {
  std::vector<size_t> order(views.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return views[a].psnr < views[b].psnr; });
  if (order.empty()) return {};
  if (order.size() == 1) return {{"The only view", order.front()}};
  std::vector<ChosenView> chosen = {{"Worst view", order.front()}};
  if (order.size() > 2) chosen.push_back({"Median view", order[order.size() / 2]});
  chosen.push_back({"Best view", order.back()});
  return chosen;
}

}  // namespace tessera
