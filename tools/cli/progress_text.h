// What: how far a stage of known or unknown length has come, in words.
// Not: the bar, or when it is drawn (terminal.h).
#pragma once
#include <cstdint>
#include <string>

namespace tessera {

struct Progress {
  int64_t done = 0, total = 0;  // total 0: not known
  int64_t first = 0;            // where counting began (a resumed run)
  double seconds = 0;           // since then
};

/// In [0, 1]; 0 where the total is not known or is exceeded.
double progress_share(const Progress& progress);

/// "3/12 (25 %) 0:09 left", without the time before the first step. Where the total is not known,
/// or is exceeded, neither share nor time: "3 done", and nothing before the first step.
std::string progress_text(const Progress& progress);

}  // namespace tessera
