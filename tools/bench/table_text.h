// Points as Markdown tables, with published figures beside them.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/bench/tables.h"

namespace tessera {

/// Adds `published` to the points of scenes of bench_points: the row's figures of that scene, and
/// those of means over others.
void add_published(nlohmann::json& scenes, const BenchTable& table);

/// A table for each scene, with a column of published figures where any point has some, and one of
/// means over the scenes where there are several. `columns`: of bench_metrics.
std::string tables_text(const nlohmann::json& scenes, const std::vector<std::string>& columns);

}  // namespace tessera
