// Reads the files of a run, renders its views, and writes its data, images and page.
#include "tools/report/write_run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"
#include "tools/report/rendered_views.h"
#include "tools/report/report_page.h"
#include "tools/report/run_images.h"
#include "tools/report/run_report.h"
#include "tools/session/device_choice.h"
#include "tools/session/output_folder.h"
#include "tools/session/run_folder.h"
#include "tools/session/version.h"
#include "tools/session/windows_folder.h"
#include "tools/web/page_words.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kImages = "images";
constexpr size_t kMostRunsInside = 3;  // whose images are in the page, of up to 5 MB each

/// Where the files of a run lie.
struct RunPlaces {
  RunFolder run;
  fs::path out;    // of `tessera run`; empty for a run folder alone
  fs::path whole;  // the one of both that contains the other
  std::string title;

  explicit RunPlaces(const fs::path& named) {
    const fs::path place = fs::absolute(named).lexically_normal() / "";
    const WindowsFolder windows = windows_folder_of(place);
    fs::path root = windows.exists() ? windows.root : run_folder_of(place);
    if (!root.has_filename()) root = root.parent_path();
    run.root = root;
    if (root.filename() == "run" && fs::exists(root.parent_path() / "stages.json"))
      out = root.parent_path();
    whole = out.empty() ? root : out;
    title = whole.filename().string();
  }

  fs::path stages() const { return out / "stages.json"; }
};

/// {name, path relative to the report, bytes (null of a folder's)}; the first is the one to open.
json files_of(const RunPlaces& places, const fs::path& report) {
  json files = json::array();
  const auto add = [&](const char* name, const fs::path& file) {
    std::error_code error;
    if (!fs::exists(file, error)) return;
    files.push_back({{"name", name},
                     {"path", file.lexically_relative(report).generic_string()},
                     {"bytes", fs::is_regular_file(file) ? json(fs::file_size(file)) : json()}});
  };
  if (!places.out.empty()) add("Player", places.out / "player" / "index.html");
  add("Model", places.run.model());
  add("Windows", WindowsFolder{places.run.root}.plan_file());
  add("Scores", places.run.metrics());
  add("Log", places.run.log());
  add("Options", places.run.config());
  if ((places.whole / "report").lexically_normal() !=
      (report / "").parent_path().lexically_normal())
    add("Report", places.whole / "report" / "index.html");
  if (places.out.empty()) return files;
  add("PLY frames", places.out / "frames" / "manifest.json");
  add("Stages", places.stages());
  return files;
}

json bytes_of(const json& files, const char* name) {
  for (const json& file : files)
    if (file["name"] == name) return file["bytes"];
  return nullptr;
}

/// An image by its content: the same truth is one file in the reports of all runs.
std::string file_name(const EncodedImage& image) {
  Fnv1a hash;
  hash.add(image.bytes);
  return hash.hex() + (image.type == "image/png" ? ".png" : ".jpg");
}

/// Gives the views of a run their images: addresses by `address_of`.
void add_images(json& run, const std::vector<ShownView>& shown,
                const std::function<std::string(const EncodedImage&)>& address_of) {
  for (json& view : run["views"])
    view.update({{"role", nullptr},
                 {"strip", false},
                 {"width", 0},
                 {"height", 0},
                 {"truth", nullptr},
                 {"result", nullptr},
                 {"error", nullptr}});
  for (const ShownView& image : shown) {
    json& view = run["views"][image.view];
    if (!image.role.empty()) view["role"] = image.role;
    view["strip"] = image.in_strip;
    view["width"] = image.width;
    view["height"] = image.height;
    view["truth"] = address_of(image.truth);
    view["result"] = address_of(image.result);
    view["error"] = address_of(image.error);
  }
}

/// A run with its images.
struct ReportedRun {
  json run;
  std::vector<ShownView> images;
};

/// The images that the report names.
void write_images(OutputFolder& output, const std::vector<ReportedRun>& runs) {
  std::set<std::string> names;
  make_folder(output.path(kImages));
  for (const ReportedRun& run : runs)
    for (const ShownView& view : run.images)
      for (const EncodedImage* image : {&view.truth, &view.result, &view.error})
        if (const std::string name = kImages / file_name(*image); names.insert(name).second) {
          write_text_file(output.path(name), image->bytes);
          output.add(name);
        }
}

