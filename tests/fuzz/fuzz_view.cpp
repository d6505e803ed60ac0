// Fuzz target: requests to `tessera view` on arbitrary bytes, with METHOD PATH QUERY in the first
// line and one header per line after it. See scripts/fuzz.sh.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tools/view/answer.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kToken = "0123456789abcdef0123456789abcdef";

/// A folder with one file that is served, and links and files that are not; a training.
struct Served {
  ViewState state;
  int changes = 0;  // requests to the training that were obeyed
  struct stat page {};

  Served() {
    const fs::path root =
        fs::temp_directory_path() / ("tessera_fuzz_" + std::to_string(::getpid()));
    fs::create_directories(root / "site/a");
    std::ofstream(root / "secret.html") << "secret";
    std::ofstream(root / "site/a/index.html") << "0123456789";
    std::ofstream(root / "site/.b.html") << "secret";
    std::error_code exists;
    fs::create_symlink(root / "secret.html", root / "site/c.html", exists);
    fs::create_directory_symlink(root, root / "site/d", exists);
    state.folder = OpenFile(::open((root / "site").c_str(), O_RDONLY | O_DIRECTORY));
    state.token = kToken;
    state.port = 80;
    state.start = "/a/";
    const auto change = [this] {
      ++changes;
      return true;
    };
    state.live = LiveHooks{
        [](int64_t seen) { return std::to_string(seen); }, [] { return std::string("<svg>"); },
        [](int64_t view) { return std::string(view == 3 ? "image" : ""); }, change};
    if (::stat((root / "site/a/index.html").c_str(), &page) != 0) std::abort();
  }
};

/// For any request, the only file that is sent is the page, and only with the token; requests with
/// it that come from the server's page may change the training.
void check_answer(const ViewRequest& request, const Served& served) {
  const int changes = served.changes;
  const ViewResponse response = answer(request, served.state);
  for (const auto& [name, value] : response.headers)
    if ((name + value).find_first_of(std::string("\r\n\0", 3)) != std::string::npos) std::abort();
  if (header_values(response.headers, "X-Content-Type-Options").size() != 1) std::abort();
  bool has_token = request.query.find(kToken) != std::string::npos;
  for (const auto& [name, value] : request.headers)
    has_token |= value.find(kToken) != std::string::npos;
  if (served.changes != changes &&
      (!has_token || request.method != "POST" || header_values(request.headers, "Origin").empty()))
    std::abort();
  if (!response.file.is_open()) return;
  struct stat sent {};
  if (::fstat(response.file.descriptor(), &sent) != 0 || sent.st_ino != served.page.st_ino ||
      response.offset + response.bytes > uint64_t(sent.st_size))
    std::abort();
  if (!has_token) std::abort();
}

ViewRequest request_of(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  ViewRequest request;
  const size_t path = line.find(' '), query = line.find(' ', path + 1);
  request.method = line.substr(0, path);
  if (path != std::string::npos) request.path = line.substr(path + 1, query - path - 1);
  if (path != std::string::npos && query != std::string::npos)
    request.query = line.substr(query + 1);
  while (std::getline(lines, line)) {
    const size_t colon = line.find(": ");
    if (colon != std::string::npos)
      request.headers.emplace_back(line.substr(0, colon), line.substr(colon + 2));
  }
  return request;
}

}  // namespace
}  // namespace tessera

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const tessera::Served served;
  const std::string text(reinterpret_cast<const char*>(data), size);
  tessera::check_answer(tessera::request_of(text), served);
  return 0;
}
