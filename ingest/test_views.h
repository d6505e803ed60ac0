// What: which views of a scene will be scored, in words.
// Not: the choice of them (held_out_cameras.h and the converter of each layout).
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "ingest/scene.h"

namespace tessera {

class TestViews {
 public:
  /// Looks at camera name and split; the pixels are not needed.
  void add(const Frame& frame);

  /// Views of the splits test and val.
  int64_t count() const;
  /// "will be scored: 24 test views (camera cam00)", or that nothing will be and how to change it.
  std::string text() const;

 private:
  struct Counts {
    int64_t all = 0, test = 0, val = 0;
  };
  /// "24 test views (camera cam00)"; empty where the split has none.
  std::string text_of(const char* split, int64_t Counts::*views) const;

  std::map<std::string, Counts> cameras_;
};

TestViews test_views_of(const Scene& scene);

}  // namespace tessera
