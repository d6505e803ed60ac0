// Escapes text for HTML pages, and embeds images.
#pragma once
#include <string>
#include <string_view>

namespace tessera {

/// Text between tags or within a quoted attribute.
std::string html_text(std::string_view text);
/// RFC 4648, with padding.
std::string base64(std::string_view bytes);
/// data:TYPE;base64,…
std::string data_address(const char* type, std::string_view bytes);
/// Puts `html` in the place of a text that the page has.
void fill_place(std::string& page, std::string_view place, std::string_view html);

}  // namespace tessera
