// What: the one door to splat files: a Tessera 4D .ply or a 3DGS .ply (plain or compressed).
// Not: run folders and checkpoints (tools/ knows those).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "recon4d/gaussian_set.h"

namespace tessera {

struct OpenedModel {
  GaussianModel model;
  bool is_tessera = false;            // otherwise a static model from a 3DGS file
  std::vector<std::string> warnings;  // one line each
};

/// Errors: InputError naming the file and what is wrong with it.
OpenedModel open_model(const std::filesystem::path& path);

}  // namespace tessera
