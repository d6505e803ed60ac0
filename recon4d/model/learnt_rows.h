// Numbers that are learnt beside the Gaussians by rows of training frames, as the colours of images
// and the clocks of cameras are, with their state of Adam. They are no part of a model.
#pragma once
#include <algorithm>
#include <cstdint>

#include "kernels/base/buffer.h"

namespace tessera {

/// Always in the host's memory.
struct LearntRows {
  Buffer<float> value, moment1, moment2;  // [R, width]
  Buffer<int32_t> steps;                  // [R] of Adam so far; a row steps when it is drawn

  int64_t rows() const { return steps.size(); }
  int width() const { return rows() > 0 ? int(value.size() / rows()) : 0; }

  /// Zeros, nothing learnt.
  void reset(int64_t rows, int width) {
    for (Buffer<float>* values : {&value, &moment1, &moment2}) {
      values->resize(width * rows);
      std::fill(values->begin(), values->end(), 0.0f);
    }
    steps.resize(rows);
    std::fill(steps.begin(), steps.end(), 0);
  }

  LearntRows clone() const {
    Memory& host = host_memory();
    return {value.clone_to(host), moment1.clone_to(host), moment2.clone_to(host),
            steps.clone_to(host)};
  }
};

}  // namespace tessera
