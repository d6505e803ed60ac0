// The report of a batch as one object: its runs, medians and spreads by scene and variant,
// failures, versions, devices, options.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tools/batch/batch_folder.h"

namespace tessera {

/// report.json of a batch (docs/reference/report-json.md), schema 1, but for the images of its
/// views: `runs` are the requested ones, `batch` is what they have in common. A file that is
/// damaged is a note.
nlohmann::json batch_report(const BatchFolder& batch);

}  // namespace tessera
