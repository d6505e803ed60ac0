// The CPU instructions that this file, like all others, was compiled with.
#include "kernels/base/cpu_features.h"

namespace tessera {

// A macro that is defined is 1, else its own name.
#define TESSERA_TEXT(text) #text
#define TESSERA_IS_ON(name, macro) TESSERA_TEXT(macro)[0] == '1',
constexpr CpuFeatureSet kCompiledCpuFeatures{{TESSERA_CPU_FEATURES(TESSERA_IS_ON) false}};

}  // namespace tessera
