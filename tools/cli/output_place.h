// Checks where results may be written: never into the inputs that they are made of, and never over
// results that must not be replaced. output_folder.h and ingest/files/folders.h replace files.
//
// The rules are the same for all commands that write; links and mounts are resolved:
// 1. A capture or a scene that a command reads is never written to: an output that is this folder
//    or lies in it is refused, before anything is written (`run C -o C`, `train S -o S/run`).
// 2. Commands that fill a whole folder (run, ingest, train, batch) are refused one that contains
//    such an input as well: a second call replaces what is there.
// 3. A run folder is no input in this sense: `export RUN -o RUN/export` is allowed, and `run` keeps
//    OUT/scene beside OUT/run. Nor is a folder of captures, whose results may lie beside them; each
//    capture in it is one.
// 4. Expensive results, a prepared scene, a run or a synthetic capture, are replaced with
//    --overwrite only, and a scene that another program uses is never replaced (locks.h). `run`
//    and `batch` record which files of their folder they made for which inputs and options, and
//    replace these alone. Exports, images and reports are replaced where the manifest of their
//    folder lists them (output_folder.h).
#pragma once
#include <filesystem>

namespace tessera {

/// Rules 1 and 2. An input that does not exist is its reader's to report. Errors: InputError.
void check_output_apart(const std::filesystem::path& out, const std::filesystem::path& input);
/// Rule 1 alone.
void check_output_outside(const std::filesystem::path& out, const std::filesystem::path& input);

/// Rule 1 for what is made of `model`, a run folder or a file in one: with the scene that it was
/// trained on, and with `cameras` where that is a folder. Errors: InputError.
void check_output_of_model(const std::filesystem::path& out, const std::filesystem::path& model,
                           const std::filesystem::path& cameras);

/// Rule 4: whether `folder` may be written, which `what` ("a prepared scene") already is if
/// `exists`. Errors: InputError.
void check_may_replace(const std::filesystem::path& folder, const char* what, bool exists,
                       bool overwrite);

}  // namespace tessera
