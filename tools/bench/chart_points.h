// Metrics of a point of bench_points as a point of a chart, with its error bars.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "tools/report/svg_chart.h"

namespace tessera {

/// A metric on an axis, and how much of it is 1 on that axis: 1 << 20 for bytes as MiB.
struct ChartMetric {
  const char* name;
  double unit = 1;
};

/// Medians of two metrics, with least and most as error bars; a coordinate whose metric was not
/// measured is NaN, which has no place in a chart.
ChartPoint chart_point(const nlohmann::json& point, const ChartMetric& x, const ChartMetric& y);

}  // namespace tessera
