// Replaces placeholders of the player's page (web_page.h) by escaped text and data addresses,
// and encodes the test images.
#include "tools/export/page_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "ingest/files/png.h"
#include "kernels/base/errors.h"
#include "recon4d/training/scene_scale.h"
#include "static3d/tessera4d/player_hints.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/backend_options.h"
#include "tools/export/image_files.h"
#include "tools/session/model_scene.h"
#include "tools/video/video_encoder.h"
#include "tools/web/page_words.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

constexpr const char* kAuto = "auto";

struct ImageType {
  const char *type, *file;
};
constexpr std::array<ImageType, 3> kTypes{
    {{"image/png", "poster.png"}, {"image/jpeg", "poster.jpg"}, {"image/webp", "poster.webp"}}};

/// "" where it is none of them.
std::string type_of(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (bytes.starts_with("RIFF") && bytes.size() > 12 && bytes.substr(8, 4) == "WEBP")
    return "image/webp";
  return "";
}

std::string meta(const char* attribute, const char* name, const std::string& content) {
  return fmt::format("\n    <meta {}=\"{}\" content=\"{}\" />", attribute, name,
                     html_text(content));
}

std::string head_tags(const PageHead& head, bool beside) {
  const std::string title = head.title.empty() ? "Tessera" : head.title;
  std::string tags = fmt::format("<title>{}</title>", html_text(title));
  if (!head.description.empty()) tags += meta("name", "description", head.description);
  tags += meta("property", "og:type", "website") + meta("property", "og:title", title);
  if (!head.description.empty()) tags += meta("property", "og:description", head.description);
  if (!beside || head.poster.bytes.empty()) return tags;
  return tags + meta("property", "og:image", head.poster.file()) +
         meta("name", "twitter:card", "summary_large_image");
}

constexpr int kLongestSide = 800;  // pixels

View first_view(CameraChoice choice, const GaussianModel& model) {
  choice.split = "test";
  if (const std::vector<NamedView> views = find_views(choice, model); !views.empty())
    return views.front().view;
  choice.split.clear();
  return read_views(choice, model).front().view;
}

/// A PNG file, at most 800 pixels wide and high. The camera is the first of the scene's test split,
/// or its first one where it has none. `model`: as exported, in the world of `request`'s cameras.
/// Errors: InputError where the export has no camera.
std::string poster_view(const ExportRequest& request, const GaussianModel& model) {
  CameraChoice choice;
  choice.cameras = request.cameras.empty() ? scene_of_model(request.model) : request.cameras;
  choice.time = 0.0;
  if (choice.cameras.empty())
    throw InputError(
        "export: --poster auto needs a camera, and the model's scene is not there; pass --cameras, "
        "or an image file as --poster");
  View view = first_view(choice, model);
  view.camera = limited_camera(view.camera, kLongestSide);
  const std::unique_ptr<Backend> backend = make_backend("auto");
  const RenderedImage image = render_views(*backend, model, {view}).front();
  const TemporaryFolder folder("poster");
  write_image_png(folder.path() / "poster.png", image);
  return read_text_file(folder.path() / "poster.png");
}

constexpr int64_t kMostViews = 6;
constexpr int kMostWidth = 960;  // pixels
constexpr int kQuantiser = 4;    // of JPEG

std::string image_address(const Image8& image) {
  const Image8 small = narrowed_image(image, kMostWidth);
  if (const auto bytes = jpeg_bytes(small, kQuantiser)) return data_address("image/jpeg", *bytes);
  const TemporaryFolder folder("truth");
  write_png(folder.path() / "truth.png", small);
  return data_address("image/png", read_text_file(folder.path() / "truth.png"));
}

/// By the first bytes. Errors: InputError naming `path`: unreadable, empty, none of the three
/// types.
Poster poster_of_file(const std::string& path) {
  Poster poster{read_text_file(path), ""};
  poster.type = type_of(poster.bytes);
  if (poster.type.empty())
    throw InputError(
        fmt::format("{}: is no PNG, JPEG or WebP image; pass another --poster, or auto", path));
  return poster;
}

/// [{name, camera (as a manifest has it), t, image (data address of a JPEG or PNG file)}]: at most
/// six frames of the scene's test split, else of its val split, else of its train split, evenly
/// over them, at most 960 pixels wide. `model`: as exported, in the world of the cameras.
/// Errors: InputError: the scene of the model or of `request.cameras` cannot be read.
nlohmann::json truth_views(const ExportRequest& request, const GaussianModel& model) {
  const std::filesystem::path place =
      request.cameras.empty() ? scene_of_model(request.model) : request.cameras;
  if (place.empty())
    throw InputError(
        "export: --truth needs the scene's images, and the model's scene is not there; pass the "
        "scene as --cameras");
  nlohmann::json views = nlohmann::json::array();
  for (const Frame& frame : scene_for(model, request.model, place, {.held_out = kMostViews}).frames)
    views.push_back(truth_json(frame, image_address(frame.image)));
  return views;
}

}  // namespace

std::string Poster::file() const {
  if (bytes.empty()) return "";
  for (const ImageType& image : kTypes)
    if (type == image.type) return image.file;
  check(false, "poster: its type is none of the known ones");
  return "";
}

PageHead page_head(const ExportRequest& request, const GaussianModel& model) {
  PageHead head{request.title, request.description, {}, {}};
  if (request.truth) head.truth = json_text(truth_views(request, model));
  if (request.poster == kAuto)
    head.poster.bytes = poster_view(request, model);
  else if (!request.poster.empty())
    head.poster = poster_of_file(request.poster);
  return head;
}

std::string with_head(std::string page, const PageHead& head, bool beside) {
  fill_place(page, kPageTitle, head_tags(head, beside));
  if (!head.poster.bytes.empty())
    fill_place(page, kPlayerPoster,
               fmt::format(R"(<img id="poster" alt="" src="{}" />)",
                           data_address(head.poster.type.c_str(), head.poster.bytes)));
  return page;
}

}  // namespace tessera
