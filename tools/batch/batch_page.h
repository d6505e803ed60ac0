// The page of a batch: failures first, then its presets side by side, by scene.
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
};

struct BatchImages {
  std::vector<std::pair<std::string, std::string>> charts;               // scene, SVG
  std::vector<std::pair<std::string, std::vector<ComparedView>>> views;  // by scene
  std::vector<std::string> notes;  // views that could not be drawn
};

/// One HTML file that needs no other. `report`: batch_report. The page lies in OUT/report:
/// addresses of runs begin with "../". All text is escaped.
std::string batch_page(const nlohmann::json& report, const BatchImages& images);

}  // namespace tessera
