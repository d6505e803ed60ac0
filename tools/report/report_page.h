// The page of one run: its data, charts and images as sections of HTML.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tools/report/run_images.h"
#include "tools/report/run_report.h"

namespace tessera {

/// A file or folder of the run.
struct ReportLink {
  std::string name;     // "Player"
  std::string address;  // relative to the page, as html_address makes it
  int64_t bytes = -1;   // -1: unknown, or a folder
};

struct RunPage {
  std::string title;  // the name of the run
  RunReport report;
  RunImages images;
  std::vector<ReportLink> links;  // the first is the one to open
  std::string image_note;         // why there are no images; or empty
};

/// The charts of a run with the names of their files, "psnr" among them; those without a point are
/// left out. Curves of test views have the colour of the preset.
std::vector<std::pair<std::string, std::string>> run_charts(const RunReport& report);

/// One HTML file that needs no other. All text of the run is escaped.
std::string run_page(const RunPage& page);

}  // namespace tessera
