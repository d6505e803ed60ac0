// State edits on sets in which every number is known: the elements that remain and their order, in
// host memory and in a separate memory, and edits that are refused.
#include "recon4d/model/train_state.h"

#include <gtest/gtest.h>

#include "recon4d/model/element_edits.h"
#include "tests/recon4d/model/handmade_set.h"
#include "tests/support/separate_backend.h"

namespace tessera::testing {
namespace {

using Tags = std::vector<Tag>;

/// 9 static and 7 dynamic Gaussians, tagged by their element; statistics count 100 k + tag + 1.
TrainState tagged_state(SetForm form = SetForm::kPair) {
  HandmadeSet fixed(SetForm::kStatic, 9), moving(form, 7);
  TrainState state;
  state.model.static_set = std::move(fixed.set);
  state.model.dynamic_set = std::move(moving.set);
  state.statistics[0] = std::move(fixed.statistics);
  state.statistics[1] = std::move(moving.statistics);
  for (int k = 0; k < 2; ++k)
    for (int64_t n = 0; n < state.set(k).count(); ++n)
      state.statistics[k].count[n] = float(100 * k + n + 1);
  return state;
}

GaussianSet tagged(SetForm form, const Tags& tags) {
  HandmadeSet made(form, int64_t(tags.size()));
  for (size_t n = 0; n < tags.size(); ++n) *made.set.values().at(kSh, int64_t(n)) = float(tags[n]);
  return std::move(made.set);
}

Tags tags_of(const TrainState& state, int k) {
  Tags tags;
  for (int64_t n = 0; n < state.set(k).count(); ++n)
    tags.push_back(Tag(*state.set(k).values().at(kSh, n)));
  return tags;
}

/// Two added sets for the dynamic set, as promotion and spawning give them.
StateEdit both_ways(SetForm form) {
  StateEdit edit;
  edit.dropped[0] = {1, 2};
  edit.dropped[1] = {0, 6};
  edit.added[0].push_back(tagged(SetForm::kStatic, {50}));
  edit.added[1].push_back(tagged(form, {60, 61}));
  edit.added[1].push_back(tagged(form, {70}));
  return edit;
}

/// All values and the optimizer state of an element, by group.
std::vector<float> element_of(const GaussianSet& set, int64_t n) {
  std::vector<float> element;
  for (int g = 0; g < set.groups(); ++g) {
    const ParameterGroup& group = set.group(Group(g));
    const int64_t width = set.width(Group(g));
    for (const Buffer<float>* values : {&group.value, &group.moment1, &group.moment2})
      if (!values->empty())
        element.insert(element.end(), values->begin() + n * width,
                       values->begin() + (n + 1) * width);
  }
  return element;
}

// Bug put back: the last of the added sets first; seen to fail.
TEST(StateEdit, ElementsStandInTheOrderOfTheEdit) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    TrainState state = tagged_state(form);
    apply_edit(*make_cpu_backend(), both_ways(form), state);
    EXPECT_EQ(tags_of(state, 0), (Tags{0, 3, 4, 5, 6, 7, 8, 50}));
    EXPECT_EQ(tags_of(state, 1), (Tags{1, 2, 3, 4, 5, 60, 61, 70}));
  }
}

// Bug put back: statistics of added elements on the host; seen to fail.
TEST(StateEdit, IsTheSameInASeparateMemory) {
  SeparateBackend backend;
  TrainState state = tagged_state().clone_to(backend.memory());
  apply_edit(backend, both_ways(SetForm::kPair), state);
  const TrainState here = state.clone_to(host_memory());
  EXPECT_EQ(tags_of(here, 0), (Tags{0, 3, 4, 5, 6, 7, 8, 50}));
  EXPECT_EQ(tags_of(here, 1), (Tags{1, 2, 3, 4, 5, 60, 61, 70}));
  EXPECT_EQ(backend.strays, 0);
}

