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

/// [frames] masks of frames.
using FrameMasks = std::vector<FrameMask>;

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

  /// Of a training frame, on the host.
  Span<const uint8_t> mask_on_host(int64_t index) const {
    const std::vector<uint8_t>& mask = this->mask(index).data();
    return {mask.data(), int64_t(mask.size())};
  }
  /// Whether masks say what moves.
  bool knows_motion() const { return !masks_.empty(); }

  /// Whether every frame lies on a device for as long as the cache does.
  bool is_resident() const { return kept_ == Kept::kResident; }
  /// The number of batches that `prefetch` takes.
  int64_t ahead() const { return kept_ == Kept::kInRing ? kSlots - 1 : 0; }
  /// Begins to bring over the batches of the next steps, over those of steps before the one whose
  /// `truth` was asked for last. These must be done: call it after the forward pass of that step.
  void prefetch(const std::vector<std::vector<int64_t>>& upcoming);

 private:
  enum class Kept { kOnHost, kResident, kInRing };
  struct Place {
    int64_t image, mask;  // byte offsets in one buffer
  };
  static constexpr int64_t kSlots = 3;  // this step's, the next one's, and the one being filled

  /// Images one behind another, each mask once, in one buffer.
  struct Layout {
    std::vector<Place> places;  // of the frames that it was made for
    int64_t bytes = 0;
  };
  struct Slot {
    explicit Slot(Memory& memory) : bytes(memory) {}
    std::vector<int64_t> indices;
    Layout layout;  // of these
    Buffer<uint8_t> bytes;
  };

  const Frame& frame(int64_t index) const { return scene_.frames[size_t(frames_[size_t(index)])]; }
  const FrameMask& mask(int64_t index) const {
    return masks_.empty() ? frame(index).mask : masks_[size_t(index)];
  }
  Layout layout_of(const std::vector<int64_t>& indices) const;
  /// Begins to bring frames over to `to`.
  void copy(const std::vector<int64_t>& indices, const Layout& layout, uint8_t* to);
  void append(int64_t index, const uint8_t* image, const uint8_t* mask, TargetImages& fed) const;
  void set_up_ring(int64_t batch);
  Slot* find(const std::vector<int64_t>& indices);
  void fill(Slot& slot, const std::vector<int64_t>& indices);

  Memory& memory_;
  const Scene& scene_;
  std::vector<int> frames_;
  FrameMasks masks_;
  Kept kept_ = Kept::kOnHost;
  Buffer<uint8_t> resident_;
  std::vector<Place> places_;  // [frames] in `resident_`
  std::vector<const uint8_t*> pinned_;
  std::vector<Slot> slots_;
  std::vector<int64_t> current_;  // the last arguments of `truth`
};

/// [frames] each 0 where the frame's own mask ignores a pixel, kMovingPixel where it differs from
/// the median over time of its camera, else kStillPixel. Where the camera moves or has fewer than
/// three timesteps, kUnknownPixel, and empty where the frame has no mask. `frames`: places in the
/// scene.
FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames);

}  // namespace tessera
