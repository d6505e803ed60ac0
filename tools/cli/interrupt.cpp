// The signal handlers set flags and do no other work.
#include "tools/cli/interrupt.h"

#include <csignal>

namespace tessera {
namespace {

volatile std::sig_atomic_t flag = 0, by_hand = 0;

void on_interrupt(int signal) {
  if (by_hand != 0) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  by_hand = 1;
  flag = 1;
}

/// A scheduler may send both, and more than once; SIGKILL is its last.
void on_eviction(int) {
  flag = 1;
}

}  // namespace

void install_interrupt_handlers() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_eviction);
  if (std::signal(SIGHUP, SIG_IGN) != SIG_IGN) std::signal(SIGHUP, on_eviction);  // else nohup
  std::signal(SIGUSR1, on_eviction);
}

bool interrupted() {
  return flag != 0;
}

void stop_if_interrupted() {
  if (interrupted()) throw Interrupted();
}

int stop_code() {
  return by_hand != 0 ? kExitInterrupted : kExitNotFinished;
}

int stop_signal() {
  return !interrupted() ? 0 : stop_code() == kExitInterrupted ? SIGINT : SIGTERM;
}

}  // namespace tessera
