// A training between two steps as one file, from which it resumes bit for bit. The file is written
// whole or not at all; the previous one stays. It holds a JSON header and then the arrays of the
// state in the order of its members, float32 (steps of gains: int32), little-endian
// (checkpoint_file.h). Where Gaussians differ in SH degree, `sh_blocks` of the header has the
// number of elements of degree 0 … 3 of each set; they are stored in the order of ShBlocks::kOrder
// with the bands that each has.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "recon4d/model/checkpoint_file.h"
#include "recon4d/model/train_state.h"
#include "recon4d/model/validation_record.h"

namespace tessera {

struct Checkpoint {
  TrainState state;  // as it was between the steps
  TrainOptions options;
  std::string provenance;  // JSON object: versions, device, scene hash: what the writer knew
  ValidationRecord validation;
};

/// `state` in the host's memory; `provenance`: a JSON object as text, or empty. Errors: InputError:
/// the folder cannot be written; WriteError: the disk is full; nothing is lost then.
void save_checkpoint(const std::filesystem::path& path, const TrainState& state,
                     const TrainOptions& options, const std::string& provenance,
                     const ValidationRecord& validation = {});
/// Takes no memory but the state's. Errors: CheckpointRefused: not a checkpoint, another
/// version, truncated, damaged; InputError: the file cannot be read.
Checkpoint load_checkpoint(const std::filesystem::path& path);
/// The header alone, for `tessera info`; no array is read. Errors: as load_checkpoint.
nlohmann::json read_checkpoint_header(const std::filesystem::path& path);

}  // namespace tessera
