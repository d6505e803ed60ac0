// Puts the data into its element of the page.
#include "tools/report/report_page.h"

#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "tools/web/page_words.h"
#include "tools/web/web_page.h"

namespace tessera {

using nlohmann::json;

std::string report_text(const json& report) {
  return json_text(report, 1) + "\n";
}

std::string filled_report_page(const json& report) {
  std::string data = json_text(report, -1);
  for (size_t i = data.find('<'); i != std::string::npos; i = data.find('<', i))
    data.replace(i, 1, "\\u003c");  // what it has is text, not the end of its element
  std::string page(report_page());
  fill_place(page, kPageTitle,
             "<title>Tessera: " + html_text(report["title"].get<std::string>()) + "</title>");
  std::string element(kReportData);
  fill_place(element, "null", data);
  fill_place(page, kReportData, element);
  return page;
}

}  // namespace tessera
