// The sensitivity of images to every splat on the CPU, front to back from the colour still to come.
// The equation is in math/sensitivity.h.
#include "kernels/cpu_backend.h"
#include "kernels/stages/splat_sums.h"

namespace tessera {
namespace {

template <class Real>
struct SensitivityWalk : WalkState<Real> {
  using Sum = SplatSensitivity<Real>;
  static constexpr int kTerms = 8;    // weight, weight2, image 3, removal 2, moving
  TileValues<Real> image[3] = {};     // x
  TileValues<Real> response[3] = {};  // e
  TileValues<Real> moves = {};        // m
  TileValues<Real> to_come[3] = {};   // Q

  void load(const SensitivityArgs<Real>& args, const Tile<Real>& tile) {
    const BlendBackwardArgs<Real>& pass = args.pass;
    const size_t b = size_t(tile.view - pass.forward.batch->views.data());
    const uint8_t* const mask = args.mask.empty() ? nullptr : args.mask[b].data;
    const Vec3<Real> follows = args.response.empty() ? Vec3<Real>(1) : Vec3<Real>(args.response[b]);
    const int64_t first = 3 * tile.view->first_pixel, pixels = tile.view_pixels();
    load_pixels(pass, tile, *this, [&](int x, int y, int64_t i) {
      const bool ignored = mask != nullptr && mask[i - first] == 0;
      moves[y][x] = mask == nullptr || may_move(mask[i - first]) ? Real(1) : Real(0);
      for (int c = 0; c < 3; ++c) {
        image[c][y][x] = pass.d_colour[i + c * pixels];
        response[c][y][x] = ignored ? Real(0) : follows[c];
        to_come[c][y][x] = pass.images->colour[i + c * pixels];
      }
    });
  }

  template <bool ByFalloff>
  void row(const TileSplat<Real>& splat, Cutoff<Real> cutoff, int y, int32_t index,
           Real (&sum)[kTerms][kTileSize]) {
    const Real dy = splat.dy0 - Real(y);
    const Real *x0 = image[0][y], *x1 = image[1][y], *x2 = image[2][y];
    const Real *e0 = response[0][y], *e1 = response[1][y], *e2 = response[2][y];
    Real *Q0 = to_come[0][y], *Q1 = to_come[1][y], *Q2 = to_come[2][y];
    Real* T = this->transmittance[y];
    const int32_t* until = this->used[y];
    for (int x = 0; x < kTileSize; ++x) {
      const Real G = splat_falloff(splat.conic, splat.dx0 - Real(x), dy);
      const Real alpha = splat.opacity * G;
      const bool lit = index < until[x];
      const bool on = cutoff.template draws<ByFalloff>(alpha, G) && lit;
      Vec3<Real> Q(Q0[x], Q1[x], Q2[x]);
      const Sum step =
          sensitivity_step(on ? alpha : Real(0), splat.colour, Vec3<Real>(x0[x], x1[x], x2[x]),
                           Vec3<Real>(e0[x], e1[x], e2[x]), moves[y][x], T[x], Q);
      Q0[x] = Q.x;
      Q1[x] = Q.y;
      Q2[x] = Q.z;
      sum[0][x] += step.weight;
      sum[1][x] += step.weight2;
      sum[2][x] += step.image.x;
      sum[3][x] += step.image.y;
      sum[4][x] += step.image.z;
      sum[5][x] += step.removal1;
      sum[6][x] += step.removal2;
      sum[7][x] += step.moving;
    }
  }

  static Sum reduced(const TileSplat<Real>&, const Real (&lanes)[kTerms][kTileSize]) {
    Real t[kTerms] = {};
    for (int k = 0; k < kTerms; ++k)
      for (int x = 0; x < kTileSize; ++x) t[k] += lanes[k][x];
    return {t[0], t[1], Vec3<Real>(t[2], t[3], t[4]), t[5], t[6], t[7]};
  }
};

}  // namespace

template <class Real>
void CpuBackend<Real>::sensitivity(const SensitivityArgs<Real>& args,
                                   Span<SplatSensitivity<Real>> out) {
  check_target(args);
  sum_over_splats<SensitivityWalk<Real>>(args, args.pass, instance_sensitivities_,
                                         [&](int64_t s, const auto& sum) { out[s] = sum; });
}

template void CpuBackend<float>::sensitivity(const SensitivityArgs<float>&,
                                             Span<SplatSensitivity<float>>);
template void CpuBackend<double>::sensitivity(const SensitivityArgs<double>&,
                                              Span<SplatSensitivity<double>>);

}  // namespace tessera
