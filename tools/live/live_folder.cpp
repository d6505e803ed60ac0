// Reads and writes the files as JSON. They are written every second, without a sync to the disk.
#include "tools/live/live_folder.h"
#include "ingest/files/json_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace tessera {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(LiveState, training, counter, step, total,
                                                seconds_left, loss, steps_per_second, num_static,
                                                num_dynamic, device_bytes, snapshot, snapshot_step,
                                                model_failure)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(LiveRequest, counter, seen, stop_training)

namespace {

using nlohmann::json;

template <class T>
std::optional<T> read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) return std::nullopt;
  try {
    return json::parse(text.str()).get<T>();
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::string text_of(const LiveState& state) {
  return json_text(json(state));  // a loss that is no number becomes null
}

std::filesystem::path LiveFolder::snapshot(int64_t number) const {
  return root_ / fmt::format("scene_{}.t4d", number);
}

void LiveFolder::make() const {
  std::filesystem::create_directories(root_.parent_path());
  if (::mkdir(root_.c_str(), 0700) != 0 && errno != EEXIST)
    throw std::filesystem::filesystem_error("mkdir", root_,
                                            std::error_code(errno, std::system_category()));
}

/// Renamed first: a viewer may write into it meanwhile, which would keep it.
void LiveFolder::remove() const {
  std::error_code ignored;
  const std::filesystem::path removed = root_.string() + ".removed";
  std::filesystem::rename(root_, removed, ignored);
  std::filesystem::remove_all(removed, ignored);
}

bool LiveFolder::replace(const std::filesystem::path& file, const std::string& bytes) const {
  const std::filesystem::path part = file.string() + ".part";
  {
    std::ofstream out(part, std::ios::binary);
    out << bytes;
    if (!out.flush()) return false;
  }
  std::error_code failed;
  std::filesystem::rename(part, file, failed);
  return !failed;
}

bool LiveFolder::write(const LiveState& state) const {
  return replace(root_ / "state.json", text_of(state));
}
bool LiveFolder::write(const LiveRequest& request) const {
  return replace(root_ / "request.json", json_text(json(request)));
}
bool LiveFolder::write_snapshot(int64_t number, const std::string& bytes) const {
  return replace(snapshot(number), bytes);
}

std::optional<LiveState> LiveFolder::state() const {
  return read<LiveState>(root_ / "state.json");
}
std::optional<LiveRequest> LiveFolder::request() const {
  return read<LiveRequest>(root_ / "request.json");
}

}  // namespace tessera
