// Gaussians as one block of a Tessera 4D file, sorted, rounded and stored as streams, and back.
// Source: docs/reference/tessera4d.md, sections 4 and 5.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/manifest.h"

namespace tessera {

struct BlockRules {
  bool lossless = false;
  int sh_degree = 3;      // degrees that are written
  Cutoff<double> cutoff;  // of the model
  int gzip_level = 12;    // 1 to 12
};

struct Block {
  BlockInfo info;  // without file, offset, level and segment
  std::string bytes;
};

/// A static set, a dynamic one in velocity form without levels of time, or a canonical one, every
/// Gaussian of which `nodes` carry; sound Gaussians only, at least one.
Block encode_block(const GaussianSet& set, const BlockRules& rules,
                   const MotionNodes& nodes = MotionNodes());
/// The block with its streams in a head of its own bytes.
Block with_head(Block block);

/// Of a set's positions, world units: a share of the second axes of the smaller Gaussians, for the
/// thinnest is often that of a disc.
double position_step(const GaussianSpans<const float>& set);

/// Errors: InputError naming `path`: another size or checksum than the manifest's.
void check_block(std::string_view bytes, const BlockInfo& info, const std::filesystem::path& path);

/// A static set, a canonical one or one in velocity form, with the SH coefficients of `sh_degree`;
/// of a canonical one also its nodes. Errors:
/// InputError naming `path`: a checksum that differs, streams that are missing, too short, or of
/// another shape.
GaussianSet decode_block(std::string_view bytes, const BlockInfo& info, int sh_degree,
                         bool anchor_in_clip, const std::filesystem::path& path,
                         MotionNodes* nodes = nullptr);

}  // namespace tessera
