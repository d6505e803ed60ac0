// `parallel_for` on std::thread, for builds without oneTBB. Threads are started in each call, which
// costs about 20 µs.
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

int requested_threads = 0;

}  // namespace

void parallel_for(int64_t count, int64_t grain, const std::function<void(int64_t, int64_t)>& body) {
  if (count <= 0) return;
  const int64_t chunks = (count + grain - 1) / grain;
  const int workers = int(std::min<int64_t>(thread_count(), chunks));
  if (workers == 1 || SerialSection::is_here()) {
    for (int64_t c = 0; c < chunks; ++c) body(c * grain, std::min(count, (c + 1) * grain));
    return;
  }
  std::atomic<int64_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (int64_t c = next++; c < chunks; c = next++)
        body(c * grain, std::min(count, (c + 1) * grain));
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      failure = std::current_exception();
      next = chunks;
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(static_cast<size_t>(workers));
  try {
    for (int i = 1; i < workers; ++i) threads.emplace_back(work);
  } catch (const std::system_error&) {
    // the system gives no more threads (pids limit, memory): those that run do the work
  }
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

void set_thread_count(int count) {
  requested_threads = count;
}

int thread_count() {
  return requested_threads > 0 ? requested_threads
                               : std::max(1, int(std::thread::hardware_concurrency()));
}

}  // namespace tessera
