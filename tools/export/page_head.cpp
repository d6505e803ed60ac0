// Replaces the places of the player's page (player_page.h) by escaped text and a data address.
#include "tools/export/page_head.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tools/export/poster_view.h"
#include "tools/player/page_words.h"
#include "tools/player/player_page.h"

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

void fill(std::string& page, std::string_view place, const std::string& html) {
  const size_t position = page.find(place);
  check(position != std::string::npos, "player page: a place of its head is missing");
  page.replace(position, place.size(), html);
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

}  // namespace

std::string Poster::file() const {
  if (bytes.empty()) return "";
  for (const ImageType& image : kTypes)
    if (type == image.type) return image.file;
  check(false, "poster: its type is none of the known ones");
  return "";
}

Poster poster_of_file(const std::string& path) {
  Poster poster{read_text_file(path), ""};
  poster.type = type_of(poster.bytes);
  if (poster.type.empty())
    throw InputError(
        fmt::format("{}: is no PNG, JPEG or WebP image; pass another --poster, or auto", path));
  return poster;
}

PageHead page_head(const ExportRequest& request, const GaussianModel& model) {
  PageHead head{request.title, request.description, {}};
  if (request.poster == kAuto)
    head.poster.bytes = poster_view(request, model);
  else if (!request.poster.empty())
    head.poster = poster_of_file(request.poster);
  return head;
}

std::string with_head(std::string page, const PageHead& head, bool beside) {
  fill(page, kPlayerTitle, head_tags(head, beside));
  if (!head.poster.bytes.empty())
    fill(page, kPlayerPoster,
         fmt::format(R"(<img id="poster" alt="" src="{}" />)",
                     data_address(head.poster.type.c_str(), head.poster.bytes)));
  return page;
}

}  // namespace tessera
