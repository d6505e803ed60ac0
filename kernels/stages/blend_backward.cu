// Gradient of blending on the device, front to back from the scalar R = ⟨colour still to come,
// dL/dC⟩; lanes are pixels. The traversal is in kernels/cuda/splat_sums.cuh. Source: method A.11,
// C.3, G.4.
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/splat_sums.cuh"

namespace tessera {

BlendBackward CudaBackend::pass_of(const BlendBackwardArgs<float>& args, float* sums) {
  const TileInstances<float>& instances = *args.forward.instances;
  return {views_of(*args.forward.batch),
          int(args.forward.batch->views.size()),
          instances.tile_begin.data(),
          instances.splat.data(),
          instances.tile_order.data(),
          instances.count,
          args.forward.splats->splat.data(),
          make_cutoff<float>(args.forward.options),
          args.images->colour.data(),
          args.d_colour.data,
          args.images->used.data(),
          sums,
          args.lengths.data,
          nullptr,
          checkpoints_.data(),
          bucket_begin_.data(),
          args.forward.batch->tiles};
}

namespace {

template <class Pixel>
void launch_backward(const BlendBackward& a, const BlendArgs<float>& forward, bool checkpoints,
                     Buffer<float>& instance_sums, cudaStream_t stream) {
  const KernelSwitches& switches = forward.options.kernels;
  const bool cull = switches.backward != BackwardForm::kPixel;
  if (switches.deterministic) {
    cull ? launch_sums_in_order<Pixel, true>(a, forward, instance_sums, stream)
         : launch_sums_in_order<Pixel, false>(a, forward, instance_sums, stream);
  } else if (checkpoints) {
    launch_sums<Pixel, 1, true, false, true>(a, a.instances / kSegment + a.tiles, stream);
  } else {
    cull ? launch_sums<Pixel, 2, true, false, false>(a, a.tiles, stream)
         : launch_sums<Pixel, 2, false, false, false>(a, a.tiles, stream);
  }
}

}  // namespace

void CudaBackend::blend_backward(const BlendBackwardArgs<float>& args,
                                 Span<SplatMoments<float>> d_splats) {
  const TileInstances<float>& instances = *args.forward.instances;
  const Span<float> sums(reinterpret_cast<float*>(d_splats.data),
                         kSplatMomentTerms * d_splats.size);
  const BlendBackward a = pass_of(args, sums.data);
  clear_sums(sums, stream_);
  clear_sums(args.lengths, stream_);
  if (args.lengths.empty())
    launch_backward<PixelBackward>(a, args.forward, has_checkpoints_, instance_sums_, stream_);
  else
    launch_backward<PixelBackwardAndLength>(a, args.forward, has_checkpoints_, instance_sums_,
                                            stream_);
  check_launch("blend_backward");
  clock_.add_bytes(kBlendBackward, double(instances.count) * (4 + 48 + 36) +
                                       36.0 * 2 * double(d_splats.size) +
                                       28.0 * double(args.forward.batch->pixels));
}

}  // namespace tessera
