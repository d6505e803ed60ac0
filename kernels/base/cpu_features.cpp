// Detection of the instructions of this CPU, and the message about missing ones. This file is
// compiled for any x86-64 and uses nothing that is compiled elsewhere, because it runs before it is
// known which instructions the machine can execute.
#include "kernels/base/cpu_features.h"

namespace tessera {
namespace {

class Line {
 public:
  Line(char* text, size_t size) : text_(text), size_(size) {
    if (size > 0) text[0] = 0;
  }
  void add(const char* more) {
    while (*more != 0 && length_ + 1 < size_) text_[length_++] = *more++;
    if (length_ < size_) text_[length_] = 0;
  }

 private:
  char* text_;
  size_t size_, length_ = 0;
};

}  // namespace

CpuFeatureSet supported_cpu_features() {
#if defined(__x86_64__)
  __builtin_cpu_init();
#endif
#define TESSERA_SUPPORTED(name, macro) __builtin_cpu_supports(name) != 0,
  return {{TESSERA_CPU_FEATURES(TESSERA_SUPPORTED) false}};
#undef TESSERA_SUPPORTED
}

void write_cpu_mismatch(const CpuFeatureSet& compiled, const CpuFeatureSet& supported, char* text,
                        size_t size) {
  Line line(text, size);
  bool any = false;
  for (size_t i = 0; i < kCpuFeatures; ++i) {
    if (!compiled.has[i] || supported.has[i]) continue;
    line.add(any ? ", " : "tessera: this program was compiled for a CPU with ");
    line.add(kCpuFeatureNames[i]);
    any = true;
  }
  if (any)
    line.add(
        ", which this one has not; configure with -DTESSERA_NATIVE=OFF for programs that are "
        "carried to other machines, or build on this one");
}

}  // namespace tessera
