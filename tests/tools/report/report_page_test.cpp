// The page of a run from data written here: its sections, its size, and escaped text.
#include "tools/report/report_page.h"

#include <gtest/gtest.h>

#include "tools/report/report_pieces.h"

namespace tessera {
namespace {

constexpr const char* kHostile = "\"><script>alert('x')</script><img src=x onerror=y>{0}";

ShownView shown(const std::string& title, const ScoredView& view) {
  const EncodedImage image{"image/jpeg", "bytes"};
  return {title, view, image, image, image, 240, 180};
}

/// A run with something in every section; all its names are `text`.
RunPage page_of(const std::string& text) {
  RunPage page;
  page.title = text;
  RunReport& report = page.report;
  report.command = report.version = report.started = report.host = report.cpu = text;
  report.device = report.preset = text;
  report.split = "test";
  report.steps = 600;
  report.num_static = 12'345;
  report.stages = {{text, 3}, {"train", 241}};
  report.curves.psnr_test = {{300, 24}, {600, 28.31}};
  report.curves.loss = {{50, 0.3}, {600, 0.1}};
  report.scores = {{text, "28.31 dB"}};
  report.views = {{text, text, 0.5, 28.31, 21.5, {}}};
  report.decisions = {{200, text}};
  report.warnings = {{"ingest", text}};
  page.images.telling = {shown("Worst view", report.views[0])};
  page.images.strips = {{text, {shown("", report.views[0])}}};
  page.links = {{"Player", "../player/index.html", 3'300'000}, {"Model", "../run/model.ply", 812}};
  return page;
}

size_t count(const std::string& text, const std::string& part) {
  size_t found = 0;
  for (size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + 1)) ++found;
  return found;
}

// Bug put back: the name of a camera above its strip is put in as it is; seen to fail.
TEST(ReportPage, TextOfUsersIsNoMarkup) {
  const std::string page = run_page(page_of(kHostile));
  EXPECT_EQ(count(page, "<script>"), 1u) << "that of the page";
  EXPECT_EQ(count(page, "<img src=x"), 0u);
  EXPECT_EQ(count(page, "alert('x')"), 0u);
  EXPECT_GT(count(page, "&lt;script&gt;"), 10u);
}

// Bug put back: an image named by its file in place of its bytes; seen to fail.
TEST(ReportPage, NeedsNoOtherFileAndNoNetwork) {
  const std::string page = run_page(page_of("room"));
  EXPECT_EQ(count(page, "src=\""), 6u);
  EXPECT_EQ(count(page, "src=\"data:image/jpeg;base64,"), 6u);
  for (const char* outside : {"url(", "@import", "<link", "fetch(", "import "})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_EQ(count(page, "http"), count(page, "xmlns=\"http://www.w3.org/2000/svg\""));
}

TEST(ReportPage, HasAllSections) {
  RunPage data = page_of("room");
  data.report.started = "2026-11-24T09:30:00Z";
  const std::string page = run_page(data);
  for (const char* part :
       {"<h1>room</h1>", "28.31 dB", "Warnings", "Worst view", "Over time, by camera", "Training",
        "What the training decided", "4:04 min in all", "Command and machine", "All views",
        "href=\"../player/index.html\"", "(3.3 MB)", "error 0", "32/255 and more",
        "moving pixels 21.5 dB", "2026-11-24 09:30 UTC", "12.3k", "PSNR [dB]"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

// Bug put back: headings of empty sections; seen to fail.
TEST(ReportPage, SectionsWithoutDataAreLeftOut) {
  RunPage page;
  page.title = "empty";
  page.image_note = "The scene of this run is gone.";
  const std::string html = run_page(page);
  for (const char* part : {"Warnings", "Training", "decided", "All views", "in all", "NaN", "nan"})
    EXPECT_EQ(html.substr(html.find("<main>")).find(part), std::string::npos) << part;
  EXPECT_NE(html.find("The scene of this run is gone."), std::string::npos);
}

TEST(ReportPage, ChartsHaveUnitsAndTheColourOfThePreset) {
  RunPage page = page_of("balanced");
  const auto charts = run_charts(page.report);
  ASSERT_EQ(charts.size(), 2u) << "two without a point are left out";
  EXPECT_EQ(charts[0].first, "psnr");
  EXPECT_NE(charts[0].second.find("stroke=\"#0072B2\""), std::string::npos);
  EXPECT_EQ(charts[1].first, "loss");
}

TEST(ReportPage, NumbersHaveUnits) {
  EXPECT_EQ(time_words(3.21), "3.2 s");
  EXPECT_EQ(time_words(241.4), "4:01 min");
  EXPECT_EQ(time_words(3723), "1:02:03 h");
  EXPECT_EQ(size_words(812), "812 B");
  EXPECT_EQ(size_words(1'230'000), "1.2 MB");
}

}  // namespace
}  // namespace tessera
