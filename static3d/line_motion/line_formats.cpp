// The table of formats, and the detection of a file's format.
#include "static3d/line_motion/line_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"

namespace tessera {
namespace {

/// A kind of .ply, known by a property that no other has.
struct PlyReader {
  const char* property;
  LineFile (*load)(const std::filesystem::path&, const PlyFile&);
};
constexpr PlyReader kPlyReaders[] = {{"log_duration", load_ftgs_ply},
                                     {"t_sigma", load_sogst_ply},
                                     {"trbf_center", load_spacetime_ply}};

/// A kind of archive, known by members of its meta.json.
struct ArchiveReader {
  bool (*is_of)(const nlohmann::json& meta);
  LineFile (*load)(const std::filesystem::path&, const SogArchive&);
};
constexpr ArchiveReader kArchiveReaders[] = {
    {[](const nlohmann::json& meta) { return meta.value("format", nlohmann::json()) == "sogst"; },
     load_sogst},
    {[](const nlohmann::json& meta) {
       return meta.contains("profile") || meta.contains("timeline") ||
              meta.value("version", nlohmann::json()) == 4;
     },
     load_tsog}};

const ArchiveReader* reader_of(const nlohmann::json& meta) {
  for (const ArchiveReader& reader : kArchiveReaders)
    if (meta.is_object() && reader.is_of(meta)) return &reader;
  return nullptr;
}

bool is_line_archive(const std::filesystem::path& path) {
  try {
    const std::string file = read_text_file(path);
    const auto contents = zip_contents(file, path);
    const auto meta = contents.find("meta.json");
    return meta != contents.end() &&
           reader_of(nlohmann::json::parse(meta->second, nullptr, false)) != nullptr;
  } catch (const InputError&) {  // the reader of .sog says what is wrong
    return false;
  }
}

LineFile load_ply(const std::filesystem::path& path) {
  const PlyFile file = read_ply(path);
  const PlyElement* const vertex = file.find("vertex");
  for (const PlyReader& reader : kPlyReaders)
    if (vertex != nullptr && vertex->find(reader.property) != nullptr)
      return reader.load(path, file);
  throw InputError(fmt::format("{}: no 4D splats that move along lines", path.string()));
}

LineFile load_archive(const std::filesystem::path& path) {
  check_webp(path);
  const std::string file = read_text_file(path);
  const SogArchive archive(file, path);
  const ArchiveReader* const reader = reader_of(archive.meta());
  if (reader == nullptr) archive.fail("its meta.json is of no format of 4D splats");
  return reader->load(path, archive);
}

void drop_invalid(const std::string& path, LineFile& file) {
  int64_t dropped = 0;
  for (GaussianSet* set : {&file.model.static_set, &file.model.dynamic_set}) {
    const std::vector<int64_t> rows = valid_elements(*set);
    dropped += set->count() - int64_t(rows.size());
    if (int64_t(rows.size()) < set->count()) *set = select_elements(*set, rows);
  }
  if (dropped == 0) return;
  file.warnings.push_back(
      fmt::format("{}: {} of {} Gaussians dropped: a value not finite, or a quaternion of length 0",
                  path, dropped, dropped + file.model.count()));
}

/// Of a file as far as a header of .ply may reach.
std::string head_of(const std::filesystem::path& path) {
  constexpr size_t kHeaderBytes = 1 << 14;
  std::ifstream stream(path, std::ios::binary);
  std::string head(kHeaderBytes, '\0');
  stream.read(head.data(), std::streamsize(head.size()));
  head.resize(size_t(stream.gcount()));
  return head;
}

}  // namespace

const std::vector<LineFormat>& line_formats() {
  static const std::vector<LineFormat> rows = {
      {"ftgs", ".ftgs.ply", "lines as floats; ftgs-player, FreeTimeGsVanilla", save_ftgs_ply},
      {"sogst", ".sogst", "a sixth of ftgs; players of Cumuli", save_sogst},
      {"sogst-ply", ".sogst.ply", "lines as floats, in seconds; encoders of .sogst",
       save_sogst_ply},
      {"tsog", ".tsog", "a sixth of ftgs; ftgs-player", save_tsog},
      {"usda", ".usda", "text with time samples; OpenUSD 26.03, Omniverse, Houdini", save_usda,
       false},
  };
  return rows;
}

const LineFormat* find_line_format(std::string_view name) {
  for (const LineFormat& format : line_formats())
    if (name == format.name) return &format;
  return nullptr;
}

bool is_line_file(const std::filesystem::path& path) {
  const std::string head = head_of(path);
  if (is_zip(head)) return is_line_archive(path);
  const std::string_view header = std::string_view(head).substr(0, head.find("end_header"));
  return header.starts_with("ply") &&
         std::any_of(std::begin(kPlyReaders), std::end(kPlyReaders), [&](const PlyReader& reader) {
           return header.find(fmt::format(" {}\n", reader.property)) != std::string_view::npos;
         });
}

LineFile load_line_file(const std::filesystem::path& path) {
  LineFile file = is_zip(head_of(path)) ? load_archive(path) : load_ply(path);
  drop_invalid(path.string(), file);
  return file;
}

}  // namespace tessera
