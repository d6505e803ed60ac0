// What: Ctrl-C and SIGTERM as a flag that long work asks for; the second one ends at once.
// Not: cleaning up in a signal handler.
#pragma once
#include <exception>

namespace tessera {

/// What leaves work that has no other way to stop; main turns it into exit code 130.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

void install_interrupt_handlers();
bool interrupted();
/// For progress callbacks. Errors: Interrupted.
void stop_if_interrupted();

}  // namespace tessera
