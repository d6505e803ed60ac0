// What: private words of earlier versions, and what the field says in their place.
// Not: a dictionary: a word is banned when its last use is gone.
#pragma once
#include <string>
#include <vector>

namespace tessera {

struct BannedWord {
  const char *pattern, *instead;      // of regular expressions, without regard to case
  std::vector<std::string> except{};  // beginnings of paths
};

/// Adam's moments, and those of the windows of SSIM, are the only ones.
inline const std::vector<std::string> kOfAdam = {"kernels/",
                                                 "recon4d/model/",
                                                 "recon4d/density/",
                                                 "recon4d/training/",
                                                 "recon4d/options/",
                                                 "tests/kernels/",
                                                 "tests/recon4d/model/",
                                                 "tests/recon4d/density/",
                                                 "tests/support/",
                                                 "tests/recon4d/training/",
                                                 "tests/recon4d/options/",
                                                 "recon4d/evaluation/structure_scores"};  // of SSIM

inline const std::vector<BannedWord> kBannedWords = {
    {R"(\bworths?\b)", "contribution"},
    {R"(parsimony)", "reduction, model reduction"},
    {R"(stillness)", "demotion to static"},
    {R"(\bbirths?\b)", "promotion to dynamic"},
    {R"(restless)", "time-varying"},
    {R"(\bhygiene\b)", "validity"},
    {R"(\bcensus\b)", "histogram"},
    {R"(\bthinn(ing|ed) out\b)", "pruned"},
    {R"(\bdimming\b)", "compensation"},
    {R"(\bMarkov chain\b)", "MCMC densification"},
    {R"(\bframes (that are )?set aside\b)", "validation frames"},
    {R"(\bbegins anew\b)", "restarts"},
    {R"(\bfrontiers?\b)", "Pareto front", {"tools/bench/", "tests/tools/bench/"}},  // a JSON key
    {R"(\b(own|mine|there|at|of) = )", "a noun"},
    {R"(\bpictures?\b)", "image (file), frame (of a video), view (rendered)"},
    {R"(\bmoments?\b)", "timestep, time, timestamp", kOfAdam},
};

}  // namespace tessera
