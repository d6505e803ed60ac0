// Comparison of the instructions that the program was compiled with and those that this CPU has. A
// build is for the machine that made it (-march=native) but may be copied to another one. On
// processors other than x86-64 the list is empty.
#pragma once
#include <cstddef>

/// X(name as __builtin_cpu_supports has it, the compiler's macro).
#if defined(__x86_64__) && !defined(__clang__)
// Names that clang 14 does not have.
#define TESSERA_MORE_CPU_FEATURES(X) \
  X("lzcnt", __LZCNT__)              \
  X("f16c", __F16C__)                \
  X("movbe", __MOVBE__)              \
  X("adx", __ADX__)                  \
  X("sha", __SHA__)                  \
  X("vaes", __VAES__)                \
  X("avxvnni", __AVXVNNI__)          \
  X("avx512fp16", __AVX512FP16__)
#else
#define TESSERA_MORE_CPU_FEATURES(X)
#endif
#if defined(__x86_64__)
#define TESSERA_CPU_FEATURES(X)             \
  TESSERA_MORE_CPU_FEATURES(X)              \
  X("sse3", __SSE3__)                       \
  X("ssse3", __SSSE3__)                     \
  X("sse4.1", __SSE4_1__)                   \
  X("sse4.2", __SSE4_2__)                   \
  X("popcnt", __POPCNT__)                   \
  X("sse4a", __SSE4A__)                     \
  X("avx", __AVX__)                         \
  X("avx2", __AVX2__)                       \
  X("fma", __FMA__)                         \
  X("fma4", __FMA4__)                       \
  X("xop", __XOP__)                         \
  X("bmi", __BMI__)                         \
  X("bmi2", __BMI2__)                       \
  X("aes", __AES__)                         \
  X("pclmul", __PCLMUL__)                   \
  X("gfni", __GFNI__)                       \
  X("vpclmulqdq", __VPCLMULQDQ__)           \
  X("avx512f", __AVX512F__)                 \
  X("avx512bw", __AVX512BW__)               \
  X("avx512cd", __AVX512CD__)               \
  X("avx512dq", __AVX512DQ__)               \
  X("avx512vl", __AVX512VL__)               \
  X("avx512ifma", __AVX512IFMA__)           \
  X("avx512vbmi", __AVX512VBMI__)           \
  X("avx512vbmi2", __AVX512VBMI2__)         \
  X("avx512vnni", __AVX512VNNI__)           \
  X("avx512bitalg", __AVX512BITALG__)       \
  X("avx512vpopcntdq", __AVX512VPOPCNTDQ__) \
  X("avx512bf16", __AVX512BF16__)           \
  X("avx512vp2intersect", __AVX512VP2INTERSECT__)
#else
#define TESSERA_CPU_FEATURES(X)
#endif

namespace tessera {

#define TESSERA_NAME(name, macro) name,
inline constexpr const char* kCpuFeatureNames[] = {TESSERA_CPU_FEATURES(TESSERA_NAME) nullptr};
#undef TESSERA_NAME
inline constexpr size_t kCpuFeatures = sizeof(kCpuFeatureNames) / sizeof(kCpuFeatureNames[0]) - 1;

/// In the order of the list. Constant data: no code runs to make it.
struct CpuFeatureSet {
  bool has[kCpuFeatures + 1];
};

/// Of the sources that were compiled for the machine of the build.
extern const CpuFeatureSet kCompiledCpuFeatures;
/// Of this CPU and its operating system.
CpuFeatureSet supported_cpu_features();
/// Why a program compiled for `compiled` cannot run here, one line with the missing ones and the
/// remedy, cut to `size`; "" where it can. Allocates nothing and calls nothing of the C++ library:
/// what the linker takes of that may be compiled for the other machine.
void write_cpu_mismatch(const CpuFeatureSet& compiled, const CpuFeatureSet& supported, char* text,
                        size_t size);

}  // namespace tessera
