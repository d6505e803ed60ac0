// What: asks the system.
// Not: what is free at present.
#include "tools/session/machine.h"

#include <unistd.h>

namespace tessera {

int64_t machine_memory() {
  return int64_t(::sysconf(_SC_PHYS_PAGES)) * int64_t(::sysconf(_SC_PAGESIZE));
}

}  // namespace tessera
