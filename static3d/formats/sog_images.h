// What the writers of .sog, .sogst and .tsog share: attributes of Gaussians as images with a pixel
// for each, row by row, and the members of meta.json that describe them. Source: formats 1.6
// (PlayCanvas, "The SOG Format", version 2).
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "kernels/gaussians.h"
#include "recon4d/model/gaussian_set.h"
#include "static3d/formats/lossless_webp.h"
#include "static3d/transform/scalar_codebook.h"

namespace tessera {

struct SogImage {
  std::string name;
  RgbaImage image;
};

/// As square as whole blocks of 4 x 4 pixels allow; opaque.
RgbaImage sog_image(int64_t count);

/// A number of the n-th Gaussian by its channel.
using SogValue = std::function<double(int64_t n, int channel)>;

/// The least and the largest of each channel, as floats that meta.json states.
struct SogRange {
  std::vector<float> low, high;

  SogRange() = default;
  SogRange(int64_t count, int channels, const SogValue& value);
  /// About zero, which is one of the 65,536 values: what stands still, stands still when it is
  /// read.
  SogRange about_zero() const;
  /// "mins":[…],"maxs":[…]
  std::string text() const;
};

/// 16 bits of each channel within its range, in NAME_l.webp and NAME_u.webp. Returns
/// "files":[…].
std::string add_planes(const std::string& name, int64_t count, const SogRange& range,
                       const SogValue& value, std::vector<SogImage>& images);
/// The sound Gaussians of a set along a Morton curve, without those that would widen the range of
/// means so far that the core of the scene is off by more than 1/256 of its half extent. Errors:
/// InputError: more than an image holds, a build without libwebp.
GaussianSet sog_order(const std::filesystem::path& path, const GaussianSet& set);

/// means_l.webp and means_u.webp. Returns "means":{…}.
std::string add_means(const GaussianSpans<const float>& from, std::vector<SogImage>& images);
/// quats.webp
void add_rotations(const GaussianSpans<const float>& from, std::vector<SogImage>& images);
/// The first three numbers of a group of each Gaussian, by a codebook that they share.
ScalarCodebook add_indices(const char* name, const GaussianSpans<const float>& from, Group group,
                           std::vector<SogImage>& images);
/// scales.webp and, with opacities, sh0.webp. Returns the members "scales", "quats" and "sh0" of
/// meta.json, with quats.webp.
std::string add_shapes_and_colours(const GaussianSpans<const float>& from,
                                   std::vector<SogImage>& images);
/// A palette of the coefficients from the first degree on. Returns ,"shN":{…}; "" for degree 0 or
/// no Gaussian.
std::string add_harmonics(const GaussianSpans<const float>& from, int sh_degree,
                          std::vector<SogImage>& images);

/// "1,2,3"
std::string numbers_text(const float* values, size_t count);
/// A zip archive with meta.json before the images.
std::string sog_archive(std::string meta, const std::vector<SogImage>& images);

}  // namespace tessera
