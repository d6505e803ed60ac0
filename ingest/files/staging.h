// What: names of folders in which a result is built before it takes its place, and what is left of
//       them by programs that were killed.
// Not: the exchange (staged_folder.h, tools/export/output_folder.h).
#pragma once
#include <filesystem>
#include <string>

namespace tessera {

/// ".STEM.HOST.PID.partial": tells whose it is.
std::string staging_name(const std::string& stem);

/// Whether `name` is one for `stem`, of any process.
bool is_staging_name(const std::string& name, const std::string& stem);

/// Removes the folders for `stem` below `parent` whose process, of this machine, has ended.
void remove_stale_staging(const std::filesystem::path& parent, const std::string& stem);

}  // namespace tessera
