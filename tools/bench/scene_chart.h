// The charts of one scene as one SVG image: quality against training time and model size, with
// published figures of other programs.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/report/svg_chart.h"

namespace tessera {

enum class BenchImage {
  kChart,  // PSNR against seconds, Pareto front and knee; PSNR against the model's MiB
  kCurve   // PSNR and SSIM against seconds
};

struct ImageRequest {
  BenchImage kind = BenchImage::kChart;
  std::string emphasised;  // the label whose curve is drawn thick, with steps at its points
  nlohmann::json published = nlohmann::json::array();  // read_published
};

/// Whether a scene of bench_points has a point that can be drawn.
bool can_be_drawn(const nlohmann::json& scene);

/// Two panels side by side. Published entries of other scenes are left out. "" where the scene has
/// no point that can be drawn.
std::string scene_svg(const nlohmann::json& scene, const ImageRequest& request);

/// An array of {name, scene, psnr (dB), seconds, device, and bytes where known}, or an object that
/// has it as `entries`. Errors: InputError naming the file and what an entry lacks.
nlohmann::json read_published(const std::filesystem::path& file);

/// A metric on an axis, and how much of it is 1 on that axis: 1 << 20 for bytes as MiB.
struct ChartMetric {
  const char* name;
  double unit = 1;
};

/// Medians of two metrics, with least and most as error bars; a coordinate whose metric was not
/// measured is NaN, which has no place in a chart.
ChartPoint chart_point(const nlohmann::json& point, const ChartMetric& x, const ChartMetric& y);

}  // namespace tessera
