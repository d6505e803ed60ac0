// What: L1 + D-SSIM of a batch of views on a CUDA device, and its gradient, in one launch per pass.
// Not: the equation of SSIM (math/ssim.h); the loss from the sums (the backend's stage).
// Source: method A.15; the same numbers as stages/photometric.cpp up to rounding.
#pragma once
#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

#include "kernels/math/ewa.h"

namespace tessera {

struct PhotometricLaunch {
  const ViewArgs<float>* views;  // [B] device
  const uint8_t* const* truth;   // [B] device, each [height, width, 3]
  const uint8_t* const* mask;    // [B] device, each [height, width] or null; null: no view has one
  int view_count;                // B
  int max_width, max_height;     // largest of the batch, pixels
  int64_t pixels;                // of all views
  const float* colour;  // [3·pixels] channel c of view b at 3·first_pixel + c·width·height
  float* d_colour;      // same layout, written; nullptr: only the loss is wanted
  void* scratch;        // device, photometric_scratch_bytes(...), from cudaMalloc
  double* sums;         // [B, 2] device: Σ|I−G|, Σ SSIM over 3·H·W; written, not added to
  float l1_weight, dssim_weight;
  float moving_weight;  // factor of |I−G| where the mask is kMovingPixel
};

size_t photometric_scratch_bytes(int64_t pixels, int view_count, int max_width, int max_height,
                                 bool for_backward);

/// Asynchronous; errors are left to cudaGetLastError. Equal inputs give equal bits.
void launch_photometric(const PhotometricLaunch& args, cudaStream_t stream);

}  // namespace tessera
