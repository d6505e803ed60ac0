// Small images of a few held-out views of a run beside the truth, rendered once and kept in
// RUN/held_out/.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "kernels/backend.h"

namespace tessera {

struct HeldOutView {
  std::string frame;
  double psnr = 0;           // dB, of the whole image at its own size
  std::string truth, drawn;  // PNG, at most 200 pixels wide
};

/// `count` views spread over the run's held-out split (over its training split where nothing is
/// held out). Those of RUN/held_out are given where they are of this model; else they are drawn and
/// kept. Errors: InputError: no model, its scene is gone.
std::vector<HeldOutView> held_out_views(Backend& backend, const std::filesystem::path& run,
                                        int64_t count);

}  // namespace tessera
