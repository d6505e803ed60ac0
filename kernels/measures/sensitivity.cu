// The sensitivity of images to every splat on the device, front to back from the colour still to
// come. The equation is in math/sensitivity.h.
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/splat_sums.cuh"

namespace tessera {
namespace {

constexpr int kSensitivityTerms = 8;  // floats of a SplatSensitivity
static_assert(sizeof(SplatSensitivity<float>) == kSensitivityTerms * sizeof(float));

struct SensitivityPass : BlendBackward {  // d_colour: the image x
  DeviceTarget target;                    // its truth is not read
};

/// A pixel on its way back through the splats.
struct PixelSensitivity : AddedTerms<kSensitivityTerms> {
  using Args = SensitivityPass;
  static constexpr int kLaneTerms = kSensitivityTerms, kTerms = kSensitivityTerms;
  float x = 0, y = 0;  // centre
  float T = 1;
  Vec3<float> to_come{0}, image{0}, response{0};  // Q, x, e
  float moves = 0;                                // m
  int32_t used = 0;

  __device__ PixelSensitivity() {}
  /// `before`: colour and T in front of the first splat it meets.
  __device__ PixelSensitivity(const SensitivityPass& a, const TilePixel& tile_pixel,
                              const float4& before)
      : x(float(tile_pixel.x) + 0.5f), y(float(tile_pixel.y) + 0.5f), T(before.w) {
    if (!tile_pixel.inside) return;
    const int64_t c0 = tile_pixel.colour_at(0), c1 = tile_pixel.colour_at(1),
                  c2 = tile_pixel.colour_at(2);
    image = Vec3<float>(a.d_colour[c0], a.d_colour[c1], a.d_colour[c2]);
    to_come =
        Vec3<float>(a.colour[c0] - before.x, a.colour[c1] - before.y, a.colour[c2] - before.z);
    const int64_t view = tile_pixel.image - a.views;
    const int64_t pixel = tile_pixel.index - tile_pixel.image->first_pixel;
    moves = a.target.may_move(view, pixel) ? 1.0f : 0.0f;
    if (a.target.counts(view, pixel))
      response = Vec3<float>(a.target.response_of(view, 0), a.target.response_of(view, 1),
                             a.target.response_of(view, 2));
    used = a.used[tile_pixel.index];
  }

  /// Takes its step past a splat; calls add(k, term) with its share, in the order of
  /// SplatSensitivity.
  template <class Add>
  __device__ void step(const SharedSplat& s, const PixelResponse& p, bool on, Add&& add) {
    const SplatSensitivity<float> share = sensitivity_step(
        on ? s.opacity() * p.falloff : 0.0f, s.colour(), image, response, moves, T, to_come);
    add(0, share.weight);
    add(1, share.weight2);
    for (int c = 0; c < 3; ++c) add(2 + c, share.image[c]);
    add(5, share.removal1);
    add(6, share.removal2);
    add(7, share.moving);
  }
  __device__ static float reduce(float, const float (&v)[kLaneTerms]) { return reduce_eight(v); }
  __device__ static int term_of_lane() {
    const int lane = int(threadIdx.x) % 32;
    return lane % 4 == 0 ? lane / 4 : kTerms;
  }
};

}  // namespace

void CudaBackend::sensitivity(const SensitivityArgs<float>& args,
                              Span<SplatSensitivity<float>> out) {
  check_target(args);
  const BlendArgs<float>& forward = args.pass.forward;
  const Span<float> sums(reinterpret_cast<float*>(out.data), kSensitivityTerms * out.size);
  SensitivityPass a;
  static_cast<BlendBackward&>(a) = pass_of(args.pass, sums.data);
  a.target = target_of({}, args.mask, args.response);
  clear_sums(sums, stream_);
  if (forward.options.kernels.deterministic)
    launch_sums_in_order<PixelSensitivity, true>(a, forward, instance_sums_, stream_);
  else
    launch_sums<PixelSensitivity, 2, true, false, false>(a, a.tiles, stream_);
  check_launch("sensitivity");
  clock_.add_bytes(kBlendBackward, double(forward.instances->count) * (4 + 48 + 32) +
                                       32.0 * 2 * double(out.size) +
                                       28.0 * double(forward.batch->pixels));
}

}  // namespace tessera
