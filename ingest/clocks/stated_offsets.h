// What: the file of clock offsets a user states: {"cam02": 0.0417, …} or lines "cam02 0.0417".
// Not: offsets that are measured (sync_audio.h, sync_motion.h).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// Seconds for each of `names`, in their order. Text: blanks or a comma between name and seconds,
/// # begins a comment. Errors: InputError naming the file and what is wrong in it: a camera that
/// is unknown, missing or stated twice, no number.
std::vector<double> read_stated_offsets(const std::filesystem::path& path,
                                        const std::vector<std::string>& names);

}  // namespace tessera
