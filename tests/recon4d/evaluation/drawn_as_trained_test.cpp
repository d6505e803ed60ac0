// Models keep the render options of their training, in files and copies.
#include <map>

#include "recon4d/model/model_file.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/static3d/formats/model_to_spoil.h"

namespace tessera::testing {
namespace {

/// Allowed values, each other than the default.
DrawingRules unusual_rules() {
  DrawingRules rules;
  rules.sh_degree = 2;
  rules.sh_time_degree = 1;
  rules.sh_time_period = 0.75;
  rules.near_plane = 0.125;
  rules.far_plane = 77.5;
  rules.sliced_direction = false;
  rules.truncation_sigma = 2.25;
  rules.truncation_by_falloff = true;
  rules.filter_2d = true;
  rules.time_filter = 0.0375;
  return rules;
}

std::map<std::string, double> numbers_of(const DrawingRules& rules) {
  std::map<std::string, double> numbers;
  for_each_rule(rules, [&](const char* name, auto rule) { numbers[name] = double(rule); });
  return numbers;
}

// Bugs put back, each seen to fail: a rule left out of for_each_rule; `drawing` not copied.
TEST(DrawnAsTrained, EveryRuleIsKeptInFilesAndCopies) {
  const std::map<std::string, double> usual = numbers_of({}), unusual = numbers_of(unusual_rules());
  for (const auto& [name, number] : usual) EXPECT_NE(number, unusual.at(name)) << name;
  GaussianModel model = random_model(3, 5);
  model.drawing = unusual_rules();
  model.train_scale = 0.5;
  const TemporaryFolder folder;
  save_model(folder / "unusual.ply", model);
  const GaussianModel loaded = load_model(folder / "unusual.ply");
  EXPECT_TRUE(loaded.drawing == unusual_rules());
  EXPECT_TRUE(loaded.clone_values().drawing == unusual_rules());
  EXPECT_EQ(numbers_of(loaded.drawing), unusual);
  EXPECT_EQ(loaded.train_scale, 0.5);
  EXPECT_EQ(loaded.clone_values().train_scale, 0.5);
}

// Bugs put back, each seen to fail: a comment that is missing is the default; wrong_rule not asked.
TEST(DrawnAsTrained, FilesWithoutARuleOrWithAWrongOneAreRefused) {
  const ModelToSpoil model(random_model(3, 5));
  for (const auto& [name, number] : numbers_of({})) {
    const auto path = model.with("comment " + name + " ", "comment other_" + name + " ");
    expect_input_error([&] { load_model(path); }, {"changed.ply", name});
    model.with("comment " + name + " ", "comment " + name + " -");
    if (number != 0)
      expect_input_error([&] { load_model(path); }, {"changed.ply", name, "expected"});
    model.with("comment " + name + " ", "comment " + name + " nan");
    expect_input_error([&] { load_model(path); }, {"changed.ply", name, "1 numbers"});
  }
  const auto path = model.with("comment far_plane 123.456", "comment far_plane 0.05");
  expect_input_error([&] { load_model(path); }, {"far_plane", "more than near_plane"});
  model.with("comment far_plane 123.456", "comment far_plane 1e12");
  expect_input_error([&] { load_model(path); }, {"far_plane", "at most 2^32 times near_plane"});
  model.with("comment sh_degree 3", "comment sh_degree 4");
  expect_input_error([&] { load_model(path); }, {"sh_degree", "0 to 3"});
  model.with("comment sh_degree 3", "comment sh_degree 2.5");
  expect_input_error([&] { load_model(path); }, {"sh_degree is 2.5", "a whole number"});
}

// Bug put back: render_options leaves one of them at its default; seen to fail.
TEST(DrawnAsTrained, EachChangesTheImage) {
  const GaussianModel model = random_model(30, 30);
  const View view = three_views()[0];
  const RenderedImage usual = render_one(model, view);
  GaussianModel other = clone(model);
  other.drawing.filter_2d = true;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
  other = clone(model);
  other.drawing.truncation_sigma = 2;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
  other = clone(model);
  other.drawing.truncation_by_falloff = true;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
  other = clone(model);
  other.drawing.time_filter = 0.1;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
}

}  // namespace
}  // namespace tessera::testing
