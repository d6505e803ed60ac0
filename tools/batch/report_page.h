// What: what is known of a batch → one HTML page that needs no other file and no script.
// Not: reading anything (batch_report.h) or drawing (held_out_views.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

/// A view of a scene that was scored: the truth, and the renders of presets that have one.
struct ComparedView {
  std::string frame;
  std::string truth;  // PNG bytes
  struct Render {
    std::string preset, png;
    double psnr = 0;  // dB, of the whole image
  };
  std::vector<Render> renders;
  bool training = false;  // of the training split: the scene holds nothing out
};

struct ReportImages {
  std::vector<std::pair<std::string, std::string>> charts;  // scene, SVG
  std::string chart_note;                                   // why there are none; or empty
  std::vector<std::pair<std::string, std::vector<ComparedView>>> views;  // by scene
  std::vector<std::string> notes;  // views that could not be drawn
};

/// `report`: batch_report. The page lies in OUT/report: addresses of runs begin with "../".
std::string report_page(const nlohmann::json& report, const ReportImages& images);

}  // namespace tessera
