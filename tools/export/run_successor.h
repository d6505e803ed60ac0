// The successor of a finished run or training: it is made in a folder of its own, so that the
// finished one stays whole until the new one is complete, and then takes its place.
#pragma once
#include <filesystem>

namespace tessera {

/// Of the folder in OUT, or in the run folder of `tessera train`, in which a successor is made.
inline constexpr const char* kNext = "next";

/// Moves what the successor `from` of a `tessera run` has (scene, run, stages.json) to `out`, in
/// the place of what is there, and removes that, but for files that Tessera did not write. What is
/// cut off by a kill or a full disk is completed by finish_move. Errors: WriteError.
void move_successor(const std::filesystem::path& from, const std::filesystem::path& out);

/// Completes a move that was cut off; nothing where there was none.
void finish_move(const std::filesystem::path& out);

/// Moves all files of a training, or of the trainings of windows, from their folder `from` to
/// `run`, in the place of those that are there. Files that Tessera did not write stay. What is cut
/// off is completed by finish_training_move. Errors: WriteError.
void move_training(const std::filesystem::path& from, const std::filesystem::path& run);

/// Completes a move of a training that was cut off; nothing where there was none.
void finish_training_move(const std::filesystem::path& run);

}  // namespace tessera
