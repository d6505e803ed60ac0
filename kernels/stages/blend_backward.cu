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
          nullptr,
          checkpoints_.data(),
          bucket_begin_.data(),
          args.forward.batch->tiles};
}

void CudaBackend::blend_backward(const BlendBackwardArgs<float>& args,
                                 Span<SplatMoments<float>> d_splats) {
  const TileInstances<float>& instances = *args.forward.instances;
  const KernelSwitches& switches = args.forward.options.kernels;
  const Span<float> sums(reinterpret_cast<float*>(d_splats.data),
                         kSplatMomentTerms * d_splats.size);
  const BlendBackward a = pass_of(args, sums.data);
  clear_sums(sums, stream_);
  const bool cull = switches.backward != BackwardForm::kPixel;
  if (switches.deterministic) {
    cull ? launch_sums_in_order<PixelBackward, true>(a, args.forward, instance_sums_, stream_)
         : launch_sums_in_order<PixelBackward, false>(a, args.forward, instance_sums_, stream_);
  } else if (has_checkpoints_) {
    launch_sums<PixelBackward, 1, true, false, true>(a, instances.count / kSegment + a.tiles,
                                                     stream_);
  } else {
    cull ? launch_sums<PixelBackward, 2, true, false, false>(a, a.tiles, stream_)
         : launch_sums<PixelBackward, 2, false, false, false>(a, a.tiles, stream_);
  }
  check_launch("blend_backward");
  clock_.add_bytes(kBlendBackward, double(instances.count) * (4 + 48 + 36) +
                                       36.0 * 2 * double(d_splats.size) +
                                       28.0 * double(args.forward.batch->pixels));
}

}  // namespace tessera
