// Values that are optimised together, with Adam's moments of them.
#pragma once
#include "kernels/base/buffer.h"

namespace tessera {

struct ParameterGroup {
  explicit ParameterGroup(Memory& memory = host_memory())
      : value(memory), moment1(memory), moment2(memory) {}

  Buffer<float> value;  // [N, width]
  /// [N, width] Adam's m and v; empty in a model that only renders. Of groups that pack them both
  /// are in the words of moment1, and moment2 is empty.
  Buffer<float> moment1, moment2;
};

}  // namespace tessera
