// What: what `tessera export` was asked for.
// Not: parsing (commands/export.cpp).
#pragma once
#include <string>

#include "tools/camera_paths/export_times.h"

namespace tessera {

struct ExportRequest {
  std::string model, out, format = "ply";
  ExportTimes times;  // of frames; its fps also of formats that hold time
  int spz_version = 3;
  bool page = false;                      // the player beside the frames
  bool single = false, lossless = false;  // of the Tessera 4D file
  double segment_seconds = 1;
  std::string cameras, audio;
  std::string title, description;  // of a page; empty: none
  std::string poster;              // of a page: an image file, or "auto"; empty: none
  bool truth = false;              // test images of the scene in the page
  int threads = 0;
  bool keep_world = false, overwrite = false, json = false;
};

}  // namespace tessera
