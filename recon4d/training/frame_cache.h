// The ground truth of a step in memory that the backend can read, with its masks. On the host it is
// the frames themselves; on a device it is all frames at once or, where they do not fit, a ring
// that is filled ahead of the steps.
#pragma once
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/buffer.h"

namespace tessera {

/// Of a batch, as PhotometricArgs takes it.
struct TargetImages {
  std::vector<Span<const uint8_t>> images;  // [B] each [height, width, 3]
  std::vector<Span<const uint8_t>> masks;   // [B] each [height, width], or empty: no mask
};

/// [frames] masks of frames, each [height, width] or empty.
using FrameMasks = std::vector<std::vector<uint8_t>>;

/// Places of the training frames in a scene. Errors: InputError: there are none.
std::vector<int> training_frames(const Scene& scene);

class FrameCache {
 public:
  /// `frames`: places of the training frames in the scene, which must outlive the cache. `budget`:
  /// bytes for frames; 0: what is free but for a reserve. `batch`: frames of a step. `masks`: one
  /// for each of these frames, in place of its own; empty: their own. Errors: InputError: no
  /// frames.
  FrameCache(Memory& memory, const Scene& scene, std::vector<int> frames, int64_t budget,
             int64_t batch, FrameMasks masks = {});
  FrameCache(const FrameCache&) = delete;
  ~FrameCache();

  /// Of training frames `indices`, for what is computed next.
  TargetImages truth(const std::vector<int64_t>& indices);

  /// Whether every frame lies on a device for as long as the cache does.
  bool is_resident() const { return place_ == Place::kResident; }
  /// The number of batches that `prefetch` takes.
  int64_t ahead() const { return place_ == Place::kRing ? kSlots - 1 : 0; }
  /// Begins to bring over the batches of the next steps, over those of steps before the one whose
  /// `truth` was asked for last. These must be done: call it after the forward pass of that step.
  void prefetch(const std::vector<std::vector<int64_t>>& upcoming);

 private:
  enum class Place { kHost, kResident, kRing };
  static constexpr int64_t kSlots = 3;  // this step's, the next one's, and the one being filled

  struct Slot {
    explicit Slot(Memory& memory) : bytes(memory) {}
    std::vector<int64_t> indices;
    Buffer<uint8_t> bytes;
  };

  const Frame& frame(int64_t index) const { return scene_.frames[size_t(frames_[size_t(index)])]; }
  const std::vector<uint8_t>& mask(int64_t index) const {
    return masks_.empty() ? frame(index).mask.data : masks_[size_t(index)];
  }
  /// What a frame takes: its mask lies behind its image.
  int64_t bytes_of(int64_t index) const;
  /// A frame that copy_frame copied to `bytes`.
  void append_copied(int64_t index, const uint8_t* bytes, TargetImages& fed) const;
  void upload_all();
  /// Begins to bring a frame over to `to`: its image, then its mask.
  void copy_frame(int64_t index, uint8_t* to);
  Slot* find(const std::vector<int64_t>& indices);
  void fill(Slot& slot, const std::vector<int64_t>& indices);

  Memory& memory_;
  const Scene& scene_;
  std::vector<int> frames_;
  FrameMasks masks_;
  Place place_ = Place::kHost;
  Buffer<uint8_t> resident_;
  std::vector<int64_t> offset_;  // [frames] of each in `resident_`
  std::vector<Slot> slots_;
  std::vector<int64_t> current_;  // the last arguments of `truth`
};

/// [frames] each [height, width]: 0 where the frame's own mask ignores a pixel, kMovingPixel where
/// it differs from the median over time of its camera, else 1. Empty where the camera moves or has
/// fewer than three timesteps and the frame has no mask. `frames`: places in the scene.
FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames);

}  // namespace tessera
