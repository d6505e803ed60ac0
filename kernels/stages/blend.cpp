// Front-to-back blending on the CPU, one tile at a time and sixteen pixels at once. Source: [3DGS];
// method A.10, C.3.
#include "kernels/cpu_backend.h"
#include "kernels/stages/tile_loop.h"

namespace tessera {
namespace {

constexpr int64_t kFinishedCheck = 16;  // splats between two looks whether the tile is finished

template <class Real>
struct TileState {
  Real colour[3][kTileSize][kTileSize] = {};
  Real transmittance[kTileSize][kTileSize] = {};  // 0 outside the image: never drawn
  int32_t used[kTileSize][kTileSize] = {};
};

template <bool ByFalloff, class Real>
void blend_row(const TileSplat<Real>& splat, Cutoff<Real> cutoff, int y, int32_t index,
               TileState<Real>& state) {
  const Real dy = splat.dy0 - Real(y);
  Real* const red = state.colour[0][y];
  Real* const green = state.colour[1][y];
  Real* const blue = state.colour[2][y];
  Real* const T = state.transmittance[y];
  int32_t* used = state.used[y];
  for (int x = 0; x < kTileSize; ++x) {
    const Real G = splat_falloff(splat.conic, splat.dx0 - Real(x), dy);
    const Real alpha = splat.opacity * G;
    const bool on = cutoff.template draws<ByFalloff>(alpha, G) && T[x] >= kMinTransmittance<Real>;
    blend_step(on ? alpha : Real(0), splat.colour, red[x], green[x], blue[x], T[x]);
    used[x] = on ? index + 1 : used[x];
  }
}

template <class Real>
bool finished(const TileState<Real>& state, const Tile<Real>& tile) {
  Real most = Real(0);
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < kTileSize; ++x) most = max_of(most, state.transmittance[y][x]);
  return most < kMinTransmittance<Real>;
}

template <class Real>
void store_tile(const TileState<Real>& state, const Tile<Real>& tile, const RenderOptions& options,
                Images<Real>& images) {
  const int64_t first = tile.view->first_pixel, pixels = tile.view_pixels();
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const int64_t p = tile.row_start(y) + x;
      const Real T = state.transmittance[y][x];
      for (int c = 0; c < 3; ++c)
        images.colour[3 * first + c * pixels + p] =
            state.colour[c][y][x] + T * Real(options.background[c]);
      images.transmittance[first + p] = T;
      images.used[first + p] = state.used[y][x];
    }
}

}  // namespace

template <class Real>
void CpuBackend<Real>::blend(const BlendArgs<Real>& args, Images<Real>& images) {
  images.colour.resize(3 * args.batch->pixels);
  images.transmittance.resize(args.batch->pixels);
  images.used.resize(args.batch->pixels);
  const Cutoff<Real> cutoff = make_cutoff<Real>(args.options);
  for_each_tile_of(*args.batch, *args.instances, [&](const Tile<Real>& tile) {
    TileState<Real> state;
    for (int y = 0; y < tile.height; ++y)
      for (int x = 0; x < tile.width; ++x) state.transmittance[y][x] = Real(1);
    for (int64_t i = tile.begin; i < tile.end; ++i) {
      const int64_t index = i - tile.begin;
      if (index % kFinishedCheck == 0 && index > 0 && finished(state, tile)) break;
      prefetch_splat(*args.splats, *args.instances, tile, i);
      const TileSplat<Real> splat(*args.splats, args.instances->splat[i], tile);
      for (int y = splat.first_row; y < splat.last_row; ++y)
        cutoff.by_falloff() ? blend_row<true>(splat, cutoff, y, int32_t(index), state)
                            : blend_row<false>(splat, cutoff, y, int32_t(index), state);
    }
    store_tile(state, tile, args.options, images);
  });
}

template void CpuBackend<float>::blend(const BlendArgs<float>&, Images<float>&);
template void CpuBackend<double>::blend(const BlendArgs<double>&, Images<double>&);

}  // namespace tessera
