// Reads and writes two-dimensional NumPy arrays (.npy versions 1 and 2) of floating-point numbers,
// as poses_bounds.npy of LLFF has them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

namespace tessera {

struct Matrix {
  int64_t rows = 0, columns = 0;
  std::vector<double> data;  // [rows, columns] row-major
  double& operator()(int64_t r, int64_t c) { return data[size_t(r * columns + c)]; }
  double operator()(int64_t r, int64_t c) const { return data[size_t(r * columns + c)]; }
};

/// Reads <f4 or <f8, C or Fortran order. Errors: InputError naming the file and what was seen.
Matrix read_npy(const std::filesystem::path& path);
/// Writes <f8, C order, version 1, atomically.
void write_npy(const std::filesystem::path& path, const Matrix& matrix);

}  // namespace tessera
