// The rows of the option table in three parts, which train_option_table() joins.
#pragma once
#include <type_traits>
#include <utility>

#include "recon4d/options/train_options.h"

namespace tessera {

/// Headings of the rows.
namespace group {
inline constexpr const char *kLength = "Length", *kScene = "Scene", *kStart = "Initial Gaussians",
                            *kValidation = "Validation views", *kModel = "Model",
                            *kDrawing = "Rendering", *kLoss = "Loss and exposure",
                            *kRates = "Optimiser", *kDensity = "Density control",
                            *kMotion = "Motion nodes", *kSize = "Model size", *kSpeed = "Kernels";
}  // namespace group

/// The scene, the initial Gaussians, what a Gaussian is and how it is drawn.
std::vector<TrainOption> model_option_rows();
/// Motion nodes.
std::vector<TrainOption> motion_option_rows();
/// The loss, learning rates, density control, the size of the model, how kernels work.
std::vector<TrainOption> optimisation_option_rows();
std::vector<TrainOption> growth_option_rows();

template <auto Member>
ChoiceMember choice() {
  using Enum = std::remove_reference_t<decltype(std::declval<TrainOptions&>().*Member)>;
  return {choice_names<Enum>(), [](const TrainOptions& options) { return size_t(options.*Member); },
          [](TrainOptions& options, size_t value) { options.*Member = Enum(value); }};
}

}  // namespace tessera
