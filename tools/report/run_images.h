// The images of a report: views of a model, the truth, and their error maps, encoded for a page.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "tools/report/run_report.h"

namespace tessera {

struct EncodedImage {
  std::string type;  // "image/jpeg", or "image/png" in a build without JPEG
  std::string bytes;
};

struct ShownView {
  size_t view = 0;        // index
  std::string role;       // "worst", "median", "best"; "" of another
  bool in_strip = false;  // among those of its camera that are shown over time
  EncodedImage truth, result, error;
  int width = 0, height = 0;  // pixels, of each image
};

/// RGB images of one size, and the mask of the frame (0: left out), which may be empty.
struct RenderedView {
  Image8 truth, result, mask;
};
/// Nothing where there is no such view.
using ViewSource = std::function<std::optional<RenderedView>(const ScoredView&)>;

/// The telling ones of `views`, large, and those over time of each camera, small, each drawn once,
/// ascending in time; a view that `source` does not have is left out. `scratch`: an existing folder
/// for a temporary file. Stays within about 3.3 MB by smaller images and fewer frames. Errors: of
/// the source; InputError or WriteError of the temporary file.
std::vector<ShownView> run_images(const ViewSource& source, const std::vector<ScoredView>& views,
                                  const std::filesystem::path& scratch);

/// Indices of `views` of one camera, ascending, at equal distances and with the first and last.
struct CameraViews {
  std::string camera;
  std::vector<size_t> views;
};

/// By camera in the order of the scene, at most `most` (2 or more) of each.
std::vector<CameraViews> strip_views(const std::vector<ScoredView>& views, size_t most);

struct ChosenView {
  std::string role;  // "worst"
  size_t view = 0;   // index
};

/// The views of lowest, median and highest PSNR, each once.
std::vector<ChosenView> telling_views(const std::vector<ScoredView>& views);

/// The error that has the last colour of the scale, in 1/255.
constexpr int kLargestShownError = 32;

/// The mean absolute difference of the three channels of every pixel, from 0 (black) to
/// kLargestShownError and above (pale yellow). Pixels that the mask of the frame ignores are grey;
/// a mask without data uses all. Images are RGB and of one size.
Image8 error_map(const Image8& drawn, const Image8& truth, const Image8& mask);

}  // namespace tessera
