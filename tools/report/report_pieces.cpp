// Formats numbers and images, and embeds style and script of this folder by the assembler.
#include "tools/report/report_pieces.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "tools/report/run_images.h"
#include "tools/web/page_words.h"

#define TESSERA_PAGE_FILE(name, path) \
  asm(".pushsection .rodata\n"        \
      ".global tessera_report_" #name \
      "\n"                            \
      "tessera_report_" #name         \
      ":\n"                           \
      ".incbin \"" path               \
      "\"\n"                          \
      ".byte 0\n"                     \
      ".popsection\n");               \
  extern "C" const char tessera_report_##name[]
TESSERA_PAGE_FILE(css, TESSERA_REPORT_CSS);
TESSERA_PAGE_FILE(js, TESSERA_REPORT_JS);
#undef TESSERA_PAGE_FILE

namespace tessera {
namespace {

std::string decibels(const ScoredView& view) {
  std::string text = fmt::format("PSNR {:.2f} dB", view.psnr);
  if (view.psnr_dynamic) text += fmt::format(", moving pixels {:.1f} dB", *view.psnr_dynamic);
  if (view.psnr_static) text += fmt::format(", static pixels {:.1f} dB", *view.psnr_static);
  return text;
}

std::string image_tag(const EncodedImage& image, const std::string& description, int width,
                      int height, const std::string& more = "") {
  return fmt::format("<img alt=\"{}\" width=\"{}\" height=\"{}\"{} src=\"{}\">",
                     html_text(description), width, height, more,
                     data_address(image.type.c_str(), image.bytes));
}

}  // namespace

std::string time_words(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const int64_t whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string size_words(int64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  if (bytes < 1'000'000) return fmt::format("{:.1f} kB", double(bytes) / 1e3);
  if (bytes < 1'000'000'000) return fmt::format("{:.1f} MB", double(bytes) / 1e6);
  return fmt::format("{:.2f} GB", double(bytes) / 1e9);
}

std::string fact_html(const std::string& name, const std::string& html) {
  if (html.empty()) return "";
  return fmt::format("<dt>{}</dt><dd>{}</dd>\n", html_text(name), html);
}

std::string fact(const std::string& name, const std::string& value) {
  return fact_html(name, html_text(value));
}

std::string compared_view(const ShownView& view) {
  const auto image = [&](const EncodedImage& encoded, const char* what, const char* more) {
    return image_tag(encoded, fmt::format("{} of {}", what, view.view.name), view.width,
                     view.height, more);
  };
  return fmt::format(
      "<article class=\"card tell\">\n<header><strong>{}</strong><span>{}</span>"
      "<span class=\"soft\">{}</span></header>\n<div class=\"pair\">\n<figure>\n"
      "<div class=\"compare\">{}{}<span class=\"left\">truth</span>"
      "<span class=\"right\">result</span></div>\n"
      "<input class=\"slider\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.5\" "
      "aria-label=\"where the truth ends and the result begins\">\n</figure>\n"
      "<figure>{}<figcaption>Error: mean absolute difference of the channels</figcaption></figure>"
      "\n</div>\n</article>\n",
      html_text(view.title), html_text(decibels(view.view)), html_text(view.view.name),
      image(view.truth, "truth", " draggable=\"false\""),
      image(view.result, "result", " class=\"above\" draggable=\"false\""),
      image(view.error, "error", ""));
}

std::string camera_strip(const CameraStrip& strip) {
  std::string frames;
  for (const ShownView& view : strip.views) {
    const auto image = [&](const EncodedImage& encoded, const char* what) {
      return image_tag(encoded, fmt::format("{} of {}", what, view.view.name), view.width,
                       view.height);
    };
    frames += fmt::format("<div>{}{}{}<span class=\"soft\">{:.2f} dB, time {:.2f}</span></div>\n",
                          image(view.truth, "truth"), image(view.result, "result"),
                          image(view.error, "error"), view.view.psnr, view.view.time);
  }
  return fmt::format(
      "<h3>{}</h3>\n<div class=\"striprow\"><div class=\"names\"><span>truth</span>"
      "<span>result</span><span>error</span></div>\n<div class=\"strip\" tabindex=\"0\">\n{}</div>"
      "</div>\n",
      html_text(strip.camera), frames);
}

std::string error_scale() {
  return fmt::format(
      "<div class=\"scale\"><span>error 0</span><i style=\"background: {}\"></i>"
      "<span>{}/255 and more</span></div>\n",
      error_scale_css(), kLargestShownError);
}

std::string report_frame(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n"
      "<style>\n{}</style>\n</head>\n<body>\n<main>\n{}</main>\n<script>\n{}</script>\n</body>\n"
      "</html>\n",
      html_text(title), std::string_view(tessera_report_css), body,
      std::string_view(tessera_report_js));
}

}  // namespace tessera
