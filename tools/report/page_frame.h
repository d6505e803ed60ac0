// The frame of every report: one HTML file with its style and its script inside.
#pragma once
#include <string>

namespace tessera {

/// A whole page. `title` is text and is escaped; `body` is HTML of the page's sections.
std::string report_frame(const std::string& title, const std::string& body);

}  // namespace tessera
