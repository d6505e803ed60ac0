// Sums of blending weights view by view, and the rule on them.
#include "recon4d/reduction/floaters.h"

#include <algorithm>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/math/splat.h"
#include "kernels/pipeline.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/evaluation/scoring_pass.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/training/scene_scale.h"

namespace tessera {
namespace {

/// One view at a time of a model that lies where the backend works.
class WeightPass {
 public:
  WeightPass(Backend& backend, const GaussianModel& model) : backend_(backend), pipeline_(backend) {
    args_ = {
        {model.static_set.values(), model.dynamic_set.values()}, {}, render_options(model), true};
    args_.nodes = model.nodes.spans();
  }

  /// Σ w of each element, [N]; valid until the next call.
  const Buffer<ElementSums<float>>& draw(const View& view, const GaussianModel& model) {
    args_.views = {view};
    pipeline_.forward(args_);
    pipeline_.d_colour().resize(3 * pipeline_.batch().pixels);  // sums of weights need no image
    backend_.fill_zero(pipeline_.d_colour().span());
    ElementBuffers elements(backend_, model, false);
    pipeline_.sensitivity();
    pipeline_.add_contributions(elements.sums.span());
    sums_.copy_from(elements.sums);
    return sums_;
  }

 private:
  Backend& backend_;
  Pipeline<float> pipeline_;
  ForwardArgs<float> args_;
  Buffer<ElementSums<float>> sums_;  // on the host
};

constexpr float kTiny = 1e-6f;

/// [N] static set first; of the host's model.
std::vector<float> opacities(const GaussianModel& model) {
  std::vector<float> opacity;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    for (const float logit : set->group(kOpacityLogit).value) opacity.push_back(sigmoid(logit));
  return opacity;
}

/// At most `most` of them, evenly from first to last.
template <class T>
std::vector<T> evenly(const std::vector<T>& all, int64_t most) {
  const auto count = int64_t(all.size()), taken = std::min(count, most);
  std::vector<T> some;
  for (int64_t i = 0; i < taken; ++i) some.push_back(all[size_t(i * count / taken)]);
  return some;
}

}  // namespace

CameraViews views_of_support(const std::vector<View>& training, int64_t most, int longest) {
  constexpr int64_t kMostPlaces = 64;
  std::vector<Camera> places;
  std::vector<double> times;
  for (const View& view : training) {
    times.push_back(view.time);
    if (std::none_of(places.begin(), places.end(),
                     [&](const Camera& c) { return equal_pose(c, view.camera); }))
      places.push_back(view.camera);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  places = evenly(places, kMostPlaces);
  if (places.empty()) return {};
  times = evenly(times, std::max<int64_t>(1, most / int64_t(places.size())));
  CameraViews cameras;
  for (const Camera& place : places) {
    cameras.emplace_back();
    for (const double time : times)
      cameras.back().push_back({limited_camera(place, longest), time});
  }
  return cameras;
}

Support measure_support(Backend& backend, const GaussianModel& model, const CameraViews& cameras) {
  const GaussianModel drawn = model.clone_values(backend.memory());
  WeightPass pass(backend, drawn);
  const auto count = size_t(model.count());
  Support support{{}, std::vector<float>(count)};
  std::vector<double> sum(count), squares(count), of_camera(count);
  for (const std::vector<View>& views : cameras) {
    std::fill(of_camera.begin(), of_camera.end(), 0.0);
    for (const View& view : views) {
      const Buffer<ElementSums<float>>& sums = pass.draw(view, drawn);
      const float pixels = float(view.camera.width) * float(view.camera.height);
      parallel_for(int64_t(count), 1 << 13, [&](int64_t first, int64_t last) {
        for (auto n = size_t(first); n < size_t(last); ++n) {
          const float weight = sums[int64_t(n)].weight;
          of_camera[n] += double(weight);
          support.extent[n] = std::max(support.extent[n], weight / pixels);
        }
      });
    }
    for (size_t n = 0; n < count; ++n) {
      sum[n] += of_camera[n];
      squares[n] += of_camera[n] * of_camera[n];
    }
  }
  const std::vector<float> opacity = opacities(model);
  for (size_t n = 0; n < count; ++n) {
    support.cameras.push_back(squares[n] > 0 ? float(sum[n] * sum[n] / squares[n]) : 0.0f);
    support.extent[n] /= std::max(opacity[n], kTiny);
  }
  return support;
}

std::vector<uint8_t> find_floaters(const GaussianModel& model, const Support& support,
                                   const FloaterRule& rule) {
  const std::vector<float> opacity = opacities(model);
  std::vector<uint8_t> marked;
  for (size_t n = 0; n < opacity.size(); ++n)
    marked.push_back(support.cameras[n] > 0 && support.cameras[n] < rule.cameras &&
                     opacity[n] < rule.opacity && support.extent[n] >= rule.extent);
  return marked;
}

int64_t remove_marked(const std::vector<uint8_t>& marked, GaussianModel& model) {
  check(int64_t(marked.size()) == model.count(), "remove_marked: one mark an element");
  const int64_t before = model.count();
  size_t first = 0;
  for (GaussianSet* set : {&model.static_set, &model.dynamic_set}) {
    std::vector<int64_t> kept;
    for (int64_t n = 0; n < set->count(); ++n)
      if (marked[first + size_t(n)] == 0) kept.push_back(n);
    first += size_t(set->count());
    *set = select_elements(*set, kept);
  }
  return before - model.count();
}

}  // namespace tessera
