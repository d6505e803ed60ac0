// Charts of benchmarks: their points, lines and labels and the positions of these; published
// figures and the checks of their file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tests/support/scratch_folder.h"
#include "tools/bench/scene_chart.h"
#include "tools/bench/size_chart.h"
#include "tools/report/svg_chart.h"

namespace tessera {
namespace {

using nlohmann::json;

json spread(double value) {
  return {{"median", value}, {"least", 0.9 * value}, {"most", 1.1 * value}, {"count", 3}};
}

json point(const std::string& label, int64_t steps, double seconds, double psnr, bool frontier,
           bool knee = false) {
  return {{"label", label},
          {"iterations", steps},
          {"metrics",
           {{"seconds", spread(seconds)}, {"psnr", spread(psnr)}, {"bytes", spread(3e6 * psnr)}}},
          {"frontier", frontier},
          {"knee", knee}};
}

json scene(const std::string& name) {
  return {{"scene", name},
          {"split", "val"},
          {"points",
           {point("balanced", 3000, 40, 27, true, true), point("fast", 1000, 4, 20, true),
            point("balanced", 9000, 400, 28, true), point("fast", 3000, 200, 22, false),
            point("a <method>", 1000, 30, 21, false)}}};
}

ImageRequest request(BenchImage kind, const std::string& name) {
  ImageRequest request;
  request.kind = kind;
  request.emphasised = "balanced";
  request.published = {{{"name", "a <method>"},
                        {"scene", name},
                        {"psnr", 26.5},
                        {"seconds", 300},
                        {"device", "some card"}},
                       {{"name", "elsewhere"},
                        {"scene", "other"},
                        {"psnr", 1},
                        {"seconds", 1},
                        {"device", "some card"}}};
  return request;
}

struct Place {
  double x = 0, y = 0;
};

/// Panels of an image: what lies in each of its groups.
std::vector<std::string> panels(const std::string& svg) {
  std::vector<std::string> parts;
  for (size_t begin = svg.find("<g "); begin != std::string::npos;
       begin = svg.find("<g ", begin + 1))
    parts.push_back(svg.substr(begin, svg.find("</g>", begin) - begin));
  return parts;
}

/// Two numbers of each match.
std::vector<Place> places(const std::string& svg, const std::string& pattern) {
  std::vector<Place> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator it(svg.begin(), svg.end(), expression), end; it != end; ++it)
    found.push_back({std::stod((*it)[1]), std::stod((*it)[2])});
  return found;
}

std::vector<Place> dots(const std::string& panel, const std::string& colour) {
  return places(panel, "cx=\"([0-9.]+)\" cy=\"([0-9.]+)\" r=\"[0-9.]+\" fill=\"" + colour + "\"");
}

/// Numbers of a path's M and L: its corners.
std::vector<Place> dashed(const std::string& panel) {
  std::smatch path;
  const std::regex expression("d=\"([^\"]+)\"[^>]*stroke-dasharray");
  if (!std::regex_search(panel, path, expression)) return {};
  return places(path[1], "[ML]([0-9.]+) ([0-9.]+)");
}

// Bugs put back, each seen to fail: places by the least of the seeds; MiB in bytes; a colour by the
// place in the list.
TEST(BenchImages, PointsAreAtTheirPlaces) {
  const std::string svg = scene_svg(scene("lego"), request(BenchImage::kChart, "lego"));
  EXPECT_NE(svg.find(">lego (val): quality against training time and size"), std::string::npos);
  const std::vector<std::string> both = panels(svg);
  ASSERT_EQ(both.size(), 2u) << svg;
  for (const char* part : {">training time [s]<", ">PSNR [dB]<", ">fast<", ">balanced (default)<"})
    EXPECT_NE(both[0].find(part), std::string::npos) << part << " is not in\n" << both[0];
  EXPECT_NE(both[1].find(">model [MiB]<"), std::string::npos) << both[1];
  // from 3.6 to 440 s: the axis is from 2 to 500 s; from 18 to 30.8 dB: from 15 to 35 dB
  const auto x = [](double seconds) { return 68 + 390 * std::log(seconds / 2) / std::log(250); };
  const auto y = [](double psnr) { return 244 - 210 * (psnr - 15) / 20; };
  const std::vector<Place> found = dots(both[0], preset_colour("balanced"));
  ASSERT_EQ(found.size(), 2u) << both[0];
  EXPECT_NEAR(found[0].x, x(40), 0.1);
  EXPECT_NEAR(found[0].y, y(27), 0.1);
  EXPECT_NEAR(found[1].x, x(400), 0.1);
  EXPECT_NEAR(found[1].y, y(28), 0.1);
  EXPECT_EQ(dots(both[0], preset_colour("fast")).size(), 2u);
  // 51 to 88 MiB: the axis is from 50 to 100 MiB
  const std::vector<Place> sizes = dots(both[1], preset_colour("balanced"));
  ASSERT_EQ(sizes.size(), 2u) << both[1];
  EXPECT_NEAR(sizes[0].x, 68 + 390 * std::log2(3e6 * 27 / (1 << 20) / 50), 0.1);
  EXPECT_NE(both[0].find(">9000<"), std::string::npos) << "steps of the emphasised label";
}

// Bugs put back, each seen to fail: all points on the front; the front in the order of the points;
// the front against the size, too.
TEST(BenchImages, TheFrontHasItsPointsAlone) {
  const std::string svg = scene_svg(scene("lego"), request(BenchImage::kChart, "lego"));
  const std::vector<std::string> both = panels(svg);
  ASSERT_EQ(both.size(), 2u);
  const std::vector<Place> corners = dashed(both[0]);
  ASSERT_EQ(corners.size(), 3u) << "of five points\n" << both[0];
  std::vector<Place> expected = dots(both[0], preset_colour("balanced"));
  expected.insert(expected.begin(), dots(both[0], preset_colour("fast"))[0]);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(corners[i].x, expected[i].x, 0.1);
    EXPECT_NEAR(corners[i].y, expected[i].y, 0.1);
  }
  const std::vector<Place> ring =
      places(both[0], "cx=\"([0-9.]+)\" cy=\"([0-9.]+)\" r=\"7.5\" fill=\"none\"");
  ASSERT_EQ(ring.size(), 2u) << "knee and legend";
  EXPECT_NEAR(ring[0].x, expected[1].x, 0.1);
  EXPECT_NE(both[0].find(">balanced, 3000 steps<"), std::string::npos);
  EXPECT_NE(both[0].find(">Pareto front<"), std::string::npos);
  EXPECT_TRUE(dashed(both[1]).empty()) << "the front is of time";
}

