#include "pipeline/pack/field_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"

namespace beatlas::pack {
namespace {

using atlas::FieldPayload;

constexpr int kEdge = FieldPayload::kBlockEdge;
constexpr int kWide = kEdge + 2;  // a sample of the neighbours on either side
constexpr std::size_t kWideCount = std::size_t{kWide} * kWide * kWide;

// Values of the spline at the samples of a leaf [mm], of one phase's coefficients.
class SampleValues {
 public:
  /// Coefficients of the leaf and one sample around it, [z][y][x].
  void gather(const FieldPayload& field, const LeafNeighbours& around, int phase) {
    std::size_t to = 0;
    for (int z = -1; z <= kEdge; ++z) {
      for (int y = -1; y <= kEdge; ++y) {
        for (int x = -1; x <= kEdge; ++x, ++to) {
          const auto side = [](int n) -> std::size_t { return n < 0 ? 0 : n < kEdge ? 1 : 2; };
          const std::int32_t entry = around[side(x) + 3 * side(y) + 9 * side(z)];
          if (entry < 0) {
            wide_[to] = static_cast<float>(field.clamp_count(entry == FieldPayload::kInside));
            continue;
          }
          const auto within = [](int n) { return (n + kEdge) % kEdge; };
          wide_[to] = static_cast<float>(
              field.coefficients[field.row_at(entry, within(y), within(z)) +
                                 static_cast<std::size_t>(phase * kEdge + within(x))]);
        }
      }
    }
  }
  /// [z][y][x] of the leaf alone; steps.
  std::vector<float> smoothed() {
    for (const std::size_t stride :
         {std::size_t{1}, std::size_t{kWide}, std::size_t{kWide * kWide}}) {
      std::array<float, kWideCount> out = wide_;
      for (std::size_t n = stride; n + stride < kWideCount; ++n) {
        out[n] = (wide_[n - stride] + 4 * wide_[n] + wide_[n + stride]) / 6;
      }
      wide_ = out;
    }
    std::vector<float> out;
    out.reserve(FieldPayload::kBlockSamples);
    constexpr std::size_t kRow = kWide;
    for (std::size_t n = 0; n < FieldPayload::kBlockSamples; ++n) {
      out.push_back(wide_[(n % 8 + 1) + kRow * (n / 8 % 8 + 1) + kRow * kRow * (n / 64 + 1)]);
    }
    return out;
  }

 private:
  std::array<float, kWideCount> wide_{};
};

double leaf_error_mm(const FieldPayload& given, const FieldPayload& stored,
                     const LeafNeighbours& around) {
  const auto phases = static_cast<std::size_t>(given.phases);
  std::vector<std::vector<float>> a;
  std::vector<std::vector<float>> b;
  SampleValues values;
  for (int phase = 0; phase < given.phases; ++phase) {
    values.gather(given, around, phase);
    a.push_back(values.smoothed());
    values.gather(stored, around, phase);
    b.push_back(values.smoothed());
  }
  const auto low = static_cast<float>(-given.inner_mm / given.step_mm);
  const auto high = static_cast<float>(given.outer_mm / given.step_mm);
  float largest = 0;
  for (std::size_t phase = 0; phase < phases; ++phase) {
    const std::size_t before = (phase + phases - 1) % phases;
    const std::size_t after = (phase + 1) % phases;
    for (std::size_t n = 0; n < FieldPayload::kBlockSamples; ++n) {
      const auto in_time = [&](const std::vector<std::vector<float>>& of) {
        return std::clamp((of[before][n] + 4 * of[phase][n] + of[after][n]) / 6, low, high);
      };
      largest = std::max(largest, std::abs(in_time(a) - in_time(b)));
    }
  }
  return given.step_mm * static_cast<double>(largest);
}

}  // namespace

std::vector<LeafNeighbours> leaf_neighbours(const FieldPayload& field) {
  std::vector<LeafNeighbours> out(field.leaf_count());
  const auto [nx, ny, nz] = field.block_count;
  const auto entry_at = [&, nx = nx, ny = ny, nz = nz](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz) return FieldPayload::kOutside;
    return field.blocks[static_cast<std::size_t>(x) +
                        static_cast<std::size_t>(nx) *
                            (static_cast<std::size_t>(y) +
                             static_cast<std::size_t>(ny) * static_cast<std::size_t>(z))];
  };
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const std::int32_t leaf = entry_at(x, y, z);
        if (leaf < 0) continue;
        for (int n = 0; n < 27; ++n) {
          out[static_cast<std::size_t>(leaf)][static_cast<std::size_t>(n)] =
              entry_at(x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1);
        }
      }
    }
  }
  return out;
}

std::vector<double> leaf_errors_mm(const FieldPayload& given, const FieldPayload& stored) {
  const std::vector<LeafNeighbours> around = leaf_neighbours(given);
  std::vector<double> out(around.size());
  parallel_for(out.size(),
               [&](std::size_t leaf) { out[leaf] = leaf_error_mm(given, stored, around[leaf]); });
  return out;
}

}  // namespace beatlas::pack
