// What: ends the program with one line where it was compiled for another CPU, before anything of it
// runs, static objects included; without this it would end with SIGILL somewhere.
// Not: the comparison (kernels/base/cpu_features.h). Compiled for any x86-64.
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
