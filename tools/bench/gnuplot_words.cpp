// What: quoting, formatting.
// Not: any file.
#include "tools/bench/gnuplot_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

namespace tessera {

const char* plot_colour(size_t i) {
  static constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                             "#E69F00", "#56B4E9", "#7F7F7F", "#000000"};
  return kColours[i % std::size(kColours)];
}

std::string gnuplot_string(const std::string& text) {
  std::string inside;
  for (char c : text) inside += c == '\'' ? std::string("''") : std::string(1, c == '\n' ? ' ' : c);
  return "'" + inside + "'";
}

std::string gnuplot_datum(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return '"' + text + '"';
}

std::string gnuplot_block(const std::string& name, const std::string& rows) {
  return fmt::format("${} << END\n{}END\n", name, rows);
}

std::string spread_columns(const nlohmann::json& metrics, const char* metric, double unit) {
  std::string text;
  const nlohmann::json spread = metrics.value(metric, nlohmann::json::object());
  for (const char* part : {"median", "least", "most"})
    text +=
        spread.contains(part) ? fmt::format("{:.10g} ", spread[part].get<double>() / unit) : "NaN ";
  return text;
}

std::string logarithmic_tics() {
  std::vector<std::string> tics;
  for (int decade = -3; decade < 7; ++decade)
    for (int digit : {1, 2, 5}) tics.push_back(fmt::format("{}e{}", digit, decade));
  return fmt::format("set xtics ({})\n", fmt::join(tics, ", "));
}

std::string both_terminals(const std::string& stem, int width, int height,
                           const std::string& plots) {
  return fmt::format(
      "do for [kind in 'svg png'] {{\n"
      "if (kind eq 'svg') {{ set terminal svg size {0},{1} noenhanced font 'sans,14' background "
      "'white' }} else {{ set terminal pngcairo size {0},{1} noenhanced font 'sans,11' }}\n"
      "set output {2}.kind\n{3}unset output\n}}\n",
      width, height, gnuplot_string(stem + "."), plots);
}

}  // namespace tessera
