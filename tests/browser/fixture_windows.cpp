// Puts dynamic sets of a clip into the time of two windows and slices the file that has them.
#include "tests/browser/fixture_windows.h"

#include <fmt/format.h>

#include "static3d/formats/splat_file.h"
#include "static3d/tessera4d/windowed_file.h"
#include "static3d/transform/slicer.h"
#include "tests/static3d/tessera4d/window_model.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

constexpr double kTimes[] = {0, 0.25, 0.5, 0.7, 1};  // WINDOW_TIMES of make_vectors.py

}  // namespace

void write_windows(const std::filesystem::path& folder, const GaussianModel& first,
                   const GaussianModel& second) {
  const std::vector<FileWindow> windows = {{{0, 0.6}, {0, 0.5}},
                                           {{0.4, 1}, {0.5, 1}, {0.8, 0.9, 1.3}}};
  const std::filesystem::path file = folder / "few_windows.t4d";
  const ScratchFolder parts;
  WindowedWriter writer(parts.path(), first, first.time_axis, windows, {});
  writer.add(0, in_time_of(windows[0], first));
  writer.add(1, in_time_of(windows[1], second));
  writer.finish();
  single_from_folder(parts.path(), file);
  Tessera4dParts read = open_tessera4d(file);
  for (size_t i = 0; i < std::size(kTimes); ++i) {
    const int window = window_at(read.windows(), kTimes[i]);
    const GaussianModel model = read.load(window);
    save_splat_file(splat_format("ply"), folder / fmt::format("few_windows_{:04}.ply", i),
                    Slicer(model).at(window_time(windows[size_t(window)], kTimes[i])), {3});
  }
}

}  // namespace tessera::testing
