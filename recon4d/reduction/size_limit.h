// Reduction of the final model to the requested size: the Gaussians of least contribution over all
// training frames are removed, without further training. Source: docs/explanation/size.md; failure
// modes C12, C13.
#pragma once
#include <functional>

#include "recon4d/reduction/contributions.h"

namespace tessera {

/// Bytes of the file that is shipped of a model.
using ShippedBytes = std::function<int64_t(const GaussianModel& model)>;

/// At most one of the three; none: only what no training frame ever sees goes.
struct SizeLimit {
  int64_t gaussians = 0;  // 0: not requested
  int64_t bytes = 0;
  double least_psnr = 0;          // dB, by `psnr` below
  bool static_is_frozen = false;  // only dynamic Gaussians go

  ShippedBytes shipped_bytes = {};                              // for `bytes`
  std::function<double(const GaussianModel& model)> psnr = {};  // for `least_psnr`
};

/// Without what still_dynamic() names, in the host's memory: of a model whose static set is frozen.
GaussianModel without_still_dynamic(Backend& backend, const GaussianModel& model,
                                    const FrameSample& sample);

/// Gaussians without blending weight in the frames of `sample` are gone, and no more of the others
/// than are asked for: exactly `gaussians` are left, or all where there are fewer; the largest
/// number whose file has no more than `bytes`; or the smallest whose PSNR is not below
/// `least_psnr`, all in the order of their contributions. The last two by halving, to a thousandth
/// of the Gaussians. The model lies in the host's memory.
GaussianModel fit_to_limit(const SizeLimit& limit, Backend& backend, const GaussianModel& model,
                           const FrameSample& sample);

}  // namespace tessera
