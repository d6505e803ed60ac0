// Adds the rows of ingest/option_rows.h to a command, converts the words that were given, and
// records the values.
#include "tools/cli/ingest_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>
#include <vector>

#include "ingest/camera_table_text.h"
#include "ingest/files/cache_folder.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/option_rows.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/terminal.h"
#include "tools/session/locks.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

using nlohmann::json;

/// In the order of PoseSource::Kind, but for kCameras.
constexpr const char* kPoseWords[] = {"", "colmap", "n3dv", "llff"};

template <class Field>
constexpr bool kIsOptional = false;
template <class Value>
constexpr bool kIsOptional<std::optional<Value>> = true;
template <class Field>
constexpr bool kIsChoice = std::is_enum_v<Field>;
template <class Enum>
constexpr bool kIsChoice<std::optional<Enum>> = std::is_enum_v<Enum>;
using Readouts = std::map<std::string, double>;
/// Fields that `take` reads; CLI11 converts the others, which are numbers and plain text.
template <class Field>
constexpr bool kIsTaken =
    kIsChoice<Field> || std::is_same_v<Field, PoseSource> || std::is_same_v<Field, Readouts>;
template <class Field>
constexpr bool kIsList =
    std::is_same_v<Field, std::vector<std::string>> || std::is_same_v<Field, Readouts>;

/// Errors: InputError that lists the names there are.
template <class Enum>
requires std::is_enum_v<Enum>
void take(const std::vector<std::string>& words, const char* option, Enum& field) {
  const auto& names = kEnumNames<Enum>;
  const auto found = std::find(std::begin(names), std::end(names), words.front());
  if (found == std::end(names))
    throw InputError(fmt::format("{} is '{}', expected one of {}", option, words.front(),
                                 fmt::join(names, ", ")));
  field = Enum(found - std::begin(names));
}

template <class Enum>
void take(const std::vector<std::string>& words, const char* option, std::optional<Enum>& field) {
  if (!words.front().empty()) take(words, option, field.emplace());
}

/// A word, or a file or folder of cameras.
void take(const std::vector<std::string>& words, const char*, PoseSource& source) {
  const auto found = std::find(std::begin(kPoseWords), std::end(kPoseWords), words.front());
  source = found != std::end(kPoseWords)
               ? PoseSource{PoseSource::Kind(found - std::begin(kPoseWords)), {}}
               : PoseSource{PoseSource::kCameras, words.front()};
}

/// "16ms", "0.016", "cam01=16ms" each, in seconds by camera.
void take(const std::vector<std::string>& words, const char* option, Readouts& readouts) {
  constexpr double kLongest = 1;
  for (const std::string& text : words) {
    const size_t equals = text.rfind('=');
    const size_t first = equals == std::string::npos ? 0 : equals + 1;
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data() + first, end, value);
    const std::string_view unit(parsed.ptr, end);
    if (unit == "ms") value /= 1000;
    if (parsed.ec != std::errc() || !(unit.empty() || unit == "s" || unit == "ms") ||
        !(std::abs(value) <= kLongest))
      throw InputError(fmt::format(
          "{} is '{}'; give a time up to a second like 16ms, or a camera and a time like "
          "cam01=16ms",
          option, text));
    readouts[first == 0 ? "" : text.substr(0, equals)] = value;
  }
}

template <class Field>
void add_row(CLI::App& command, IngestArguments& arguments, const char* name, Field& field,
             const char* doc) {
  CLI::Option* option = nullptr;
  if constexpr (kIsTaken<Field>) {
    // of a list CLI11 takes all words that follow, as it does the names of cameras
    using Typed = std::conditional_t<kIsList<Field>, std::vector<std::string>, std::string>;
    option = command.add_option_function<Typed>(
        name, [&arguments, name](const Typed& typed) { arguments.words[name] = {typed}; }, doc);
  } else if constexpr (std::is_same_v<Field, bool>)
    command.add_flag(name, field, doc);
  else
    option = command.add_option(name, field, doc);
  if constexpr (kIsList<Field>) option->delimiter(',');
  if constexpr (std::is_enum_v<Field>)
    option->default_str(name_of(field));
  else if constexpr (std::is_arithmetic_v<Field> && !std::is_same_v<Field, bool>)
    option->capture_default_str();
}

/// A hash of the current version of a file or folder; null where none is named.
json stamps_of(const std::filesystem::path& path) {
  if (path.empty() || !std::filesystem::exists(path)) return nullptr;
  return key_of(file_stamps(path));
}

