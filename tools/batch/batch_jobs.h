// The jobs of a batch. Their names are the places of their results: ingest/SCENE,
// train/SCENE/VARIANT/seed-S, evaluate/SCENE/VARIANT/seed-S, export/SCENE/VARIANT/seed-S/FORMAT.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tools/batch/batch.h"
#include "tools/jobs/job.h"

namespace tessera {

/// In an order in which each finds its inputs; words start in the folder of the batch. `at_once`:
/// jobs that share the cards of the machine.
std::vector<Job> jobs_of(const Batch& batch, int64_t at_once);

/// What a job takes by the forecast for its prepared scene in `folder`, which is there when it is
/// started; what the list states where it is not.
JobUses forecast_uses(const Job& job, const Batch& batch, const std::filesystem::path& folder);

}  // namespace tessera
