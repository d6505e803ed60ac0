// What an image file states about its colours: an ICC profile, or a gamma. Source: ICC.1:2022,
// clauses 8, 9 and 10; PNG (third edition), clause 11.3.2.
#pragma once
#include <array>
#include <glm/mat3x3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "ingest/scene.h"

namespace tessera {

/// Of RGB by three curves and a matrix.
struct ColourProfile {
  std::string name;                                // as it calls itself
  std::array<std::array<double, 256>, 3> light{};  // of a code of R, G, B: linear, 0 to 1
  glm::dmat3 to_srgb{1};                           // from its linear light to that of sRGB
};

struct StatedColour {
  std::optional<ColourProfile> profile;  // where it is another one than sRGB
  std::string unknown;                   // name of a profile that is of another kind
};

/// Of an ICC profile. One that is damaged is unknown.
StatedColour colour_of_icc(std::string_view icc);
/// Of the bytes of a PNG or JPEG file; nothing of others, and where these state nothing.
StatedColour colour_of_file(std::string_view bytes);

/// Grey, RGB or RGBA as sRGB, clipped to its range.
void convert_to_srgb(const ColourProfile& profile, Image8& image);

}  // namespace tessera
