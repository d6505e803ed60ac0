// Fisher–Yates shuffle with counter-based numbers; the result of std::shuffle differs between
// standard libraries.
#include "recon4d/training/batch_sampler.h"

#include <numeric>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/math/random.h"

namespace tessera {

BatchSampler::BatchSampler(int64_t count, uint64_t seed) : count_(count), seed_(seed) {
  check(count > 0, "BatchSampler: no frames");
  shuffle();
}

void BatchSampler::shuffle() {
  order_.resize(size_t(count_));
  std::iota(order_.begin(), order_.end(), int64_t{0});
  for (int64_t i = count_ - 1; i > 0; --i) {
    const RandomBlock block = philox(seed_, RandomStream::kSampler, uint64_t(i), uint32_t(epoch_));
    const uint64_t draw = uint64_t(block.word[0]) << 32 | block.word[1];
    std::swap(order_[size_t(i)], order_[size_t(draw % uint64_t(i + 1))]);
  }
}

std::vector<int64_t> BatchSampler::next(int64_t batch) {
  std::vector<int64_t> indices;
  for (int64_t b = 0; b < batch; ++b) {
    if (position_ == count_) {
      ++epoch_;
      position_ = 0;
      shuffle();
    }
    indices.push_back(order_[size_t(position_++)]);
  }
  return indices;
}

std::vector<int64_t> BatchSampler::peek(int64_t skip, int64_t batch) const {
  BatchSampler ahead = *this;
  ahead.next(skip * batch);
  return ahead.next(batch);
}

void BatchSampler::restore(int64_t epoch, int64_t position) {
  check(position >= 0 && position <= count_, "BatchSampler: position outside the permutation");
  epoch_ = epoch;
  position_ = position;
  shuffle();
}

}  // namespace tessera
