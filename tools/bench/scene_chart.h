// The charts of one scene: quality against training time and model size, as one SVG image, and the
// published figures of other programs in them.
#pragma once
#include <filesystem>
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

/// An array of {name, scene, psnr (dB), seconds, device, and bytes where known}, or an object that
/// has it as `entries`. Errors: InputError naming the file and what an entry lacks.
nlohmann::json read_published(const std::filesystem::path& file);

}  // namespace tessera
