// The colours of presets. They can be told apart by people with colour blindness, too.
// Source: the palette of Okabe and Ito (2008).
#include <array>
#include <cstdint>

#include "tools/report/svg_chart.h"

namespace tessera {
namespace {

struct PresetColour {
  std::string_view preset, colour;
};

constexpr std::array<PresetColour, 7> kPresets = {{{"fast", "#E69F00"},
                                                   {"balanced", "#0072B2"},
                                                   {"best", "#009E73"},
                                                   {"faster-gs", "#D55E00"},
                                                   {"yang4d", "#CC79A7"},
                                                   {"3dgs", "#56B4E9"},
                                                   {"mcmc", "#8A6FBF"}}};

constexpr std::array<std::string_view, 4> kOthers = {"#7F7F7F", "#A6761D", "#666699", "#5F8F4F"};

}  // namespace

std::string preset_colour(std::string_view preset) {
  for (const PresetColour& known : kPresets)
    if (known.preset == preset) return std::string(known.colour);
  uint32_t sum = 0;
  for (const char c : preset) sum = sum * 31 + uint8_t(c);
  return std::string(kOthers[sum % kOthers.size()]);
}

}  // namespace tessera
