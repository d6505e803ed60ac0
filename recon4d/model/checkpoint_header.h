// What: the JSON header of a checkpoint: every number of a training that is not in an array, and
//       how long the arrays are.
// Not: bytes (checkpoint_file.h).
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "recon4d/model/checkpoint.h"
#include "recon4d/model/checkpoint_file.h"

namespace tessera {

nlohmann::json checkpoint_header(const TrainState& state, const TrainOptions& options,
                                 const std::string& provenance, const ValidationRecord& validation);

/// Of the arrays that not every state has.
struct CheckpointParts {
  bool filter_sizes;
  int64_t exposures;       // rows
  int64_t exposure_width;  // numbers of a row
};
CheckpointParts parts_of(const TrainState& state);
CheckpointParts parts_of(const nlohmann::json& header);

/// The header of an opened checkpoint. Errors: InputError: not JSON.
nlohmann::json parse_checkpoint_header(const CheckpointReader& file);
/// A checkpoint without its arrays: its sets have their sizes, their values are not there yet. Its
/// numbers are held against each other and the size of the file before any memory is taken.
/// Errors: InputError: as refuse_checkpoint.
Checkpoint restored_without_arrays(const CheckpointReader& file, const nlohmann::json& header);

}  // namespace tessera
