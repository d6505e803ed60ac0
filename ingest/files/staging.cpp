// What: host and process in a name, and whether that process is still there.
// Not: processes of other machines: theirs are left alone.
#include "ingest/files/staging.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <system_error>
#include <vector>

#include "ingest/files/host_name.h"

namespace tessera {
namespace {

constexpr std::string_view kSuffix = ".partial";

std::string prefix_here(const std::string& stem) {
  return fmt::format(".{}.{}.", stem, host_name());
}

/// The process of this machine that has the name, or 0.
pid_t process_of(const std::string& name, const std::string& stem) {
  const std::string prefix = prefix_here(stem);
  if (!name.starts_with(prefix) || !name.ends_with(kSuffix)) return 0;
  const char* const end = name.data() + name.size() - kSuffix.size();
  pid_t process = 0;
  const auto [rest, error] = std::from_chars(name.data() + prefix.size(), end, process);
  return error == std::errc() && rest == end ? process : 0;
}

bool has_ended(pid_t process) {
  return ::kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

std::string staging_name(const std::string& stem) {
  return fmt::format("{}{}{}", prefix_here(stem), ::getpid(), kSuffix);
}

bool is_staging_name(const std::string& name, const std::string& stem) {
  return name.starts_with("." + stem + ".") && name.ends_with(kSuffix);
}

void remove_stale_staging(const std::filesystem::path& parent, const std::string& stem) {
  std::error_code ignored;
  std::vector<std::filesystem::path> stale;
  for (const auto& entry : std::filesystem::directory_iterator(parent, ignored)) {
    const pid_t process = process_of(entry.path().filename().string(), stem);
    if (process > 0 && has_ended(process)) stale.push_back(entry.path());
  }
  for (const std::filesystem::path& folder : stale) std::filesystem::remove_all(folder, ignored);
}

}  // namespace tessera
