// What: How far a stage of known or unknown length has come, in words and as a bar.
// Not: when it is drawn (terminal.h).
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

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

/// "train 3/12 (25 %) 0:09 left loss 0.1".
std::string progress_line(std::string_view label, const Progress& progress, std::string_view note);

/// "train [===         ] 3/12 (25 %) 0:09 left loss 0.1" in fewer characters than `columns`, so
/// that the terminal does not wrap it: the note is dropped first, then the bar shrinks until it is
/// dropped, too, and in the end the text is cut.
std::string bar_line(std::string_view label, const Progress& progress, std::string_view note,
                     int columns);

}  // namespace tessera
