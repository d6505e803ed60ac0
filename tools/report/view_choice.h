// Which views a report shows, chosen from their scores.
#pragma once
#include <string>
#include <vector>

#include "tools/report/run_report.h"

namespace tessera {

/// Indices of `views` of one camera, ascending, at equal distances and with the first and last.
struct CameraViews {
  std::string camera;
  std::vector<size_t> views;
};

/// By camera in the order of the scene, at most `most` (2 or more) of each.
std::vector<CameraViews> strip_views(const std::vector<ScoredView>& views, size_t most);

struct ChosenView {
  std::string title;  // "Worst view"
  size_t view = 0;    // index
};

/// The views of lowest, median and highest PSNR, each once.
std::vector<ChosenView> telling_views(const std::vector<ScoredView>& views);

}  // namespace tessera
