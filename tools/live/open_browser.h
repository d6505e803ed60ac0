// Opens a browser at an address that only its user may know.
#pragma once
#include <filesystem>
#include <string>

namespace tessera {

/// A page that leads to the address, which only this user can read. All users see the arguments of
/// a program in the list of processes, and the address has the token. Errors:
/// std::filesystem::filesystem_error: it cannot be written.
std::filesystem::path leading_page(const std::filesystem::path& folder, const std::string& address);

/// A browser of its own session, which Ctrl-C does not reach. Only on the desktop of this machine:
/// elsewhere it would be slow. Where xdg-open is missing, a warning.
void open_browser(const std::filesystem::path& page);

}  // namespace tessera
