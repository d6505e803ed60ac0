// Means of the scores of views: over all of an evaluation, and over those outside training apart.
#pragma once
#include <vector>

#include "recon4d/evaluation/evaluate.h"

namespace tessera {

MeanScore mean_score(const std::vector<ViewScore>& views);

/// Fills in the means of a report that has its views.
void add_means(EvaluationReport& report);

}  // namespace tessera
