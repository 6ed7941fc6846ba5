#pragma once
/// Samples -> coefficients of the interpolating cubic B-spline, in place.
/// Recursive filters of Unser, Aldroubi & Eden, "B-Spline Signal Processing: Part II", IEEE Trans.
/// Signal Processing 41(2), 1993: pole z = sqrt(3) - 2, gain 6.

#include <cstddef>
#include <vector>

#include "pipeline/pack/lattice.h"

namespace beatlas::pack {

/// `lanes` independent lines side by side: sample n of lane l is data[n * lanes + l].
/// Whole-sample mirror at both ends; a line of one sample is its own coefficient.
void prefilter_mirrored(double* data, std::size_t length, std::size_t lanes);

/// The same for a periodic line of any length from 1.
void prefilter_periodic(double* data, std::size_t length, std::size_t lanes);

/// Periodic in phase, mirrored along x, y and z. `phases[p].size() == lattice.count()`.
void prefilter_cycle(const Lattice& lattice, std::vector<std::vector<float>>& phases);

}  // namespace beatlas::pack
