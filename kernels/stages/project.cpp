// Projection of Gaussians to the splats of every view on the CPU. One task has a run of Gaussians
// and loops over views. The equations are in math/splat.h.
#include <vector>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/load_gaussian.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 512;  // Gaussians per task

template <class Real>
struct Record {
  Splat<Real> splat;
  Real depth;
  TileRect rect;
};

/// The splats of a run of Gaussians, in order; `starts` has one entry per Gaussian.
template <class Real>
struct Chunk {
  std::vector<Record<Real>> records;
  std::vector<int64_t> starts;
  int64_t instances = 0, invalid = 0;
};

/// Some elements of a block of a set.
struct Run {
  int set;
  ShBlock block;
  int64_t begin, end;  // elements of the block
};

template <class Real>
std::vector<Run> runs_of(const ProjectArgs<Real>& args) {
  std::vector<Run> runs;
  for (int set = 0; set < 2; ++set) {
    const GaussianSpans<const Real>& spans = args.sets[set];
    for_each_block(spans.blocks, spans.count, spans.coefficients, [&](const ShBlock& block) {
      for (int64_t begin = 0; begin < block.count; begin += kGrain)
        runs.push_back({set, block, begin, min_of(begin + kGrain, block.count)});
    });
  }
  return runs;
}

template <SetForm form, class Real>
void project_run(const ProjectArgs<Real>& args, const Run& run, Chunk<Real>& chunk) {
  const std::vector<ViewArgs<Real>>& views = args.batch->views;
  const SplatRules<Real> rules = make_splat_rules<Real>(args.options);
  const GaussianSpans<const Real> set = args.sets[run.set].block(run.block);
  const ColourRules<Real> colours =
      make_colour_rules<Real>(args.options, set.coefficients, set.time_levels);
  for (int64_t n = run.begin; n < run.end; ++n) {
    chunk.starts.push_back(int64_t(chunk.records.size()));
    GaussianState<Real> at_rest;
    if (!load_gaussian<form>(set, n, at_rest)) {
      ++chunk.invalid;
      continue;
    }
    for (size_t b = 0; b < views.size(); ++b) {
      ViewSplat<Real> splat;
      GaussianState<Real> room_of_state;
      const GaussianState<Real>& g = state_in_view<form>(set, n, int(b), at_rest, room_of_state);
      if (!splat_in_view(views[b], g, rules, splat)) continue;
      Record<Real> record;
      Splat<Real>& out = record.splat;
      Real distance, room[3 * kMaxShCoefficients];
      const Vec3<Real> direction =
          view_direction(views[b], colours.sliced_direction ? splat.slice.mean : g.mean, distance);
      const Real* const sh = sh_at(colours, g, colour_delta(views[b], g), room);
      if (!drawn_colour(colours.degree, direction, sh, out.colour, out.negative)) {
        ++chunk.invalid;
        break;
      }
      out.view = int32_t(b);
      out.opacity = splat.opacity;
      out.power = splat.power;
      out.mean2d = splat.projection.mean2d;
      out.conic = splat.projection.conic;
      record.depth = splat.projection.in_cam[2];
      record.rect = splat.rect;
      chunk.instances += record.rect.area();
      chunk.records.push_back(record);
    }
  }
}

template <class Real>
void resize_splats(Splats<Real>& splats, int64_t count, int64_t gaussians) {
  splats.count = count;
  splats.splat.resize(count);
  splats.depth.resize(count);
  splats.rect.resize(count);
  splats.tiles.resize(count);
  splats.first_of.resize(gaussians + 1);
}

template <class Real>
void store(const Record<Real>& r, int64_t s, Splats<Real>& splats) {
  splats.splat[s] = r.splat;
  splats.depth[s] = r.depth;
  splats.rect[s] = r.rect;
  splats.tiles[s] = r.rect.area();
}

}  // namespace

template <class Real>
void CpuBackend<Real>::project(const ProjectArgs<Real>& args, Splats<Real>& splats) {
  const int64_t gaussians = args.sets[0].count + args.sets[1].count;
  check_gaussian_count(gaussians);
  const std::vector<Run> runs = runs_of(args);
  std::vector<Chunk<Real>> chunks(runs.size());
  parallel_for(int64_t(chunks.size()), 1, [&](int64_t c, int64_t) {
    const Run& run = runs[size_t(c)];
    with_drawn_form(args.sets[run.set].form,
                    [&](auto form) { project_run<form()>(args, run, chunks[size_t(c)]); });
  });
  std::vector<int64_t> offset(chunks.size() + 1, 0);
  std::vector<int64_t> gaussian(chunks.size() + 1, 0);
  splats.instances = splats.invalid = 0;
  for (size_t c = 0; c < chunks.size(); ++c) {
    offset[c + 1] = offset[c] + int64_t(chunks[c].records.size());
    gaussian[c + 1] = gaussian[c] + int64_t(chunks[c].starts.size());
    splats.instances += chunks[c].instances;
    splats.invalid += chunks[c].invalid;
  }
  resize_splats(splats, offset.back(), gaussians);
  parallel_for(int64_t(chunks.size()), 1, [&](int64_t c, int64_t) {
    const Chunk<Real>& chunk = chunks[size_t(c)];
    for (size_t i = 0; i < chunk.records.size(); ++i)
      store(chunk.records[i], offset[size_t(c)] + int64_t(i), splats);
    for (size_t i = 0; i < chunk.starts.size(); ++i)
      splats.first_of[gaussian[size_t(c)] + int64_t(i)] = offset[size_t(c)] + chunk.starts[i];
  });
  splats.first_of[gaussians] = offset.back();
}

template void CpuBackend<float>::project(const ProjectArgs<float>&, Splats<float>&);
template void CpuBackend<double>::project(const ProjectArgs<double>&, Splats<double>&);

}  // namespace tessera
