// Means of the scores of views, each over the views that have it.
#include "recon4d/evaluation/mean_scores.h"

#include <algorithm>
#include <functional>
#include <iterator>

#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/score_rows.h"

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

MeanScore mean_of_those(const std::vector<ViewScore>& views,
                        const std::function<bool(const ViewScore&)>& belongs) {
  std::vector<ViewScore> chosen;
  std::copy_if(views.begin(), views.end(), std::back_inserter(chosen), belongs);
  return mean_score(chosen);
}

}  // namespace

MeanScore mean_score(const std::vector<ViewScore>& views) {
  MeanScore mean;
  mean.views = int64_t(views.size());
  mean.psnr = mean_of(views, [](const ViewScore& v) { return v.psnr; });
  mean.psnr_float = mean_of(views, [](const ViewScore& v) { return v.psnr_float; });
  for (const ScoreRow& row : kScoreRows)
    mean.*row.score = mean_of(views, [&](const ViewScore& v) { return v.*row.score; });
  mean.dynamic_views = std::count_if(views.begin(), views.end(),
                                     [](const ViewScore& v) { return v.psnr_dynamic.has_value(); });
  if (const auto mse = mean_of(views, [](const ViewScore& v) { return v.mse; }))
    mean.psnr_of_mean_mse = psnr_of_mse(*mse);
  return mean;
}

void add_means(EvaluationReport& report) {
  const std::vector<ViewScore>& views = report.views;
  report.all = mean_score(views);
  if (report.split == Split::kTrain || report.split == Split::kValidation) return;
  // a held-out view is one whose timestep was seen, a held-out time one whose camera was
  const auto group = [&](bool time_seen, bool camera_seen) {
    return mean_of_those(views, [=](const ViewScore& view) {
      return view.held_out_view == time_seen && view.held_out_time == camera_seen;
    });
  };
  report.held_out_views =
      mean_of_those(views, [](const ViewScore& view) { return view.held_out_view; });
  report.held_out_times =
      mean_of_those(views, [](const ViewScore& view) { return view.held_out_time; });
  report.novel_view = group(true, false);
  report.novel_time = group(false, true);
  report.novel_view_and_time = group(false, false);
  report.withheld = group(true, true);
}

}  // namespace tessera
