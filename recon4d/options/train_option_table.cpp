// The option table: the rows of its parts, once.
#include "recon4d/options/option_rows.h"

namespace tessera {

const std::vector<TrainOption>& train_option_table() {
  static const std::vector<TrainOption> table = [] {
    std::vector<TrainOption> rows = model_option_rows();
    for (const auto part : {motion_option_rows, optimisation_option_rows})
      for (TrainOption& row : part()) rows.push_back(std::move(row));
    return rows;
  }();
  return table;
}

}  // namespace tessera
