// The tables of Unicode are those of utf8proc.
#include "ingest/images/names.h"

#include <fmt/format.h>
#include <utf8proc.h>

#include <cstdlib>
#include <memory>

#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

std::string valid_text(std::string_view name) {
  std::string valid;
  while (!name.empty()) {
    utf8proc_int32_t code = 0;
    const auto* const bytes = reinterpret_cast<const utf8proc_uint8_t*>(name.data());
    const utf8proc_ssize_t length = utf8proc_iterate(bytes, utf8proc_ssize_t(name.size()), &code);
    if (length > 0)
      valid += name.substr(0, size_t(length));
    else
      valid += fmt::format("%{:02X}", bytes[0]);
    name.remove_prefix(size_t(length > 0 ? length : 1));
  }
  return valid;
}

}  // namespace

std::string plain_name(std::string_view name) {
  const std::string valid = valid_text(name);
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> composed(
      utf8proc_NFC(reinterpret_cast<const utf8proc_uint8_t*>(valid.c_str())), &std::free);
  return composed ? reinterpret_cast<const char*>(composed.get()) : valid;
}

std::string compared_name(std::string_view name) {
  return lower_case(plain_name(name));
}

}  // namespace tessera
