// Names of files as text: in one form, whatever the system that wrote them.
#pragma once
#include <string>
#include <string_view>

namespace tessera {

/// In the composed normal form (NFC; macOS writes the decomposed one), with bytes that are no UTF-8
/// as %XX.
std::string plain_name(std::string_view name);

/// The same without regard to case: what names are compared by. ASCII alone has cases.
std::string compared_name(std::string_view name);

}  // namespace tessera
