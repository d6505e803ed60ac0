// What: points of all scenes → a gnuplot script: PSNR against the bytes of the shipped file.
// Not: points (bench/report.h), nor running gnuplot (bench/chart.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// Whether any point of bench_points has a size and a score.
bool has_sizes(const nlohmann::json& scenes);

/// A colour and a line for each scene, through its points with a `share`, which are named by it;
/// the others, presets, have a mark each. Runs in the folder that stem.svg and stem.png go to.
std::string size_script(const nlohmann::json& scenes, const std::string& stem);

}  // namespace tessera
