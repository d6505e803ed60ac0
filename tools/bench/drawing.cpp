// What: gnuplot run on a script: whole images or none.
// Not: the script (bench/chart.cpp).
#include <fmt/format.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/child_process.h"
#include "ingest/files/staging.h"
#include "ingest/files/write_failure.h"
#include "tools/bench/chart.h"
#include "tools/bench/gnuplot_words.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

/// A hidden folder that goes with all in it.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(fs::path path) : path_(std::move(path)) {
    remove_all();
    make_folder(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { remove_all(); }
  const fs::path& path() const { return path_; }

 private:
  void remove_all() const {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  fs::path path_;
};

/// gnuplot looks at no write: on a full disk it leaves the beginning of a file and reports nothing.
/// Returns what is wrong, or "".
std::string take_images(const fs::path& drawn, const fs::path& folder, const std::string& stem) {
  constexpr uintmax_t kNoRoom = 64 << 10;  // bytes
  const std::pair<const char*, std::string_view> ends[] = {{".svg", "</svg>"}, {".png", "IEND"}};
  for (const auto& [extension, end] : ends) {
    const fs::path file = drawn / (stem + extension);
    if (fs::exists(file) && read_text_file(file).find(end) != std::string::npos) continue;
    if (fs::space(folder).available < kNoRoom) fail_to_write(folder / (stem + extension), ENOSPC);
    return fmt::format("{}{}: gnuplot has not written all of it", stem, extension);
  }
  for (const auto& [extension, end] : ends)
    fs::rename(drawn / (stem + extension), folder / (stem + extension));
  return "";
}

}  // namespace

std::string draw_image(const fs::path& folder, const std::string& stem, const std::string& script) {
  const fs::path file = folder / (stem + ".gp");
  write_text_file(file, script);
  const fs::path program = find_program("gnuplot");
  if (program.empty())
    return "no gnuplot found, so no images; install it (Debian: gnuplot-nox) and use --plot";
  const TemporaryFolder drawn(folder / staging_name(stem));
  const ChildResult result =
      run_child({{program.string(), "-e", "cd " + gnuplot_string(drawn.path().string()),
                  fs::absolute(file).string()},
                 {},
                 {}},
                [](std::string_view) {});
  if (result.exit_code != 0)
    return fmt::format("{}: gnuplot failed: {}", file.string(), result.last_line);
  return take_images(drawn.path(), folder, stem);
}

}  // namespace tessera