constexpr const char* kDefault = "default";  // which follows from the capture

/// Into `object`, under the name of the option with underscores. `absent`: for a number that is not
/// given.
template <class Field>
void record(json& object, const std::string& key, const Field& field, int absent) {
  if constexpr (std::is_enum_v<Field>)
    object[key] = name_of(field);
  else if constexpr (kIsChoice<Field>)
    object[key] = field ? name_of(*field) : kDefault;
  else if constexpr (kIsOptional<Field>)
    object[key] = field ? json(*field) : json(absent);
  else
    object[key] = field;
}

void record(json& object, const std::string& key, const std::filesystem::path& file, int) {
  object[fmt::format("contents of the {}", key)] = stamps_of(file);
}

void record(json& object, const std::string& key, const PoseSource& source, int) {
  object[key] = source.kind == PoseSource::kCameras ? source.cameras.string()
                                                    : kPoseWords[size_t(source.kind)];
  record(object, key, source.cameras, 0);
}

/// As one text: an object would be compared key by key.
void record(json& object, const std::string& key, const Readouts& readouts, int) {
  std::vector<std::string> texts;
  for (const auto& [camera, seconds] : readouts)
    texts.push_back(camera.empty() ? fmt::format("{}", seconds)
                                   : fmt::format("{}={}", camera, seconds));
  object[key] = texts.empty() ? kDefault : fmt::format("{}", fmt::join(texts, ","));
}

}  // namespace

void add_ingest_options(CLI::App& command, IngestArguments& arguments) {
  for_each_ingest_option(arguments.options,
                         [&](const char* name, auto& field, const char* doc, int = 0) {
                           add_row(command, arguments, name, field, doc);
                         });
}

IngestOptions resolve_ingest(const IngestArguments& arguments) {
  IngestOptions options = arguments.options;
  check_values(options);
  for_each_ingest_option(options, [&](const char* name, auto& field, const char*, int = 0) {
    if constexpr (kIsTaken<std::remove_reference_t<decltype(field)>>)
      if (const auto found = arguments.words.find(name); found != arguments.words.end())
        take(found->second, name, field);
  });
  options.poses.strict = options.strict;
  if (const auto cache = user_cache_folder(); !cache.empty())
    options.poses.cache = cache / "colmap";
  return options;
}

void require_one_capture(const std::filesystem::path& folder, const IngestOptions& options) {
  refuse_trained(folder, "capture");
  if (!is_folder_of_captures(folder, options.image_layout)) return;
  const bool may_be_rig = find_video_folders(folder).cameras.size() > 1 ||
                          find_image_sequences(folder).cameras.size() > 1;
  throw InputError(fmt::format(
      "{}: is no capture, but holds some ({}); {}name one of them, or all of them to `tessera "
      "batch`",
      folder.string(), listed_names(captures_in(folder, options.image_layout)),
      may_be_rig ? "if they are the cameras of one scene, pass --layout rig; else " : ""));
}

json to_json(const IngestOptions& options) {
  json object{{"static", options.allow_static}};
  for_each_ingest_option(options,
                         [&](std::string name, const auto& field, const char*, int absent = 0) {
                           name.erase(0, 2);
                           std::replace(name.begin(), name.end(), '-', '_');
                           // `layout` was another thing in folders of 0.3
                           record(object, name == "layout" ? "image_layout" : name, field, absent);
                         });
  return object;
}

IngestReport ingest_with_progress(const std::filesystem::path& capture,
                                  const std::filesystem::path& out, const IngestOptions& options,
                                  const std::string& backend) {
  const SceneLock replaced(out, SceneLock::Use::kReplace);
  ProgressBar bar("ingest");
  IngestOptions checked = options;
  checked.check_cameras = true;
  std::unique_ptr<Backend> device;
  checked.pixel_search = [&] {
    device = make_backend(backend);
    return device->pixel_search();
  };
  const IngestReport report = ingest_capture(
      capture, out, checked, [&](std::string_view what, int64_t done, int64_t total) {
        stop_if_interrupted();
        bar.update(done, total, what);
      });
  bar.clear();
  for (const std::string& note : report.notes) say(note);
  for (const std::string& line : camera_table_lines(report.camera_table)) say(line);
  for (const std::string& warning : report.warnings) warn(warning);
  return report;
}

}  // namespace tessera
