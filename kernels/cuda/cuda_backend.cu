// The device, the stream and the transfers between host and device in a step, and the checks of
// CUDA's return codes.
#include "kernels/cuda/cuda_backend.h"

#include <algorithm>
#include <cstring>

#include "kernels/base/errors.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {

template <class T>
T* PinnedArray<T>::reserve(int64_t count) {
  if (count <= capacity_) return data_;
  cudaFreeHost(data_);
  data_ = nullptr;
  check_device(cudaMallocHost(reinterpret_cast<void**>(&data_), sizeof(T) * size_t(count)),
               "cudaMallocHost");
  capacity_ = count;
  return data_;
}
template class PinnedArray<ViewArgs<float>>;
template class PinnedArray<const uint8_t*>;
template class PinnedArray<StepCounters>;
template class PinnedArray<float>;
template class PinnedArray<double>;
template class PinnedArray<ColourMap<float>>;
template class PinnedArray<ColourMap<double>>;

CudaBackend::Stream::Stream(int device) {
  int devices = 0;
  const cudaError_t found = cudaGetDeviceCount(&devices);
  if (found != cudaSuccess || devices == 0)
    throw DeviceError(std::string("no CUDA device: ") +
                      (found != cudaSuccess ? cudaGetErrorString(found) : "none is present") +
                      "; use --backend cpu");
  check_device(cudaSetDevice(device), "cudaSetDevice");
  check_device(cudaStreamCreateWithFlags(&handle, cudaStreamNonBlocking), "cudaStreamCreate");
}

CudaBackend::CudaBackend(int device) : own_stream_(device), device_(device) {
  cudaDeviceProp properties{};
  check_device(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
  processors_ = properties.multiProcessorCount;
  name_ = std::string("cuda, ") + properties.name;
  for (cudaEvent_t* event : {&reported_, &views_copied_, &target_copied_, &maps_copied_})
    check_device(cudaEventCreateWithFlags(event, cudaEventDisableTiming), "cudaEventCreate");
  counters_.resize(1);
  check_device(cudaMemsetAsync(counters_.data(), 0, sizeof(StepCounters), stream_), "memset");
  counters_host_.reserve(2);
}

CudaBackend::~CudaBackend() {
  cudaStreamSynchronize(stream_);
  for (cudaEvent_t event : {reported_, views_copied_, target_copied_, maps_copied_})
    cudaEventDestroy(event);
}

const ViewArgs<float>* CudaBackend::views_of(const ViewBatch<float>& batch) {
  const size_t count = batch.views.size(), bytes = sizeof(ViewArgs<float>) * count;
  if (int64_t(count) == views_.size() &&
      std::equal(batch.views.begin(), batch.views.end(), views_host_.data()))
    return views_.data();
  check_device(cudaEventSynchronize(views_copied_), "waiting for the last copy of views");
  std::memcpy(views_host_.reserve(int64_t(count)), batch.views.data(), bytes);
  views_.resize(int64_t(count));
  check_device(
      cudaMemcpyAsync(views_.data(), views_host_.data(), bytes, cudaMemcpyHostToDevice, stream_),
      "copy of views");
  check_device(cudaEventRecord(views_copied_, stream_), "cudaEventRecord");
  return views_.data();
}

void CudaBackend::report() {
  const auto fetch = [this](const auto& from, auto& to, const char* what) {
    if (from.size() == 0) return;
    check_device(cudaMemcpyAsync(to.reserve(from.size()), from.data(),
                                 sizeof(*from.data()) * size_t(from.size()), cudaMemcpyDeviceToHost,
                                 stream_),
                 what);
  };
  fetch(loss_sums_, loss_sums_host_, "copy of losses");
  fetch(map_sums_, map_sums_host_, "copy of gradients by maps of colours");
  fetch(time_sums_, time_sums_host_, "copy of gradients by times");
  check_device(cudaMemcpyAsync(counters_host_.data() + 1, counters_.data(), sizeof(StepCounters),
                               cudaMemcpyDeviceToHost, stream_),
               "copy of counters");
  check_device(cudaEventRecord(reported_, stream_), "cudaEventRecord");
}

StepOutcome CudaBackend::outcome() {
  check_device(cudaEventSynchronize(reported_), "waiting for a step");
  StepOutcome outcome;
  outcome.bad_groups = counters_host_.data()[1].bad_groups;
  outcome.bad_values = counters_host_.data()[1].bad_values != 0;
  for (size_t b = 0; b < loss_views_.size(); ++b) {
    const double samples = 3.0 * loss_views_[b].width * loss_views_[b].height;
    outcome.losses.push_back(view_loss(loss_weights_, loss_sums_host_.data()[2 * b],
                                       loss_sums_host_.data()[2 * b + 1], samples));
  }
  outcome.d_maps.assign(map_sums_host_.data(), map_sums_host_.data() + map_sums_.size());
  for (int64_t i = 0; i < time_sums_.size(); ++i)
    (2 * i < time_sums_.size() ? outcome.d_times : outcome.d_readouts)
        .push_back(double(time_sums_host_.data()[i]) / kTimeSteps);
  return outcome;
}

std::unique_ptr<Backend> make_cuda_backend(int device) {
  return std::make_unique<CudaBackend>(device);
}

void check_device(cudaError_t code, const char* what) {
  if (code == cudaSuccess) return;
  cudaGetLastError();  // clears what is not sticky
  size_t free_bytes = 0, all_bytes = 0;
  std::string memory;
  if (cudaMemGetInfo(&free_bytes, &all_bytes) == cudaSuccess)
    memory = "; " + std::to_string(free_bytes >> 20) + " of " + std::to_string(all_bytes >> 20) +
             " MiB of device memory are free";
  const bool foreign = code == cudaErrorNoKernelImageForDevice;
  const char* remedy =
      foreign ? "; configure with -DCMAKE_CUDA_ARCHITECTURES=native on the machine of this card"
              : "";
  throw DeviceError(std::string(what) + ": " + cudaGetErrorString(code) + memory + remedy);
}

unsigned grid_of(int64_t count, int threads) {
  const int64_t blocks = (count + threads - 1) / threads;
  if (blocks > INT32_MAX)
    throw DeviceError("a kernel over " + std::to_string(count) +
                      " items does not fit a launch; use a smaller batch or fewer Gaussians");
  return unsigned(blocks > 0 ? blocks : 1);
}

}  // namespace tessera
