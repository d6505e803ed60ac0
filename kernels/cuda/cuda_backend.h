// The CUDA backend, in float and on one stream. The host waits only where backend.h states it. Each
// stage is defined in the file of its name in stages/, edits/ or measures/.
#pragma once
#include <cuda_runtime.h>

#include "kernels/backend.h"
#include "kernels/cuda/device_clock.h"
#include "kernels/cuda/device_memory.h"

namespace tessera {

/// What kernels of a step count, copied back as one block.
struct StepCounters {
  unsigned long long splats, instances;
  unsigned invalid, bad_groups, bad_values;
};

/// To 1, in which gradients by times are added: sums of whole numbers have no order.
inline constexpr double kTimeSteps = 4294967296.0;

/// Memory of the host that the device can write to while the host continues.
template <class T>
class PinnedArray {
 public:
  PinnedArray() = default;
  PinnedArray(const PinnedArray&) = delete;
  ~PinnedArray() { cudaFreeHost(data_); }
  T* reserve(int64_t count);
  T* data() { return data_; }

 private:
  T* data_ = nullptr;
  int64_t capacity_ = 0;
};

/// What a batch is compared with, on the device. Pointers are null where there is nothing.
struct DeviceTarget {
  const uint8_t* const* truth = nullptr;  // [B] each [height, width, 3]
  const uint8_t* const* mask = nullptr;   // [B] each [height, width] or null
  const float* response = nullptr;        // [B, 3]

  /// Whether a view's pixel adds to the error.
  TESSERA_HD bool counts(int64_t view, int64_t pixel) const {
    return mask == nullptr || mask[view] == nullptr || mask[view][pixel] != 0;
  }
  /// Without a mask every pixel does.
  TESSERA_HD bool moves(int64_t view, int64_t pixel) const {
    return mask == nullptr || mask[view] == nullptr || mask[view][pixel] == kMovingPixel;
  }
  TESSERA_HD bool may_move(int64_t view, int64_t pixel) const {
    return mask == nullptr || mask[view] == nullptr || tessera::may_move(mask[view][pixel]);
  }
  TESSERA_HD float response_of(int64_t view, int channel) const {
    return response == nullptr ? 1.0f : response[3 * view + channel];
  }
};

struct BlendBackward;  // blend_backward_args.cuh

class CudaBackend final : public Backend {
 public:
  explicit CudaBackend(int device = 0);
  ~CudaBackend() override;
  std::string name() const override { return name_; }
  Memory& memory() override { return memory_; }
  StageClock& clock() override { return clock_; }
  std::function<std::unique_ptr<Backend>()> another() override {
    return [device = device_] { return std::make_unique<CudaBackend>(device); };
  }
  std::unique_ptr<PixelSearch> pixel_search() override;
  cudaStream_t stream() const { return stream_; }

  using Real = float;
#define OPERATION(result, name, parameters, names) result name parameters override;
#include "kernels/operations.inc"

 private:
  struct Stream {
    cudaStream_t handle = nullptr;
    explicit Stream(int device);
    ~Stream() { cudaStreamDestroy(handle); }
  };

  /// The batch's views on the device; copied there when they are not the last ones.
  const ViewArgs<float>* views_of(const ViewBatch<float>& batch);
  template <class Key>
  void bin_with(const BinArgs<float>& args, TileInstances<float>& instances);
  void order_tiles(TileInstances<float>& instances);
  void write_splats(const ProjectArgs<float>& args, Splats<float>& splats);
  void reserve_checkpoints(const BlendArgs<float>& args);
  bool is_small(const ViewBatch<float>& batch) const;
  /// What a walk over the splats of a pass reads; `sums` is added to.
  BlendBackward pass_of(const BlendBackwardArgs<float>& args, float* sums);
  /// Pointers and responses on their way to the device, valid until the next call.
  DeviceTarget target_of(const std::vector<Span<const uint8_t>>& truth,
                         const std::vector<Span<const uint8_t>>& mask,
                         const std::vector<Vec3<double>>& response = {});
  /// The maps on the device; copied there when they are not the last ones.
  const ColourMap<float>* maps_of(const ColourMapArgs<float>& args);
  /// Enqueues the copy of losses and of what was not finite to the host.
  void report();

  Stream own_stream_;  // on the device; before everything that frees memory on it
  cudaStream_t stream_ = own_stream_.handle;
  DeviceMemory memory_{stream_};
  DeviceStageClock clock_{stream_};
  std::string name_;
  int device_;          // number of the device
  int processors_ = 1;  // of it
  cudaEvent_t reported_ = nullptr, views_copied_ = nullptr, target_copied_ = nullptr,
              maps_copied_ = nullptr;

  Buffer<ViewArgs<float>> views_{memory_};  // [B] of the batch last projected
  PinnedArray<ViewArgs<float>> views_host_;
  Buffer<const uint8_t*> truth_{memory_};  // [B], with masks [2·B]
  PinnedArray<const uint8_t*> truth_host_;
  Buffer<StepCounters> counters_{memory_};
  PinnedArray<StepCounters> counters_host_;  // [2] after project, after the step
  Buffer<float> response_{memory_};          // [B, 3]
  PinnedArray<float> response_host_;
  Buffer<ColourMap<float>> maps_{memory_};  // [B]
  PinnedArray<ColourMap<float>> maps_host_;
  Buffer<ColourMap<double>> map_sums_{memory_};  // [B] dL/d map; empty: not asked since photometric
  PinnedArray<ColourMap<double>> map_sums_host_;
  Buffer<long long> time_sums_{memory_};  // [B] as project_backward has them; empty: not asked
  PinnedArray<long long> time_sums_host_;
  Buffer<double> loss_sums_{memory_};  // [B, 2] Σ|I−G|, Σ SSIM
  PinnedArray<double> loss_sums_host_;
  std::vector<ViewArgs<float>> loss_views_;  // whose loss is in loss_sums_
  LossWeights loss_weights_;

  Buffer<int32_t> visible_{memory_};       // [N] how many views draw a Gaussian
  Buffer<uint32_t> seen_by_{memory_};      // [N, words] a bit for each of them
  Buffer<uint8_t> scratch_{memory_};       // of the stage that runs
  Buffer<uint8_t> sort_scratch_{memory_};  // of the library's sorts and scans
  bool has_checkpoints_ = false;           // of the last blend
  Buffer<float4> checkpoints_{memory_};    // [checkpoints, 256] colour and T
  Buffer<int64_t> bucket_begin_{memory_};  // [tiles+1]
  Buffer<float> instance_sums_{memory_};   // [parts, I, terms] when they are added in order
};

}  // namespace tessera
