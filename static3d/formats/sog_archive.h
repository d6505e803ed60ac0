// What the readers of .sog, .sogst and .tsog share: the entries of an archive, lookups in its
// meta.json that name what is wrong, and attributes of Gaussians from images. Source: formats 1.6
// (PlayCanvas, "The SOG Format", version 2).
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/gaussians.h"
#include "static3d/formats/lossless_webp.h"

namespace tessera {

class SogArchive {
 public:
  /// `file` must outlive it. Errors: as zip_contents; no meta.json that is an object with `count`.
  SogArchive(std::string_view file, std::filesystem::path path);

  /// Throws an InputError that names the file.
  [[noreturn]] void fail(const std::string& what) const;
  const nlohmann::json& meta() const { return meta_; }
  int64_t count() const { return count_; }
  bool has(const char* key) const { return meta_.contains(key); }
  /// An object of meta.json, or of an object in it.
  const nlohmann::json& object(const char* key) const { return object(meta_, key); }
  const nlohmann::json& object(const nlohmann::json& in, const char* key) const;
  int64_t whole_number(const nlohmann::json& object, const char* key, int64_t most) const;
  double number(const nlohmann::json& object, const char* key) const;
  std::vector<float> numbers(const nlohmann::json& object, const char* key, size_t most) const;
  size_t file_count(const nlohmann::json& group) const;
  /// The image of files[index] of an object.
  RgbaImage image(const nlohmann::json& group, size_t index, int64_t most_pixels) const;
  /// An image with a pixel for each Gaussian.
  RgbaImage splat_image(const nlohmann::json& group, size_t index = 0) const;

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string_view> contents_;
  nlohmann::json meta_;
  int64_t count_ = 0;
};

/// Channel by channel low + q·(high − low), q: the 16 bits of two images, or the 8 of one. `name`:
/// of the group, for errors as fail(): ranges of another number of channels.
void read_planes(const SogArchive& archive, const char* name, const nlohmann::json& group,
                 const std::vector<float>& low, const std::vector<float>& high, size_t channels,
                 const std::function<void(int64_t n, int channel, double value)>& store);
float codebook_value(const SogArchive& archive, const std::vector<float>& codebook, uint8_t index);

/// Means, rotations, scales, opacities and SH of `degree` into a set of any form. Errors: as
/// fail().
void read_splats_of(const SogArchive& archive, int degree, const GaussianSpans<float>& to);
/// The SH degree; 0 without shN.
int degree_of(const SogArchive& archive);

}  // namespace tessera
