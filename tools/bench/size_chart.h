// Charts of quality against the size of the shipped file: a panel for each scene.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// Whether any point of bench_points has a size and a score.
bool has_sizes(const nlohmann::json& scenes);

/// One SVG image. A panel has a line through the points of the scene with a `share`, which are
/// named by it, and a dot for each of the others, presets. "" where no point has a size.
std::string sizes_svg(const nlohmann::json& scenes);

}  // namespace tessera
