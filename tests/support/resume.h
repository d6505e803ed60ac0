// A training resumed from a checkpoint, compared with one that was not interrupted.
#pragma once
#include <gtest/gtest.h>

#include "recon4d/model/checkpoint.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {

/// Saved after `half` steps, loaded and trained on, it ends as `whole` did; `saved` sees the state
/// that is saved.
template <class Saved>
void expect_resumes(const Scene& scene, const TrainOptions& options, int64_t half, Training& whole,
                    Saved&& saved) {
  Training first(scene, options);
  first.run(half);
  saved(first.state());
  const ScratchFolder folder;
  save_checkpoint(folder / "half.ckpt", first.state(), options, {});
  Checkpoint loaded = load_checkpoint(folder / "half.ckpt");
  ASSERT_TRUE(state_bits(loaded.state) == state_bits(first.state()));
  Training second(scene, loaded.options, std::move(loaded.state));
  second.run();
  EXPECT_TRUE(state_bits(second.state()) == state_bits(whole.state()));
}

}  // namespace tessera::testing
