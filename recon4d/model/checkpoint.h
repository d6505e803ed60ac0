// What: a training stopped between two steps, as one file: resuming goes on bit for bit.
// Not: a model to ship (model_file.h), nor the best model so far: the caller keeps it. Written
//      whole or not at all; the previous one stays.
// Layout: checkpoint_file.h; a JSON header, then the arrays of the state in the order of its
// members, float32 (steps of gains: int32) little-endian. Where Gaussians differ in SH degree, the
// header's `sh_blocks` has the elements of degree 0 … 3 of each set; they are stored in the order
// of ShBlocks::kOrder, with the bands that each has.
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
