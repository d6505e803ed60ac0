// Writes the models and cameras of the browser tests: static torus and boxes with texture and a
// swarm that moves for three seconds, the same scene with torus and boxes carried by motion nodes,
// and a few Gaussians as a file of two windows. The bytes are equal on every run. Usage:
// fixture_model FOLDER.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <numbers>

#include "ingest/files/atomic_file.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/model/model_file.h"
#include "tests/browser/fixture_nodes.h"
#include "tests/browser/fixture_windows.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int64_t kTorus = 700, kBox = 100, kBoxes = 3;       // static: 1,000
constexpr int64_t kLong = 500, kShort = 500, kPassing = 200;  // dynamic: 1,200
constexpr double kSeconds = 3;                                // of the clip
constexpr double kOrigin = 10;                                // its first timestep

float logit(double opacity) {
  return float(std::log(opacity / (1 - opacity)));
}

/// One row of a set, filled from the outside in.
class Row {
 public:
  Row(GaussianSet& set, int64_t n) : values_(set.values()), n_(n) {
    for (int g = 0; g < set.groups(); ++g)
      std::fill_n(values_.at(Group(g), n), set.width(Group(g)), 0.0f);
  }
  void place(const glm::dvec3& mean, const glm::dvec3& scale, double opacity) {
    for (int k = 0; k < 3; ++k) {
      values_.at(kMean, n_)[k] = float(mean[k]);
      values_.at(kLogScale, n_)[k] = float(std::log(scale[k]));
    }
    *values_.at(kOpacityLogit, n_) = logit(opacity);
  }
  /// A unit quaternion, every rotation equally often.
  void turn(Random& random) {
    const double u = random.uniform(0, 1), a = random.uniform(0, kTurn),
                 b = random.uniform(0, kTurn);
    const double q[] = {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
                        std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
    for (int k = 0; k < 4; ++k) values_.at(kRotation, n_)[k] = float(q[k]);
  }
  void paint(const glm::dvec3& rgb) {
    for (int c = 0; c < 3; ++c) values_.at(kSh, n_)[c] = float((rgb[c] - 0.5) / kSh0);
  }
  /// Colours that depend on where they are seen from, all three degrees.
  void shine(Random& random) {
    for (int i = 1; i < kMaxShCoefficients; ++i)
      for (int c = 0; c < 3; ++c)
        values_.at(kSh, n_)[3 * i + c] = float(random.uniform(-0.25, 0.25) / std::sqrt(double(i)));
  }
  /// `timestep`, `life` (standard deviation) and `velocity` by seconds of the clip.
  void move(const glm::dvec3& velocity, double timestep, double life) {
    *values_.at(kMeanTime, n_) = float(timestep / kSeconds);
    *values_.at(kLogScaleTime, n_) = float(std::log(life / kSeconds));
    for (int k = 0; k < 3; ++k) values_.at(kVelocity, n_)[k] = float(velocity[k] * kSeconds);
  }

 private:
  GaussianSpans<float> values_;
  int64_t n_;
};

/// Around the y axis, striped; every other Gaussian shines.
void add_torus(GaussianSet& set, Random& random) {
  for (int64_t n = 0; n < kTorus; ++n) {
    const double u = random.uniform(0, kTurn), v = random.uniform(0, kTurn);
    const double around = 1.1 + 0.35 * std::cos(v);
    Row row(set, n);
    row.place({around * std::cos(u), 0.35 * std::sin(v), around * std::sin(u)},
              {random.uniform(0.05, 0.09), random.uniform(0.04, 0.08), random.uniform(0.02, 0.04)},
              random.uniform(0.5, 0.97));
    row.turn(random);
    const bool stripe = std::sin(6 * u + 2 * v) > 0;
    row.paint({stripe ? 0.85 : 0.2, 0.5 + 0.35 * std::sin(u), 0.5 + 0.35 * std::cos(v)});
    if (n % 2 == 0) row.shine(random);
  }
}

/// One on each axis, so that a flipped axis is seen: red on x, green on y, blue on z.
void add_boxes(GaussianSet& set, Random& random) {
  for (int64_t box = 0; box < kBoxes; ++box)
    for (int64_t n = 0; n < kBox; ++n) {
      glm::dvec3 centre(0);
      glm::dvec3 rgb(0.15);
      centre[int(box)] = 0.75;
      rgb[int(box)] = 0.9;
      Row row(set, kTorus + box * kBox + n);
      const glm::dvec3 inside(random.uniform(-0.15, 0.15), random.uniform(-0.15, 0.15),
                              random.uniform(-0.15, 0.15));
      row.place(centre + inside, glm::dvec3(0.04), random.uniform(0.6, 0.95));
      row.turn(random);
      row.paint(rgb);
    }
}

/// Somewhere in a shell about the torus, drifting sideways.
void add_mover(GaussianSet& set, int64_t n, double timestep, double life, double speed,
               Random& random) {
  const double angle = random.uniform(0, kTurn), height = random.uniform(-1.1, 1.1);
  const glm::dvec3 out(std::cos(angle), 0, std::sin(angle));
  const glm::dvec3 along(-out.z, random.uniform(-0.4, 0.4), out.x);
  Row row(set, n);
  row.place(random.uniform(0.3, 1.7) * out + glm::dvec3(0, height, 0),
            {random.uniform(0.03, 0.07), random.uniform(0.03, 0.06), random.uniform(0.02, 0.05)},
            random.uniform(0.4, 0.95));
  row.turn(random);
  row.paint({0.5 + 0.45 * std::cos(angle), 0.5 + 0.4 * height, 0.5 + 0.45 * std::sin(angle)});
  if (n % 4 == 0) row.shine(random);
  row.move(speed * along, timestep, life);
}

/// Seen for the whole clip; for a tenth of a second to half a second; for about a second. Some are
/// brightest before the clip begins or after it has ended.
void add_swarm(GaussianSet& set, Random& random) {
  int64_t n = 0;
  for (; n < kLong; ++n)
    add_mover(set, n, random.uniform(-0.5, 3.5), random.uniform(2, 8), 0.15, random);
  for (; n < kLong + kShort; ++n)
    add_mover(set, n, random.uniform(-0.1, 3.1), random.uniform(0.04, 0.2), 1.2, random);
  for (; n < kLong + kShort + kPassing; ++n)
    add_mover(set, n, random.uniform(0, 3), random.uniform(0.3, 0.6), 0.5, random);
}

GaussianModel fixture_model() {
  Random random(2026);
  GaussianModel model;
  model.static_set = GaussianSet(SetForm::kStatic, kMaxShCoefficients);
  model.static_set.resize(kTorus + kBoxes * kBox);
  add_torus(model.static_set, random);
  add_boxes(model.static_set, random);
  model.dynamic_set = GaussianSet(SetForm::kVelocity, kMaxShCoefficients);
  model.dynamic_set.resize(kLong + kShort + kPassing);
  add_swarm(model.dynamic_set, random);
  model.time_axis = {kOrigin, kSeconds};
  return model;
}

/// Camera to world, OpenGL axes (+x right, +y up, −z forward), the world's y pointing down.
nlohmann::json frame_of(const std::string& name, const glm::dvec3& eye) {
  const glm::dvec3 back = glm::normalize(eye), up(0, -1, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(up, back)), top = glm::cross(back, right);
  nlohmann::json matrix = nlohmann::json::array();
  for (int k = 0; k < 3; ++k) matrix.push_back({right[k], top[k], back[k], eye[k]});
  matrix.push_back({0, 0, 0, 1});
  return {{"file_path", name}, {"time", kOrigin}, {"transform_matrix", matrix}};
}

nlohmann::json cameras() {
  return {{"w", 320},
          {"h", 240},
          {"fl_x", 300},
          {"fl_y", 300},
          {"cx", 160},
          {"cy", 120},
          {"frames",
           {frame_of("front", {0.4, -1.1, -4.6}), frame_of("side", {4.2, -0.3, 1.5}),
            frame_of("above", {-1.6, -4.0, -1.4})}}};
}

/// Every `step`-th Gaussian of each set, for files that a person can look through.
GaussianModel few_of(const GaussianModel& model, int64_t step) {
  GaussianModel few = model.clone_values();
  for (GaussianSet* set : {&few.static_set, &few.dynamic_set}) {
    std::vector<int64_t> rows;
    for (int64_t n = step / 2; n < set->count(); n += step) rows.push_back(n);
    *set = select_elements(*set, rows);
  }
  return few;
}

/// Without its dynamic set.
GaussianModel still_part_of(const GaussianModel& model) {
  GaussianModel still = model.clone_values();
  still.dynamic_set.resize(0);
  return still;
}

}  // namespace
}  // namespace tessera::testing

int main(int count, char** words) {
  if (count != 2) {
    std::fputs("usage: fixture_model FOLDER\n", stderr);
    return 2;
  }
  try {
    const std::filesystem::path folder = words[1];
    tessera::make_folder(folder);
    tessera::GaussianModel model = tessera::testing::fixture_model();
    tessera::save_model(folder / "model.ply", model);
    const tessera::GaussianModel few = tessera::testing::few_of(model, 121);
    tessera::save_model(folder / "few_static.ply", tessera::testing::still_part_of(few));
    tessera::save_model(folder / "few_moving.ply", few);
    tessera::testing::write_windows(folder, few, tessera::testing::few_of(model, 97));
    tessera::testing::Random random(7);
    tessera::testing::carry_by_nodes(model, random);
    tessera::save_model(folder / "carried.ply", model);
    tessera::save_model(folder / "few_carried.ply", tessera::testing::few_of(model, 121));
    tessera::write_text_file(folder / "transforms.json", tessera::testing::cameras().dump(1));
  } catch (const std::exception& error) {
    std::fputs(fmt::format("fixture_model: {}\n", error.what()).c_str(), stderr);
    return 1;
  }
  return 0;
}
