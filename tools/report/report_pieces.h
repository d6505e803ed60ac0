// Pieces of HTML for reports, and the frame of their pages: one HTML file with style and script
// inside. All text arguments are escaped.
#pragma once
#include <cstdint>
#include <string>

namespace tessera {

/// "3.2 s", "4:05", "1:02:03": of seconds.
std::string time_words(double seconds);
/// "812 B", "1.2 MB": of bytes, in powers of 1,000.
std::string size_words(int64_t bytes);

/// A name and a value of a list of facts; nothing where the value is empty.
std::string fact(const std::string& name, const std::string& value);
/// The same with HTML as the value.
std::string fact_html(const std::string& name, const std::string& html);

/// A whole page. `title` is text and is escaped; `body` is HTML of the page's sections.
std::string report_frame(const std::string& title, const std::string& body);

}  // namespace tessera
