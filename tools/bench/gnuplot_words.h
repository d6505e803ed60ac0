// What: words of a gnuplot script: strings, data blocks, colours, tics.
// Not: any image (bench/chart.h, bench/size_chart.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// Told apart by people who see colours differently, too; beyond the last the first comes again.
const char* plot_colour(size_t i);

/// A string of gnuplot: single quotes are doubled, nothing else is special.
std::string gnuplot_string(const std::string& text);
/// A field of a data block.
std::string gnuplot_datum(std::string text);
/// $NAME; `rows` end with a new line each.
std::string gnuplot_block(const std::string& name, const std::string& rows);
/// "median least most " of one metric of a point (bench/report.h), NaN where it was not measured.
std::string spread_columns(const nlohmann::json& metrics, const char* metric, double unit = 1);
/// Labels at 1, 2 and 5 of every decade: the points of a logarithmic axis often lie within one.
std::string logarithmic_tics();
/// "do for …" around `plots`: PATH.svg and PATH.png of `width` × `height`.
std::string both_terminals(const std::string& stem, int width, int height,
                           const std::string& plots);

}  // namespace tessera
