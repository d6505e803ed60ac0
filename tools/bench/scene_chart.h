// The charts of one scene: quality against training time and model size, as one SVG image.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

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

}  // namespace tessera
