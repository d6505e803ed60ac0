// The training frames of a step: B consecutive ones of a permutation without replacement.
// Permutation e follows from (seed, e), so a checkpoint stores two numbers. Source: method A.3 step
// 6, D.6.
#pragma once
#include <cstdint>
#include <vector>

namespace tessera {

class BatchSampler {
 public:
  /// `count` training frames, at least 1.
  BatchSampler(int64_t count, uint64_t seed);

  /// The next B indices in [0, count); a permutation is used up before the next begins.
  std::vector<int64_t> next(int64_t batch);

  /// What `next` will give after `skip` calls more; nothing is used up.
  std::vector<int64_t> peek(int64_t skip, int64_t batch) const;

  int64_t epoch() const { return epoch_; }
  int64_t position() const { return position_; }
  void restore(int64_t epoch, int64_t position);

 private:
  void shuffle();

  int64_t count_;
  uint64_t seed_;
  int64_t epoch_ = 0, position_ = 0;
  std::vector<int64_t> order_;
};

}  // namespace tessera