// Bug put back: statistics reset, so that the next density control had none; seen to fail.
TEST(StateEdit, KeptElementsKeepTheirValuesMomentsAndStatistics) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    const TrainState before = tagged_state(form);
    TrainState state = tagged_state(form);
    apply_edit(*make_cpu_backend(), both_ways(form), state);
    const Tags kept[2] = {{0, 3, 4, 5, 6, 7, 8}, {1, 2, 3, 4, 5}};
    for (int k = 0; k < 2; ++k) {
      ASSERT_EQ(state.statistics[k].count.size(), state.set(k).count());
      for (int64_t i = 0; i < state.set(k).count(); ++i) {
        const bool is_kept = i < int64_t(kept[k].size());
        const float count = is_kept ? float(100 * k + kept[k][size_t(i)] + 1) : 0.0f;
        EXPECT_EQ(state.statistics[k].count[i], count) << k << i;
        if (is_kept)
          EXPECT_EQ(element_of(state.set(k), i), element_of(before.set(k), kept[k][size_t(i)]));
        else
          EXPECT_EQ(state.set(k).group(kMean).moment1[3 * i], 0.0f) << k << i;
      }
    }
  }
}

// Bug put back: degrees assigned before elements are added; seen to fail.
TEST(StateEdit, DegreesAreOfTheElementsThatAreThereInTheEnd) {
  TrainState state = tagged_state();
  StateEdit edit = both_ways(SetForm::kPair);
  edit.degrees[0] = {1, 0, 1, 0, 0, 0, 1, 0};
  apply_edit(*make_cpu_backend(), edit, state);
  EXPECT_EQ(sh_degrees(state.set(0)), (std::vector<uint8_t>{1, 1, 1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(sh_degrees(state.set(1)), std::vector<uint8_t>(8, 1)) << "these stay";
}

/// Added elements stand behind those of their degree, which moves the elements of other degrees.
// Bug put back: additions before drops; seen to fail.
TEST(StateEdit, DroppedElementsAreThoseBeforeTheAdditions) {
  TrainState state = tagged_state();
  StateEdit degrees, edit;
  degrees.degrees[0] = {1, 0, 1, 0, 0, 0, 1, 0, 0};
  apply_edit(*make_cpu_backend(), degrees, state);
  const auto places = [&] {
    std::vector<float> x;
    for (int64_t n = 0; n < state.set(0).count(); ++n)
      x.push_back(state.set(0).group(kMean).value[3 * n]);
    return x;
  };
  std::vector<float> expected = places();
  edit.dropped[0] = {7};
  edit.added[0].push_back(tagged(SetForm::kStatic, {50}));
  apply_edit(*make_cpu_backend(), edit, state);
  expected.erase(expected.begin() + 7);
  expected.insert(expected.begin() + 3, edit.added[0][0].group(kMean).value[0]);
  EXPECT_EQ(places(), expected);
}

// Bug put back: elements that do not exist passed over; seen to fail.
TEST(StateEdit, RefusesElementsThatAreNotThere) {
  for (const std::vector<int64_t>& dropped :
       {std::vector<int64_t>{9}, {-1}, {5, 2}, {3, 3}, {0, 1, 12}}) {
    TrainState state = tagged_state();
    StateEdit edit;
    edit.dropped[0] = dropped;
    EXPECT_THROW(apply_edit(*make_cpu_backend(), edit, state), std::logic_error) << dropped[0];
  }
}

// Bug put back: an edit with an empty set taken for a change; seen to fail.
TEST(StateEdit, IsEmptyWithoutElements) {
  StateEdit edit;
  EXPECT_TRUE(edit.empty());
  edit.added[1].push_back(tagged(SetForm::kPair, {}));
  EXPECT_TRUE(edit.empty());
  edit.added[1].push_back(tagged(SetForm::kPair, {5}));
  EXPECT_FALSE(edit.empty());
  StateEdit drops, degrees;
  drops.dropped[1] = {4};
  degrees.degrees[0] = {0};
  EXPECT_FALSE(drops.empty());
  EXPECT_FALSE(degrees.empty());
}

}  // namespace
}  // namespace tessera::testing
