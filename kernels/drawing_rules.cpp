// The allowed ranges of drawing rules.
#include "kernels/drawing_rules.h"

#include <cstdio>

#include "kernels/math/sort_keys.h"

namespace tessera {

namespace {

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", number);
  return text;
}

}  // namespace

std::string wrong_rule(const DrawingRules& rules) {
  std::string wrong;
  const auto require = [&](bool good, const char* name, double value, const std::string& expected) {
    if (good || !wrong.empty()) return;
    wrong = std::string(name) + " is " + text_of(value) + ", expected " + expected;
  };
  const auto in = [](int value, int most) { return value >= 0 && value <= most; };
  require(in(rules.sh_degree, kMaxShDegree), "sh_degree", rules.sh_degree,
          "0 to " + text_of(kMaxShDegree));
  require(in(rules.sh_time_degree, kMaxTimeLevels), "sh_time_degree", rules.sh_time_degree,
          "0 to " + text_of(kMaxTimeLevels));
  require(rules.sh_time_period > 0, "sh_time_period", rules.sh_time_period, "more than 0");
  require(rules.near_plane > 0, "near_plane", rules.near_plane, "more than 0");
  require(rules.far_plane > rules.near_plane, "far_plane", rules.far_plane,
          "more than near_plane " + text_of(rules.near_plane));
  require(rules.far_plane <= rules.near_plane * kDepthRange, "far_plane", rules.far_plane,
          "at most 2^32 times near_plane " + text_of(rules.near_plane) +
              ", beyond which depths are not told apart");
  require(rules.truncation_sigma > 0, "truncation_sigma", rules.truncation_sigma, "more than 0");
  require(rules.time_filter >= 0, "time_filter", rules.time_filter, "at least 0");
  return wrong;
}

}  // namespace tessera
