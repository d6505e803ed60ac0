// What: the instructions that this file, as all others, was compiled with.
// Not: what this CPU has (cpu_features.cpp).
#include "kernels/base/cpu_features.h"

namespace tessera {

// A macro that is defined is 1, else its own name.
#define TESSERA_TEXT(text) #text
#define TESSERA_IS_ON(name, macro) TESSERA_TEXT(macro)[0] == '1',
constexpr CpuFeatureSet kCompiledCpuFeatures{{TESSERA_CPU_FEATURES(TESSERA_IS_ON) false}};

}  // namespace tessera
