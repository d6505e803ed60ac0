// Ends the program with one line when it was compiled for a CPU with other features. The check runs
// before all other code, static objects included; without it the program would end with SIGILL.
// This file is compiled for any x86-64; kernels/base/cpu_features.h has the comparison.
#include <string.h>
#include <unistd.h>

#include "kernels/base/cpu_features.h"

namespace tessera {
namespace {

constexpr int kFirst = 101;  // the priority that comes before all that a program may have

__attribute__((constructor(kFirst))) void refuse_another_cpu() {
  char line[1024];
  write_cpu_mismatch(kCompiledCpuFeatures, supported_cpu_features(), line, sizeof(line) - 1);
  size_t length = strlen(line);
  if (length == 0) return;
  line[length++] = '\n';
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line, length);
  _exit(1);
}

}  // namespace
}  // namespace tessera
