// `tessera export` writes a model to files of other formats.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kernels/base/counted.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/options/nearest_name.h"
#include "static3d/formats/splat_file.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/transform/world_change.h"
#include "tools/cli/command.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/clip/clip.h"
#include "tools/export/clean_model.h"
#include "tools/export/export_loss.h"
#include "tools/export/formats.h"

namespace tessera {
namespace {

void check_format(const std::string& name) {
  if (name == "mp4")
    throw InputError(
        "export: mp4 is no format of models; for a video: tessera render RUN --path orbit --mp4 "
        "-o OUT.mp4");
  std::vector<std::string> names;
  for (const TimeFormat& format : time_formats()) names.emplace_back(format.name);
  for (const SplatFormat& format : splat_formats()) names.emplace_back(format.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError(fmt::format("export: unknown format '{}'{}", name, known_names(name, names)));
}

/// No option is there for nothing.
void check_options(const ExportRequest& request, const TimeFormat* in_time) {
  const bool tessera4d = in_time != nullptr && in_time->is_tessera4d;
  const bool has_rate = in_time != nullptr && in_time->has_rate;
  const bool one_file = request.single || request.format == "html";
  const bool has_page = request.page || request.format == "page" || request.format == "html";
  const ExportTimes& times = request.times;
  const struct {
    const char* option;
    bool given, fits;
    const char* where;
  } rules[] = {
      {"--frames", times.frames.has_value(), in_time == nullptr, "frames (ply, spz, …)"},
      {"--time", times.time.has_value(), in_time == nullptr, "frames (ply, spz, …)"},
      {"--range", !times.range.empty(), in_time == nullptr, "frames (ply, spz, …)"},
      {"--fps", times.fps.has_value(), in_time == nullptr || has_rate, "all but model"},
      {"--page", request.page, in_time == nullptr, "frames; --format page has it already"},
      {"--spz-version", request.spz_version != 3, request.format == "spz", "spz"},
      {"--single", request.single, request.format == "tessera", "tessera"},
      {"--lossless", request.lossless, tessera4d, "tessera, page and html"},
      {"--segment", request.segment_seconds != 1, tessera4d, "tessera, page and html"},
      {"--cameras", !request.cameras.empty(),
       has_rate || request.page || request.clean.value_or(false),
       "formats that hold time but model, and frames with --page or --clean"},
      {"--title", !request.title.empty(), has_page, "pages: page, html and frames with --page"},
      {"--description", !request.description.empty(), has_page,
       "pages: page, html and frames with --page"},
      {"--poster", !request.poster.empty(), has_page, "pages: page, html and frames with --page"},
      {"--truth", request.truth, has_page, "pages: page, html and frames with --page"},
      {"--audio", !request.audio.empty(), tessera4d && !one_file, "folders: tessera and page"},
  };
  for (const auto& rule : rules)
    if (rule.given && !rule.fits)
      throw InputError(fmt::format("export: {} is for {}; leave it out for --format {}{}",
                                   rule.option, rule.where, request.format,
                                   request.single ? " --single" : ""));
}

/// With the cut-off that splat files do not name because all have it.
bool is_cut_as_players_do(const GaussianModel& model) {
  return !model.drawing.truncation_by_falloff && model.drawing.truncation_sigma == kTruncationSigma;
}

/// Whether viewers can read in the files that they are drawn antialiased.
bool has_mark(const std::string& format) {
  return find_time_format(format) == nullptr && splat_format(format).has_mark;
}

/// Whether a Gaussian has another colour at another time.
bool colours_follow_time(const GaussianModel& model) {
  if (model.drawing.sh_time_degree == 0 || model.dynamic_set.time_levels() == 0) return false;
  const auto levels = model.dynamic_set.group(kShTime).value.span();
  return std::any_of(levels.begin(), levels.end(), [](float x) { return x != 0; });
}

void warn_of_losses(const GaussianModel& model, const std::string& name,
                    const ExportRequest& request) {
  const TimeFormat* const in_time = find_time_format(request.format);
  const bool is_ours = in_time != nullptr && find_line_format(request.format) == nullptr;
  if (!is_ours && !is_cut_as_players_do(model))
    warn(
        fmt::format("{}: was trained with another truncation than players of splats have; it looks "
                    "different there; --format tessera keeps it",
                    name));
  if (!is_ours && model.drawing.filter_2d && !has_mark(request.format))
    warn(fmt::format(
        "{}: was trained antialiased (mip), which --format {} cannot say; switch it on in the "
        "viewer, or take ply, compressed, spz or sog, which say it, or train with --filter-2d "
        "false",
        name, request.format));
  if (in_time != nullptr && in_time->keeps_environment) return;
  if (model.environment.height > 0)
    warn(fmt::format("{}: its environment is not in what is exported; --format model keeps it",
                     name));
  if (in_time != nullptr && colours_follow_time(model))
    warn(
        fmt::format("{}: its colours follow time; exported are those of each Gaussian's own "
                    "timestep; frames and --format model keep them",
                    name));
}

/// Coordinates of maps are written without their millions.
void warn_of_origin(const Clip& clip) {
  const glm::dvec3 origin = -clip.head->prepared_from_source.translation;
  if (origin == glm::dvec3(0)) return;
  warn(fmt::format(
      "{}: its capture lies so far from the origin that floats do not hold it; exported "
      "are its places less ({:.10g}, {:.10g}, {:.10g})",
      clip.file.string(), origin.x, origin.y, origin.z));
}

/// The files that an earlier export left in the folder are removed; the model must not be one.
void check_places(const ExportRequest& request, const std::filesystem::path& model) {
  std::error_code missing;
  if (std::filesystem::equivalent(std::filesystem::absolute(model).parent_path(), request.out,
                                  missing))
    throw InputError(
        fmt::format("{}: is the folder of the model itself; choose another folder", request.out));
  check_output_of_model(request.out, request.model, request.cameras);
}

std::string written_text(const ExportRequest& request, const nlohmann::json& result) {
  const int64_t frames = result["frames"], bytes = result["bytes"];
  std::string text =
      fmt::format("{}: {}, {:.1f} MB", request.out, counted(frames, "file"), double(bytes) / 1e6);
  if (result.contains("windows"))
    text += fmt::format("; {} windows, at most {} Gaussians at a time",
                        result["windows"].get<int64_t>(), result["peak_gaussians"].get<int64_t>());
  text += loss_text(result);
  if (!result["floaters"].is_null())
    text += fmt::format(", {} floaters left out", result["floaters"].get<int64_t>());
  return text;
}

int export_command(const ExportRequest& request) {
  check_format(request.format);
  const TimeFormat* const in_time = find_time_format(request.format);
  check_options(request, in_time);
  set_thread_count(request.threads);
  Clip clip = load_clip(request.model);
  for (const std::string& warning : clip.warnings) warn(warning);
  check_places(request, clip.file);
  const nlohmann::json floaters = clean_if_asked(request, clip);
  if (!request.keep_world) {
    clip.edit([](GaussianModel& model) { model = model_in_source_world(model); });
    warn_of_origin(clip);
  }
  nlohmann::json result =
      in_time != nullptr ? in_time->write(request, clip) : export_frames(request, clip);
  warn_of_losses(*clip.head, clip.file.string(), request);  // of what has been written
  result.update(export_loss(request, clip));
  result["out"] = request.out;
  result["format"] = request.format;
  result["model"] = clip.file.string();
  if (clip.count() == 1) result["num_gaussians"] = clip.head->count();
  result["floaters"] = floaters;
  print_result(request.json, result, written_text(request, result));
  return kExitDone;
}

std::string format_list() {
  std::string text;
  for (const TimeFormat& format : time_formats())
    text += fmt::format("\n    {:<10}  {}", format.name, format.doc);
  for (const SplatFormat& format : splat_formats())
    text += fmt::format("\n    {:<10}  numbered {}: {}", format.name, format.extension, format.doc);
  return text;
}

void add_time_options(CLI::App& command, ExportTimes& times) {
  CLI::Option* frames =
      command.add_option("--frames", times.frames, "timesteps, evenly from first to last");
  CLI::Option* fps = command.add_option(
      "--fps", times.fps,
      "timesteps a second of the capture's clock; of formats that hold time: what "
      "a player steps by");
  CLI::Option* time =
      command.add_option("--time", times.time, "a single timestep, 0 (first) to 1 (last)");
  CLI::Option* range =
      command.add_option("--range", times.range,
                         "A:B, a part of the clip: 0 (first) to 1 (last), or with the unit s "
                         "seconds from its first timestep: 0.25:0.5, 2s:, :7.5s");
  fps->excludes(frames);
  time->excludes(frames);
  time->excludes(fps);
  time->excludes(range);
}

}  // namespace

void add_export_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("export", "write a model as player, 4D file or splat sequence");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<ExportRequest>();
  command
      ->add_option(
          "model", request->model,
          "output of `tessera run`, run folder, checkpoint, Tessera .ply or 4D file, or splats of "
          "other programs")
      ->required();
  command->add_option("-o,--out", request->out, "folder to write")->required();
  command->add_option("--format", request->format, "format of the files:" + format_list());
  add_time_options(*command, request->times);
  command->add_option("--spz-version", request->spz_version,
                      "version of .spz: 3, or 4 (read by fewer players)");
  command->add_flag("--page", request->page, "write the web player beside the frames");
  command->add_flag("--single", request->single, "Tessera 4D: write one file");
  command->add_flag("--lossless", request->lossless, "Tessera 4D: store floats without rounding");
  command->add_option("--segment", request->segment_seconds, "Tessera 4D: seconds of a segment");
  command->add_option(
      "--cameras", request->cameras,
      "Tessera 4D, --page, --clean: scene folder or transforms file whose cameras players "
      "offer; default: of the scene that the run was trained on");
  command->add_option("--audio", request->audio, "Tessera 4D: sound, which becomes the clock");
  command->add_option("--title", request->title, "pages: title");
  command->add_option("--description", request->description,
                      "pages: description, for search engines and for sites where the address is "
                      "posted");
  command->add_option("--poster", request->poster,
                      "pages: image that is shown while the scene loads: a PNG, JPEG or WebP file, "
                      "or auto: a held-out camera's view of the first timestep; default: none");
  command->add_flag("--truth", request->truth,
                    "pages: put six test images of the scene into the page, to compare with");
  command->add_flag_function(
      "--clean,!--no-clean", [request](int64_t count) { request->clean = count > 0; },
      "leave out floaters: faint, large Gaussians that one training camera alone shows; default: "
      "of a page whose scene is there");
  command->add_flag("--keep-world", request->keep_world,
                    "stay in the world of the prepared scene; default: back in the capture's own");
  command->add_flag("--overwrite", request->overwrite,
                    "allow writing into a folder that holds other files");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return export_command(*request); }; });
}

}  // namespace tessera