// Bugs put back, each seen to fail: entries of every scene drawn; an entry without bytes drawn at
// its seconds; names put in as they are.
TEST(BenchImages, PublishedFiguresAreThoseOfTheScene) {
  const std::string svg = scene_svg(scene("lego"), request(BenchImage::kChart, "lego"));
  const std::vector<std::string> both = panels(svg);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(places(both[0], "<rect x=\"([0-9.]+)\" y=\"([0-9.]+)\"").size(), 2u)
      << "one entry, and the legend\n"
      << both[0];
  EXPECT_NE(both[0].find(">a &lt;method&gt; (some card)<"), std::string::npos) << both[0];
  EXPECT_NE(both[0].find(">published, other hardware<"), std::string::npos);
  EXPECT_EQ(svg.find("elsewhere"), std::string::npos);
  EXPECT_EQ(svg.find("<method>"), std::string::npos);
  EXPECT_EQ(both[1].find("published"), std::string::npos) << "its bytes are not known";
}

// Bug put back: SSIM that was not measured drawn as 0; seen to fail.
TEST(BenchImages, ACurveHasBothScores) {
  json drawn = scene("lego");
  const ImageRequest curve = request(BenchImage::kCurve, "lego");
  EXPECT_EQ(panels(scene_svg(drawn, curve)).size(), 1u) << "no SSIM was measured";
  for (json& point : drawn["points"]) point["metrics"]["ssim"] = spread(0.9);
  const std::string svg = scene_svg(drawn, curve);
  ASSERT_EQ(panels(svg).size(), 2u);
  EXPECT_NE(panels(svg)[1].find(">SSIM<"), std::string::npos);
  EXPECT_EQ(svg.find("Pareto front"), std::string::npos);
  for (json& point : drawn["points"]) point["metrics"].erase("seconds");
  EXPECT_FALSE(can_be_drawn(drawn));
  EXPECT_EQ(scene_svg(drawn, curve), "");
}

