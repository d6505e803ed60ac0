// The files of a capture by what they hold, so that what no reader takes can be named.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

enum class FileKind {
  kImage,       // that this program reads, by its extension
  kVideo,       // that libav opens: by its extension, else by its first bytes
  kOtherMedia,  // images and videos that are not read as they are
  kTable,       // text that may state cameras
  kOther
};

FileKind kind_of_file(const std::filesystem::path& file);

/// Whether a table speaks of lenses and poses where it begins.
bool speaks_of_cameras(const std::filesystem::path& table);

struct ListedFile {
  std::filesystem::path path;
  FileKind kind = FileKind::kOther;
};

/// The files below `folder`, four levels deep, by path. Links to folders are followed once. What is
/// hidden, and what systems leave (@eaDir, Thumbs.db, __MACOSX), is not listed; folders that cannot
/// be read are passed over.
std::vector<ListedFile> list_files(const std::filesystem::path& folder);

}  // namespace tessera
