// A program compiled for every feature in the list, which no CPU supports together (AMD removed xop
// before it had avx512f). It reports when any of its code runs. See cpu_guard_test.cpp.
#include <cstdio>

#include "kernels/base/cpu_features.h"

namespace tessera {

#define TESSERA_ALL(name, macro) true,
constexpr CpuFeatureSet kCompiledCpuFeatures{{TESSERA_CPU_FEATURES(TESSERA_ALL) true}};

namespace {

void report(const char* what) {
  std::puts(what);
  std::fflush(stdout);  // _exit would lose it
}

struct Early {
  Early() { report("a static object runs"); }
};
const Early early;

}  // namespace
}  // namespace tessera

int main() {
  tessera::report("main runs");
}
