// The page of captures has the rows of the layouts, with the options that each alone has.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "ingest/layouts/capture_layout.h"
#include "tests/source_tree.h"

namespace tessera {
namespace {

/// The last cell of each row of the table of layouts, by name.
std::map<std::string, std::string> documented_layouts() {
  std::ifstream page(kSourceRoot / "docs/reference/captures.md");
  std::map<std::string, std::string> layouts;
  bool is_table = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("| layout |")) is_table = true;
    if (line.empty()) is_table = false;
    if (!is_table || !line.starts_with("| `")) continue;
    const size_t end = line.find('`', 3), last = line.rfind('|', line.size() - 2);
    layouts[line.substr(3, end - 3)] = line.substr(last);
  }
  return layouts;
}

// Bugs put back, each seen to fail: a row without its line on the page; --images of a layout that
// has no photos.
TEST(LayoutRows, ThePageOfCapturesHasThem) {
  const auto documented = documented_layouts();
  EXPECT_EQ(documented.size(), layout_rows().size());
  for (const LayoutRow& row : layout_rows()) {
    ASSERT_TRUE(documented.contains(row.name)) << row.name;
    const std::string& options = documented.at(row.name);
    const auto has = [&](const char* name) { return options.find(name) != std::string::npos; };
    EXPECT_EQ(has("--images"), row.photos) << row.name;
    for (const char* of_clips : {"--cameras", "--start", "--duration", "--fps", "--offsets"})
      EXPECT_EQ(has(of_clips), row.clips) << row.name << " " << of_clips;
    EXPECT_EQ(has("--camera-model"), row.estimates_poses) << row.name;
    EXPECT_NE(row.read, nullptr) << row.name;
  }
}

}  // namespace
}  // namespace tessera
