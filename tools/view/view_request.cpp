// Finds headers by their names.
#include "tools/view/view_request.h"

namespace tessera {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::vector<std::string_view> header_values(const HttpHeaders& headers, std::string_view name) {
  std::vector<std::string_view> values;
  for (const auto& [header, value] : headers)
    if (lower_case(header) == lower_case(name)) values.push_back(value);
  return values;
}

}  // namespace tessera
