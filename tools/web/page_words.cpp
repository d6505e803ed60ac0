// Escapes of HTML and of addresses, and base64.
#include "tools/web/page_words.h"

#include "kernels/base/errors.h"

#include <fmt/format.h>

#include <cstdint>

namespace tessera {

std::string html_text(std::string_view text) {
  std::string escaped;
  for (char c : text) switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      case '{':  // places of the page's frame
        escaped += "&#123;";
        break;
      default:
        escaped += c;
    }
  return escaped;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

std::string data_address(const char* type, std::string_view bytes) {
  return fmt::format("data:{};base64,{}", type, base64(bytes));
}

void fill_place(std::string& page, std::string_view place, std::string_view html) {
  const size_t position = page.find(place);
  check(position != std::string::npos, "a web page lacks a place for what it shows");
  page.replace(position, place.size(), html);
}

}  // namespace tessera
