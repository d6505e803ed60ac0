// Threads that work beside a training.
#pragma once
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>

namespace tessera {

/// Of this thread alone: Linux has a priority for each. 19: the lowest.
inline void lower_priority(int nice) {
  setpriority(PRIO_PROCESS, id_t(::syscall(SYS_gettid)), nice);
}

/// CPU seconds of this thread so far.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

}  // namespace tessera
