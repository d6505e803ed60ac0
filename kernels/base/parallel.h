// A loop over independent chunks of [0, count) on all cores, by oneTBB (parallel_tbb.cpp) or, where
// it is absent, by std::thread (parallel_std.cpp).
#pragma once
#include <cstdint>
#include <functional>

namespace tessera {

/// Calls `body(begin, end)` for disjoint ranges of at most `grain` that cover [0, count). Ranges
/// start at multiples of `grain`, so work cut this way does not depend on the number of threads.
/// Exceptions of `body` reach the caller.
void parallel_for(int64_t count, int64_t grain,
                  const std::function<void(int64_t begin, int64_t end)>& body);

/// Threads that parallel_for uses; 0 sets it back to the machine's.
void set_thread_count(int count);
int thread_count();

/// Work beside other work: while one of these exists, parallel_for of this thread runs its ranges
/// one after another here and leaves the other cores alone.
class SerialSection {
 public:
  SerialSection() { ++sections_; }
  SerialSection(const SerialSection&) = delete;
  SerialSection& operator=(const SerialSection&) = delete;
  ~SerialSection() { --sections_; }

  /// Whether this thread is in one.
  static bool is_here() { return sections_ > 0; }

 private:
  static inline thread_local int sections_ = 0;
};

}  // namespace tessera
