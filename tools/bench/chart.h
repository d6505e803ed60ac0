// What: points of one scene → a gnuplot script with its data inside, and gnuplot run on it.
// Not: points (bench/report.h).
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera {

enum class BenchImage {
  kChart,  // PSNR against seconds, frontier and knee; PSNR against the model's bytes
  kCurve   // PSNR and SSIM against seconds
};

struct ImageRequest {
  BenchImage kind = BenchImage::kChart;
  std::string stem;                                    // of the files: stem.svg, stem.png
  std::string emphasised;                              // the label that is drawn bold
  nlohmann::json published = nlohmann::json::array();  // read_published
};

/// An array of {name, scene, psnr, seconds, device, and bytes where known}, or an object that has
/// it as `entries`. Errors: InputError naming the file and what an entry lacks.
nlohmann::json read_published(const std::filesystem::path& file);

/// Whether a scene of bench_points has a point that can be drawn.
bool can_be_drawn(const nlohmann::json& scene);

/// Published entries of other scenes are left out. Runs in the folder that the images go to.
std::string gnuplot_script(const nlohmann::json& scene, const ImageRequest& request);

/// Writes folder/stem.gp, runs gnuplot on it: stem.svg and stem.png. What went wrong, in one line;
/// empty: nothing.
std::string draw_image(const std::filesystem::path& folder, const std::string& stem,
                       const std::string& script);

}  // namespace tessera
