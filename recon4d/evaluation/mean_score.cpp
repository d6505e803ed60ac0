// Means of the scores of views, each over the views that have the score.
#include <algorithm>
#include <functional>

#include "recon4d/evaluation/evaluate.h"
#include "recon4d/evaluation/metrics.h"

namespace tessera {
namespace {

/// Mean of a member over the views that have it.
std::optional<double> mean_of(const std::vector<ViewScore>& views,
                              const std::function<std::optional<double>(const ViewScore&)>& value) {
  double sum = 0;
  int64_t count = 0;
  for (const ViewScore& view : views)
    if (const std::optional<double> v = value(view)) {
      sum += *v;
      ++count;
    }
  return count > 0 ? std::optional<double>(sum / double(count)) : std::nullopt;
}

}  // namespace

MeanScore mean_score(const std::vector<ViewScore>& views) {
  MeanScore mean;
  mean.views = int64_t(views.size());
  mean.psnr = mean_of(views, [](const ViewScore& v) { return v.psnr; });
  mean.psnr_float = mean_of(views, [](const ViewScore& v) { return v.psnr_float; });
  for (auto member : {&StructureScores::reflect, &StructureScores::zero, &StructureScores::inside,
                      &StructureScores::inside_range2, &StructureScores::multi_scale})
    mean.structure.*member =
        mean_of(views, [member](const ViewScore& v) { return v.structure.*member; });
  mean.lpips = mean_of(views, [](const ViewScore& v) { return v.lpips; });
  mean.psnr_dynamic = mean_of(views, [](const ViewScore& v) { return v.psnr_dynamic; });
  mean.psnr_static = mean_of(views, [](const ViewScore& v) { return v.psnr_static; });
  mean.psnr_fit = mean_of(views, [](const ViewScore& v) { return v.psnr_fit; });
  mean.psnr_fit_dynamic = mean_of(views, [](const ViewScore& v) { return v.psnr_fit_dynamic; });
  mean.psnr_fit_static = mean_of(views, [](const ViewScore& v) { return v.psnr_fit_static; });
  mean.dynamic_views = std::count_if(views.begin(), views.end(),
                                     [](const ViewScore& v) { return v.psnr_dynamic.has_value(); });
  if (const auto mse = mean_of(views, [](const ViewScore& v) { return v.mse; }))
    mean.psnr_of_mean_mse = psnr_of_mse(*mse);
  return mean;
}

}  // namespace tessera