json sized(const std::string& label, double mib, double psnr, int64_t share) {
  json sized = {{"label", label},
                {"iterations", 100},
                {"metrics", {{"shipped_bytes", spread(mib * (1 << 20))}, {"psnr", spread(psnr)}}}};
  if (share > 0) sized["share"] = share;
  return sized;
}

/// Two scenes; of the second a budget has failed and the reference is not done.
json sized_scenes() {
  json scenes = {
      {{"scene", "lego"},
       {"split", "test"},
       {"points",
        {sized("faster-gs", 40, 30, 0), sized("balanced", 10, 31, 0),
         sized("balanced+one-in-4-of-faster-gs", 5, 29, 4),
         sized("balanced+one-in-2-of-faster-gs", 8, 30.5, 2)}}},
      {{"scene", "<b>"},
       {"split", "val"},
       {"points",
        {sized("balanced", 4, 26, 0), sized("balanced+one-in-2-of-faster-gs", 2, 25, 2)}}}};
  json failed = sized("b4", 1, 1, 4);
  failed["metrics"].erase("psnr");
  scenes[1]["points"].push_back(failed);
  return scenes;
}

// Bugs put back, each seen to fail: shares in the order of the points; presets on the line.
TEST(BenchImages, SizesAreAPanelForEachScene) {
  const std::string svg = sizes_svg(sized_scenes());
  const std::vector<std::string> both = panels(svg);
  ASSERT_EQ(both.size(), 2u) << svg;
  for (const char* part : {">lego (test)<", ">shipped file [MiB]<", ">1/2<", ">1/4<", ">faster-gs<",
                           ">balanced<", ">balanced, 1/n of the reference&#39;s Gaussians<"})
    EXPECT_NE(both[0].find(part), std::string::npos) << part << " is not in\n" << both[0];
  EXPECT_NE(both[1].find(">&lt;b&gt; (val)<"), std::string::npos) << both[1];
  EXPECT_EQ(both[1].find("faster-gs"), std::string::npos) << "no reference in the second scene";
  EXPECT_EQ(both[1].find(">1/4<"), std::string::npos) << "it has no score";
  // 8 MiB, then 5 MiB; the axis is from 2 MiB to 50 MiB
  const std::vector<Place> line = places(both[0], "d=\"M([0-9.]+) [0-9.]+L([0-9.]+) [0-9.]+\"");
  ASSERT_EQ(line.size(), 1u) << both[0];
  EXPECT_NEAR(line[0].x, 68 + 390 * std::log(8 / 2.0) / std::log(25), 0.1);
  EXPECT_NEAR(line[0].y, 68 + 390 * std::log(5 / 2.0) / std::log(25), 0.1);
  EXPECT_EQ(dots(both[0], preset_colour("faster-gs")).size(), 2u) << "plot and legend";
  EXPECT_TRUE(has_sizes(sized_scenes()));
  EXPECT_FALSE(has_sizes(json::array({scene("lego")}))) << "no shipped bytes";
}

// Bug put back: an entry without seconds is let through; seen to fail.
TEST(BenchImages, PublishedFiguresAreChecked) {
  const testing::ScratchFolder folder;
  const auto file = folder / "published.json";
  const json good = {
      {"name", "x"}, {"scene", "lego"}, {"psnr", 20}, {"seconds", 3}, {"device", "some card"}};
  write_text_file(file, json{{"entries", {good}}}.dump());
  EXPECT_EQ(read_published(file), json::array({good}));
  write_text_file(file, json::array({good, good}).dump());
  EXPECT_EQ(read_published(file).size(), 2u);
  for (const char* key : {"name", "scene", "psnr", "seconds", "device"}) {
    json bad = good;
    bad.erase(key);
    write_text_file(file, json::array({good, bad}).dump());
    try {
      read_published(file);
      ADD_FAILURE() << "accepted without " << key;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("entry 1"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
    }
  }
  write_text_file(file, "3");
  EXPECT_THROW(read_published(file), InputError);
}

}  // namespace
}  // namespace tessera
