// The page is a file for this user alone; xdg-open, which chooses the browser, gets its name.
#include "tools/live/open_browser.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "tools/cli/terminal.h"
#include "tools/view/served_file.h"

namespace tessera {

namespace fs = std::filesystem;

fs::path leading_page(const fs::path& folder, const std::string& address) {
  const fs::path path = folder / "open.html";
  const std::string page = fmt::format(
      "<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0;url={0}\">"
      "<title>tessera view</title><a href=\"{0}\">tessera view</a>\n",
      address);
  const OpenFile file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!file.is_open() ||
      ::write(file.descriptor(), page.data(), page.size()) != ssize_t(page.size()))
    throw fs::filesystem_error("write", path, std::error_code(errno, std::system_category()));
  return path;
}

void open_browser(const fs::path& page) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  for (int descriptor : {0, 1, 2})
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_RDWR, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string program = "xdg-open", argument = page.string();
  char* const words[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, program.c_str(), &files, &attributes, words, environ) != 0)
    warn("view: xdg-open, which opens a browser, was not found; open the address by hand");
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
}

}  // namespace tessera
