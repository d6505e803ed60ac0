// Private words of earlier versions and the field's words in their place. A word is added when its
// last use is gone.
#pragma once
#include <string>
#include <vector>

namespace tessera {

struct BannedWord {
  const char *pattern, *instead;      // of regular expressions, without regard to case
  std::vector<std::string> except{};  // beginnings of paths that still have it
};

/// Adam's moments, and those of the windows of SSIM, are the only ones; pages name them, too.
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
                                                 "recon4d/evaluation/structure_scores",  // of SSIM
                                                 "docs/development/",
                                                 "docs/explanation/size.md"};

inline const std::vector<BannedWord> kBannedWords = {
    {R"(^\s*(//|#|"+).*\b(What|Not): )", "full sentences"},
    {R"(\bworths?\b)", "contribution"},
    {R"(parsimony)", "reduction, model reduction"},
    {R"(stillness)", "demotion to static"},
    {R"(\bbirths?\b)", "promotion to dynamic"},
    {R"(restless)", "time-varying"},
    {R"(\bhygiene\b)", "validity"},
    {R"(\bcensus\b)", "histogram"},
    {R"(\bthinn(ing|ed) out\b)", "pruned"},
    {R"(\bdimming\b)", "compensation"},
    {R"(\bMarkov chain\b)", "MCMC densification", {"docs/development/bibliography.md"}},
    {R"(\bset aside\b)", "validation frames; exclude, skip"},
    {R"(\bbegins anew\b)", "restarts"},
    {R"(\bfrontiers?\b)", "Pareto front"},
    {R"(\b(own|mine|there|at|of) = )", "a noun"},
    {R"(\bpictures?\b)",
     "image (file), frame (of a video), view (rendered)",
     {"static3d/formats/lossless_webp"}},  // a type of libwebp
    {R"(\bborn\b)", "added, spawned"},
    {R"(\blives\b)", "is, lies; temporal extent"},
    {R"(\bstilled\b)", "demoted"},
    {R"(\bfed\b)", "supplied, frame supply", {"recon4d/training/"}},
    {R"(\bdeserve[sd]?\b)", "reduces the error enough"},
    {R"(\bnobody\b)",
     "no view, no camera, no process",
     {"tools/batch/", "tools/camera_paths/", "tools/commands/", "tools/session/"}},
    {R"(\bgoes on\b)",
     "resumes, continues",
     {"tools/commands/", "tools/session/", "tests/tools/commands/"}},
    {R"(\bmended\b)", "fixed"},
    {R"(\bthe program (says|knows|wants|looks)\b)", "reports, has, requires, reads"},
    {R"(\bmoments?\b)", "timestep, time, timestamp", kOfAdam},
};

}  // namespace tessera
