// What `tessera view PATH` shows: a folder with a page that is there, or one that is made.
#pragma once
#include <filesystem>
#include <memory>
#include <string>

#include "ingest/files/folders.h"

namespace tessera {

struct ViewSource {
  std::filesystem::path folder;  // to serve
  std::string start = "/";       // the page in it, as a path of the server
  /// finished: the page that a run or an export wrote; model; or training: `run` is its folder.
  std::string kind;
  std::filesystem::path run;
  std::unique_ptr<TemporaryFolder> temporary;  // that holds `folder` where the page was made
};

/// `path`: an OUT of `tessera run` or a run folder that a training writes now, an OUT of `tessera
/// run` or `tessera batch`, a folder with an index.html, or what
/// `tessera export` takes: the page of that model is made in a temporary folder. Errors: InputError
/// naming the path and what is accepted.
ViewSource view_source(const std::string& path);

}  // namespace tessera
