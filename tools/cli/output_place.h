// What: where results may lie: never in what they are made of. And what may be replaced.
// Not: how files are replaced (output_folder.h, ingest/files/folders.h).
//
// The rule, the same for all commands that write; links and mounts are seen through:
// 1. A capture or a scene that a command reads is never written to: an output that is this folder
//    or lies in it is refused, before anything is written (`run C -o C`, `train S -o S/run`).
// 2. Commands that fill a folder of their own (run, ingest, train, bench, batch) are refused one
//    that contains such an input as well: a second call replaces what is there.
// 3. A run folder is no input in this sense: `export RUN -o RUN/export` is allowed, and `run` keeps
//    OUT/scene beside OUT/run. Nor is a folder of captures, whose results may lie beside them; each
//    capture in it is one.
// 4. What took hours, a prepared scene, a run or a made capture, is replaced with --overwrite only,
//    and a scene that another program has in use not even then (scene_lock.h). `run`, `batch` and
//    `ingest` of several captures keep a record of what they have made in their folder for which
//    inputs and options, and replace that and nothing else. Exports, images and reports are
//    replaced where their folder lists them as its own (output_folder.h).
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
