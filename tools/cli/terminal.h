// Output on stderr: messages, warnings, and a progress bar with the remaining time, or a line every
// ten seconds where stderr is no terminal. Results go to stdout (print_result).
#pragma once
#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace tessera {

/// How much the program prints on stderr: warnings and errors alone; messages and progress as well;
/// also the details that are left out by default.
enum class Verbosity { kQuiet, kNormal, kVerbose };
void set_verbosity(Verbosity verbosity);
Verbosity verbosity();
inline bool is_verbose() {
  return verbosity() == Verbosity::kVerbose;
}

/// One message on stderr, with a running progress bar moved out of the way; none with --quiet.
void say(const std::string& line);
/// Warnings and errors are printed with --quiet as well. "warning:" is yellow on a terminal, unless
/// NO_COLOR is set (https://no-color.org) or TERM is dumb.
void warn(const std::string& line);
void report_error(const std::string& line);

/// The result of a command on stdout: one JSON object with --json, else the given text.
void print_result(bool as_json, const nlohmann::json& json, const std::string& text);

/// "12:34" or "1:02:03".
std::string clock_time(double seconds);
/// "3.2 s" below a minute, else as clock_time.
std::string duration_text(double seconds);
/// "4.8 MB", "12.0 kB"; units of 1000.
std::string size_text(int64_t bytes);

/// Columns of the terminal on stderr; COLUMNS where the terminal reports none, else 80.
int terminal_columns();

/// A bar for the stages of one command: its clock restarts where counting does. `update` may be
/// called at any rate: it draws at most ten times a second on a terminal, one line that fits it,
/// every ten seconds elsewhere, and nothing with --quiet.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();
  /// `first` is where counting began (a resumed run): the ETA is by what was done since.
  void update(int64_t done, int64_t total, std::string_view note = {}, int64_t first = 0);
  void clear();

 private:
  std::string label_;
  std::chrono::steady_clock::time_point begin_, drawn_;
  int64_t done_ = 0, total_ = 0;  // of the last call: fewer, or of another total, is a new stage
  bool on_terminal_, visible_ = false;
};

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

/// Adds -q/--quiet and -v/--verbose to every subcommand of the root `app`; they set the verbosity.
/// To be called once, after the commands are added.
void add_verbosity(CLI::App& app);

}  // namespace tessera
