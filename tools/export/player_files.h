// The player's page as files: beside the data it plays, or with the data inside.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "static3d/formats/splat_file.h"
#include "tools/export/page_head.h"

namespace tessera {

constexpr const char* kPageFile = "index.html";

/// The page, which plays the manifest.json beside it. Errors: InputError: a build without the page.
std::string page_of_folder(const PageHead& head);
/// One page that opens from a file, with a single-file Tessera 4D inside. Errors: likewise.
std::string page_with(std::string_view tessera4d, const PageHead& head);
/// Errors: InputError: frames that the page cannot read.
void check_page_plays(const SplatFormat& format);

/// What a limit in bytes does not count: "" without a limit, and of a build without the page.
std::string page_bytes_note(int64_t max_bytes);

}  // namespace tessera
