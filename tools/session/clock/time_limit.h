// Computes when a training has to stop so that its state is saved before a time limit.
// train_session.h stops and saves.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace tessera {

/// Seconds of "7200", "7200s", "120m", "2h" or "1h30m". Errors: InputError naming what was typed.
double parse_duration(const std::string& text);

/// Seconds since the program began to work.
using Stopwatch = std::function<double()>;
Stopwatch running_stopwatch();

/// Knows how long a step, a save and a piece of work in between have taken so far, and keeps that
/// much room before the limit, saving twice, and a margin: 2 % of the limit, 1 s to 60 s.
class TimeLimit {
 public:
  /// `seconds`: 0 or less: no limit, never due.
  TimeLimit(double seconds, Stopwatch now);

  bool on() const { return seconds_ > 0; }
  double seconds() const { return on() ? seconds_ : std::numeric_limits<double>::infinity(); }

  /// Runs work that is not stopped before its end.
  template <class Work>
  void whole(Work&& work) {
    const double begin = now_();
    work();
    longest_work_ = std::max(longest_work_, now_() - begin);
  }
  /// A save of so many Gaussians; the time of the next grows with their number.
  template <class Work>
  void save(int64_t gaussians, Work&& work) {
    const double begin = now_();
    work();
    saved(now_() - begin, gaussians);
  }

  /// To be called before steps are taken, and due_after_step after each of them.
  void begin_steps() { stepped_ = now_(); }
  bool due_after_step(int64_t gaussians);
  /// Whether it is time to save and leave.
  bool due(int64_t gaussians) const;
  /// Whether it is time to leave where everything is saved.
  bool over() const;

 private:
  void saved(double seconds, int64_t gaussians);
  double margin() const { return std::clamp(0.02 * seconds_, 1.0, 60.0); }

  double seconds_;
  Stopwatch now_;
  double longest_work_ = 0, longest_step_ = 0, stepped_ = 0;  // seconds
  double save_seconds_ = 0, saved_gaussians_ = 1;             // of the slowest save by size
};

}  // namespace tessera
