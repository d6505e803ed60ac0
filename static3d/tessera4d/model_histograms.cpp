// The histograms of a model, from one pass over each set.
#include "static3d/tessera4d/model_histograms.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/load_gaussian.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/segments.h"
#include "static3d/tessera4d/stream.h"

namespace tessera {
namespace {

using nlohmann::json;

bool any(const float* values, int count) {
  return std::any_of(values, values + count, [](float value) { return value != 0; });
}

/// `degree`, `levels`: active ones.
int needed_degree(const GaussianSpans<const float>& set, int64_t n, int degree, int levels) {
  while (sh_coefficients(degree) > set.coefficients) --degree;
  for (; degree > 0; --degree) {
    const int begin = band_begin(degree), width = band_width(degree);
    if (any(set.at(kSh, n) + begin, width)) return degree;
    for (int level = 0; level < std::min(levels, set.time_levels); ++level)
      if (any(set.at(kShTime, n) + 3 * set.coefficients * level + begin, width)) return degree;
  }
  return 0;
}

int extent_bin(double extent) {
  int bin = 0;
  while (bin < kExtentBins - 1 && extent >= extent_edge(bin)) ++bin;
  return bin;
}

template <SetForm form>
void count_extents(const GaussianModel& model, const std::vector<int64_t>& elements,
                   ModelHistograms& histograms) {
  const GaussianSpans<const float> set = model.dynamic_set.values();
  for (int64_t n : elements) {
    GaussianState<float> g;
    if (!load_gaussian<form>(set, n, g)) continue;
    const double extent =
        std::sqrt(1 / double(g.spacetime.precision_time) + model.drawing.time_filter);
    if (drawn_in_clip(double(g.spacetime.mean_time), std::log(extent), double(g.stored_opacity),
                      model.cutoff<double>()))
      ++histograms.extents[size_t(extent_bin(extent))];
    else
      ++histograms.never_drawn;
  }
}

}  // namespace

double extent_edge(int edge) {
  constexpr int kFirst = -8;
  return std::exp2(kFirst + edge);
}

ModelHistograms histograms_of(const GaussianModel& model) {
  ModelHistograms histograms;
  const std::vector<int64_t> fixed = valid_elements(model.static_set),
                             moving = valid_elements(model.dynamic_set);
  for (int64_t n : fixed)
    ++histograms.static_degrees[size_t(
        needed_degree(model.static_set.values(), n, model.drawing.sh_degree, 0))];
  for (int64_t n : moving)
    ++histograms.dynamic_degrees[size_t(needed_degree(
        model.dynamic_set.values(), n, model.drawing.sh_degree, model.drawing.sh_time_degree))];
  with_form(model.dynamic_set.form(), [&](auto form) {
    if constexpr (is_dynamic(form())) count_extents<form()>(model, moving, histograms);
  });
  return histograms;
}

json to_json(const ModelHistograms& histograms, const TimeAxis& time_axis) {
  json clip = json::array(), seconds = json::array();
  for (int edge = 0; edge < kExtentBins - 1; ++edge) {
    clip.push_back(extent_edge(edge));
    seconds.push_back(extent_edge(edge) * time_axis.duration);
  }
  return {{"sh_degrees",
           {{"static", histograms.static_degrees}, {"dynamic", histograms.dynamic_degrees}}},
          {"temporal_extents",
           {{"edges_clip", clip},
            {"edges_seconds", seconds},
            {"counts", histograms.extents},
            {"never_drawn", histograms.never_drawn}}}};
}

}  // namespace tessera
