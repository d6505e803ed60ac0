// `tessera bench SCENE`: time and bytes of every stage of a training step on a fixed load, or one
// row for each named ablation on it.
#pragma once
#include <string>

#include "recon4d/training/stage_bench.h"
#include "tools/cli/train_arguments.h"

namespace tessera {

struct StageBenchRequest {
  std::string scene;
  TrainArguments training;
  StageBenchOptions bench;
  std::string model;
  bool ablations = false;
  int64_t runs = 3;
  bool json = false;
};

/// Prints the result; returns an exit code. Errors: as bench_stages.
int bench_stages_command(StageBenchRequest request);

}  // namespace tessera
