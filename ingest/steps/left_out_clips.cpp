// Tries the undistortion of each camera once, before any frame is decoded.
#include "ingest/steps/left_out_clips.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/poses/pinhole_view.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {

void leave_out_clips(const std::string& seen, const std::string& refusal,
                     const std::vector<char>& keep, bool strict, Capture& capture) {
  if (std::count(keep.begin(), keep.end(), 1) < 2) throw InputError(refusal);
  if (strict) throw InputError(refusal + ", or leave --strict out to go on without");
  keep_clips(capture, keep);
  capture.warnings.push_back(
      fmt::format("{}; the scene is made of the other {} cameras", seen, capture.clips.size()));
}

void leave_out_bad_lenses(const IngestOptions& options, Capture& capture) {
  std::string first;
  std::vector<std::string> bad;
  std::vector<char> good;
  for (const RigClip& clip : capture.clips) try {
      pinhole_view(clip.camera->camera, clip.camera->lens, options.field_of_view,
                   fmt::format("{} ({})", clip.video.string(), clip.camera->lens_model));
      good.push_back(1);
    } catch (const InputError& error) {
      if (bad.empty()) first = error.what();
      bad.push_back(clip.name);
      good.push_back(0);
    }
  if (bad.empty()) return;
  const std::string seen =
      bad.size() == 1 ? first : fmt::format("{} (likewise: {})", first, listed_names(bad));
  leave_out_clips(seen, seen + ", or leave it out with --cameras", good, options.strict, capture);
}

}  // namespace tessera
