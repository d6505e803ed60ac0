// The rows of the option table, which four files beside this one add.
#pragma once
#include <type_traits>
#include <utility>
#include <vector>

#include "recon4d/options/train_options.h"

namespace tessera {

/// Of a number, inclusive, and which suffixes its text may have.
struct OptionRange {
  double low, high;
  Unit unit = Unit::kNone;
};

/// Each call adds a row under the heading that group() named last. `source` is that of the default,
/// `doc` the meaning.
class OptionRows {
 public:
  static std::vector<TrainOption> all();

 private:
  using O = TrainOptions;
  using Member = decltype(TrainOption::member);

  static constexpr OptionRange kSteps{0, 1e9, Unit::kCount}, kPositiveSteps{1, 1e9, Unit::kCount},
      kGaussians{0, 1e9, Unit::kCount}, kDistance{0, 1e9, Unit::kWorld}, kRate{0, 1e3},
      kShare{0, 1}, kWeight{0, 1e6};

  /// The length of a training, the scene, the initial Gaussians, what a Gaussian is and how it is
  /// drawn.
  void add_model();
  void add_motion();
  /// The loss and learning rates.
  void add_optimisation();
  /// Density control, the size of the model, how kernels work.
  void add_growth();

  void group(const char* heading) { group_ = heading; }
  OptionRows& number(const char* key, Member member, OptionRange range, const char* source,
                     const char* doc) {
    return add(key, std::move(member), range, source, doc);
  }
  OptionRows& on_off(const char* key, bool O::*member, const char* source, const char* doc) {
    return add(key, member, {0, 1}, source, doc);
  }
  OptionRows& text(const char* key, std::string O::*member, const char* source, const char* doc) {
    return add(key, member, {0, 0}, source, doc);
  }
  /// One of the names of an enumeration.
  template <auto kMember>
  OptionRows& choice(const char* key, const char* source, const char* doc) {
    using Enum = std::remove_reference_t<decltype(std::declval<O&>().*kMember)>;
    return add(key,
               ChoiceMember{choice_names<Enum>(),
                            [](const O& options) { return size_t(options.*kMember); },
                            [](O& options, size_t value) { options.*kMember = Enum(value); }},
               {0, 0}, source, doc);
  }
  /// Help shows this value as an example of the row that was added last.
  void example(const char* example) { rows_.back().example = example; }

  OptionRows& add(const char* key, Member member, OptionRange range, const char* source,
                  const char* doc);

  std::vector<TrainOption> rows_;
  const char* group_ = "";
};

}  // namespace tessera