/// A report of a version that listed no files is replaced as well.
bool is_report(const fs::path& folder) {
  const json report = json_if_sound(folder / "report.json");
  return report.is_object() && report.contains("schema") && report.contains("runs");
}

/// `report`: the folder that the files of the run are relative to; `scratch`: as of run_images.
ReportedRun reported(const RunPlaces& places, const fs::path& report, const fs::path& scratch,
                     const RunReportRequest& request) {
  RunRecords records = read_records(places.run.root);
  if (!places.out.empty()) records.stages = json_if_sound(places.stages());
  std::optional<RenderedViews> views;
  json note;
  try {
    views.emplace(places.run.root, request.backend);
    if (records.metrics.is_null()) records.metrics = views->scores();
  } catch (const InputError& error) {
    note = error.what();
  }
  ReportedRun made{run_report(records), {}};
  made.run["id"] = made.run["title"] = places.title;
  made.run["files"] = files_of(places, report);
  if (records.windows.empty())
    made.run["size"]["model_bytes"] = bytes_of(made.run["files"], "Model");
  made.run["size"]["player_bytes"] = bytes_of(made.run["files"], "Player");
  if (views) try {
      made.images = run_images([&](const ScoredView& view) { return views->view(view); },
                               scored_views(records.metrics), scratch);
    } catch (const InputError& error) {  // a window is loaded when a view of it is drawn
      note = error.what();
    }
  made.run["image_note"] = note;
  return made;
}

/// Runs of one name are told apart by the folders that they lie in.
void tell_apart(std::vector<ReportedRun>& runs, const std::vector<RunPlaces>& places) {
  for (size_t i = 0; i < runs.size(); ++i) {
    const auto same = [&](const RunPlaces& other) { return other.title == places[i].title; };
    if (std::count_if(places.begin(), places.end(), same) > 1)
      runs[i].run["id"] = runs[i].run["title"] =
          (places[i].whole.parent_path().filename() / places[i].title).string();
  }
}

}  // namespace

bool is_run(const fs::path& folder) {
  return windows_folder_of(folder).exists() || RunFolder{run_folder_of(folder)}.exists();
}

json write_run_report(const RunReportRequest& request) {
  std::vector<RunPlaces> places;
  for (const fs::path& run : request.runs) {
    if (!is_run(run))
      throw InputError(
          fmt::format("{}: is no run: it has no config.json; name the output folder of "
                      "`tessera run` or a run folder",
                      run.string()));
    places.emplace_back(run);
  }
  const bool compares = places.size() > 1;
  const fs::path folder = request.out.empty() ? places.front().whole / "report"
                                              : fs::absolute(request.out).lexically_normal();
  OutputFolder output(folder, "report", {}, request.overwrite || is_report(folder));
  std::vector<ReportedRun> runs;
  for (const RunPlaces& run : places)
    runs.push_back(reported(run, folder, output.staging(), request));
  tell_apart(runs, places);
  json report = {{"schema", kReportSchema},
                 {"kind", compares ? "comparison" : "run"},
                 {"title", compares ? "Comparison" : places.front().title},
                 {"version", kVersionText},
                 {"made", utc_time()},
                 {"runs", json::array()}};
  for (const ReportedRun& run : runs) report["runs"].push_back(run.run);
  const auto place_images = [&](const std::function<std::string(const EncodedImage&)>& address) {
    for (size_t i = 0; i < runs.size(); ++i) add_images(report["runs"][i], runs[i].images, address);
  };
  const auto beside = [](const EncodedImage& image) {
    return (kImages / file_name(image)).generic_string();
  };
  const auto inside = [](const EncodedImage& image) {
    return data_address(image.type.c_str(), image.bytes);
  };
  std::vector<std::pair<std::string, std::string>> files;
  if (carries_pages()) {
    runs.size() <= kMostRunsInside ? place_images(inside) : place_images(beside);
    files.emplace_back("index.html", filled_report_page(report));
  }
  place_images(beside);
  files.emplace_back("report.json", report_text(report));
  output.written([&] {
    write_images(output, runs);
    for (const auto& [name, text] : files) {
      write_text_file(output.path(name), text);
      output.add(name);
    }
    output.finish();
  });
  report["page"] = (folder / files.front().first).string();
  return report;
}

}  // namespace tessera
