#include "pipeline/pack/spline_prefilter.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"

namespace beatlas::pack {
namespace {

const double kPole = std::sqrt(3.0) - 2.0;
constexpr double kGain = 6.0;
constexpr std::size_t kHorizon = 30;  // |pole|^30 is below double precision

// Sample n >= 0 of a line of `length` > 1 samples that goes on mirrored at its ends.
std::size_t mirrored(std::size_t n, std::size_t length) {
  const std::size_t period = 2 * length - 2;
  n %= period;
  return n < length ? n : period - n;
}

// Forward recursion over lines whose first sample is already filtered.
void run_forward(double* data, std::size_t length, std::size_t lanes) {
  for (std::size_t n = 1; n < length; ++n) {
    double* row = data + n * lanes;
    for (std::size_t l = 0; l < lanes; ++l) row[l] += kPole * row[l - lanes];
  }
}

// Backward recursion over lines whose last sample is already filtered, and the gain.
void run_backward(double* data, std::size_t length, std::size_t lanes) {
  for (std::size_t n = length - 1; n-- > 0;) {
    double* row = data + n * lanes;
    for (std::size_t l = 0; l < lanes; ++l) row[l] = kPole * (row[l + lanes] - row[l]);
  }
  for (std::size_t i = 0; i < length * lanes; ++i) data[i] *= kGain;
}

}  // namespace

void prefilter_mirrored(double* data, std::size_t length, std::size_t lanes) {
  if (length < 2) return;
  for (std::size_t l = 0; l < lanes; ++l) {
    double sum = 0;
    double power = 1;
    for (std::size_t n = 0; n < kHorizon; ++n) {
      sum += power * data[mirrored(n, length) * lanes + l];
      power *= kPole;
    }
    data[l] = sum;
  }
  run_forward(data, length, lanes);
  double* last = data + (length - 1) * lanes;
  for (std::size_t l = 0; l < lanes; ++l) {
    last[l] = kPole / (kPole * kPole - 1) * (last[l] + kPole * last[l - lanes]);
  }
  run_backward(data, length, lanes);
}

void prefilter_periodic(double* data, std::size_t length, std::size_t lanes) {
  const double closure = 1.0 / (1.0 - std::pow(kPole, static_cast<double>(length)));
  for (std::size_t l = 0; l < lanes; ++l) {
    double sum = 0;
    double power = 1;
    for (std::size_t n = 0; n < length; ++n) {
      sum += power * data[(n == 0 ? 0 : length - n) * lanes + l];
      power *= kPole;
    }
    data[l] = sum * closure;
  }
  run_forward(data, length, lanes);
  double* last = data + (length - 1) * lanes;
  for (std::size_t l = 0; l < lanes; ++l) {
    double sum = 0;
    double power = 1;
    for (std::size_t n = 0; n < length; ++n) {
      sum += power * data[(n == 0 ? length - 1 : n - 1) * lanes + l];
      power *= kPole;
    }
    last[l] = -kPole * closure * sum;
  }
  run_backward(data, length, lanes);
}

namespace {

/// `count` lines along the phases, adjacent in memory from `start` on.
/// @param lines room for their samples
void prefilter_phases(std::vector<std::vector<float>>& phases, std::size_t start, std::size_t count,
                      std::vector<double>& lines) {
  for (std::size_t p = 0; p < phases.size(); ++p) {
    std::copy_n(phases[p].begin() + static_cast<std::ptrdiff_t>(start), count,
                lines.begin() + static_cast<std::ptrdiff_t>(p * count));
  }
  prefilter_periodic(lines.data(), phases.size(), count);
  for (std::size_t p = 0; p < phases.size(); ++p) {
    for (std::size_t i = 0; i < count; ++i) {
      phases[p][start + i] = static_cast<float>(lines[p * count + i]);
    }
  }
}

/// Lines along one axis, `lanes` of them adjacent in memory.
/// @param lines room for their samples
void prefilter_lines(float* first, std::size_t length, std::size_t step, std::size_t lanes,
                     std::vector<double>& lines) {
  lines.resize(length * lanes);
  for (std::size_t n = 0; n < length; ++n) {
    for (std::size_t l = 0; l < lanes; ++l) {
      lines[n * lanes + l] = static_cast<double>(first[n * step + l]);
    }
  }
  prefilter_mirrored(lines.data(), length, lanes);
  for (std::size_t n = 0; n < length; ++n) {
    for (std::size_t l = 0; l < lanes; ++l) {
      first[n * step + l] = static_cast<float>(lines[n * lanes + l]);
    }
  }
}

}  // namespace

void prefilter_cycle(const Lattice& lattice, std::vector<std::vector<float>>& phases) {
  const std::size_t nx = lattice.row();
  const auto ny = static_cast<std::size_t>(lattice.size[1]);
  const auto nz = static_cast<std::size_t>(lattice.size[2]);
  parallel_for(nz, [&](std::size_t k) {
    std::vector<double> lines(phases.size() * nx);
    for (std::size_t j = 0; j < ny; ++j) {
      prefilter_phases(phases, j * nx + k * lattice.slice(), nx, lines);
    }
  });
  parallel_for(phases.size(), [&](std::size_t p) {
    float* volume = phases[p].data();
    std::vector<double> lines;
    const auto filter = [&](float* first, std::size_t length, std::size_t step, std::size_t lanes) {
      prefilter_lines(first, length, step, lanes, lines);
    };
    for (std::size_t row = 0; row < ny * nz; ++row) filter(volume + row * nx, nx, 1, 1);
    for (std::size_t k = 0; k < nz; ++k) filter(volume + k * lattice.slice(), ny, nx, nx);
    for (std::size_t j = 0; j < ny; ++j) filter(volume + j * nx, nz, lattice.slice(), nx);
  });
}

}  // namespace beatlas::pack
