// Spreads of metrics as coordinates.
#include "tools/bench/chart_points.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

void set_from(const nlohmann::json& metrics, const ChartMetric& metric, double& value,
              std::optional<ChartSpan>& span) {
  value = std::numeric_limits<double>::quiet_NaN();
  if (!metrics.contains(metric.name)) return;
  const nlohmann::json& spread = metrics[metric.name];
  const auto scaled = [&](const char* part) { return spread.at(part).get<double>() / metric.unit; };
  value = scaled("median");
  span = {scaled("least"), scaled("most")};
}

}  // namespace

ChartPoint chart_point(const nlohmann::json& point, const ChartMetric& x, const ChartMetric& y) {
  ChartPoint result;
  set_from(point.at("metrics"), x, result.x, result.x_span);
  set_from(point.at("metrics"), y, result.y, result.y_span);
  return result;
}

}  // namespace tessera
