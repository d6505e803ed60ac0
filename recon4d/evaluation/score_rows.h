// The names and definitions of the scores that not every view has, one row each: means, JSON and
// its definitions walk over them.
#pragma once
#include "recon4d/evaluation/evaluate.h"

namespace tessera {

struct ScoreRow {
  const char* name;
  std::optional<double> OptionalScores::*score;
  const char* definition;
};

inline constexpr ScoreRow kScoreRows[] = {
    {"ssim", &OptionalScores::reflect,
     "11 taps, sigma 1.5, range 1, reflected, mean of the full map"},
    {"ssim_zero", &OptionalScores::zero, "as ssim, zeros outside the image (3DGS)"},
    {"ssim_inside", &OptionalScores::inside,
     "as ssim, windows inside the image alone (scikit-image, Gaussian)"},
    {"ssim_inside_range2", &OptionalScores::inside_range2,
     "as ssim_inside with the constants of range 2"},
    {"ms_ssim", &OptionalScores::multi_scale,
     "five scales, weights .0448 .2856 .3001 .2363 .1333, 2x2 means, reflected; null below 161 "
     "pixels or with a mask"},
    {"lpips", &OptionalScores::lpips, "of the network that was given; inputs in [-1, 1]"},
    {"psnr_dynamic", &OptionalScores::psnr_dynamic,
     "as psnr, pixels that differ from the camera's median over time by more than 10/255 in a "
     "channel"},
    {"psnr_static", &OptionalScores::psnr_static, "as psnr, the pixels not of psnr_dynamic"},
    {"psnr_fit", &OptionalScores::psnr_fit,
     "as psnr after the gain and offset of each camera and channel that leave the least squared "
     "error over all scored views of the camera"},
    {"psnr_fit_dynamic", &OptionalScores::psnr_fit_dynamic,
     "as psnr_fit by the same fit, pixels of psnr_dynamic"},
    {"psnr_fit_static", &OptionalScores::psnr_fit_static,
     "as psnr_fit by the same fit, pixels of psnr_static"},
};

}  // namespace tessera
