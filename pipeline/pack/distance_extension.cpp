#include "pipeline/pack/distance_extension.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

namespace beatlas::pack {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::max();

// Solves sum over axes of max(0, (u - a_i) / h)^2 = 1 for u; a_i is the smaller neighbour.
double solve_upwind(std::array<double, 3> a, double h) {
  if (a[0] > a[1]) std::swap(a[0], a[1]);
  if (a[1] > a[2]) std::swap(a[1], a[2]);
  if (a[0] > a[1]) std::swap(a[0], a[1]);
  double u = a[0] + h;
  if (u <= a[1]) return u;
  const double difference = a[0] - a[1];
  u = 0.5 * (a[0] + a[1] + std::sqrt(2 * h * h - difference * difference));
  if (u <= a[2]) return u;
  // About a[0], to lose no digits.
  const double b = a[1] - a[0];
  const double c = a[2] - a[0];
  const double sum = b + c;
  return a[0] + (sum + std::sqrt(std::max(0.0, sum * sum - 3 * (b * b + c * c - h * h)))) / 3;
}

/// Which samples nothing changed around since they were looked at, and of which rows that is all.
struct Settled {
  std::vector<std::uint8_t> samples;
  std::vector<std::uint8_t> rows;

  /// A sample of a row changed: its neighbours may have to.
  void unsettle_around(const Lattice& lattice, std::size_t s, std::size_t row) {
    // Past the end of a row or plane this is another sample, which is looked at in vain.
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t step = lattice.stride(axis);
      if (s >= step) samples[s - step] = 0;
      if (s + step < samples.size()) samples[s + step] = 0;
      const std::size_t rows_on = step / static_cast<std::size_t>(lattice.size[0]);
      if (row >= rows_on) rows[row - rows_on] = 0;
      if (row + rows_on < rows.size()) rows[row + rows_on] = 0;
    }
  }
};

/// The samples to find.
struct ToFind {
  std::vector<int> columns;                    // along x, row after row
  std::vector<std::uint32_t> first_of_row{0};  // and one for the end

  ToFind(const Lattice& lattice, const SampleMask& region, const std::vector<std::int8_t>& side) {
    for (std::size_t s = 0; s < side.size();) {
      for (int i = 0; i < lattice.size[0]; ++i, ++s) {
        if (side[s] != 0 && region[s] != 0) columns.push_back(i);
      }
      first_of_row.push_back(static_cast<std::uint32_t>(columns.size()));
    }
  }
  [[nodiscard]] std::size_t row_count() const { return first_of_row.size() - 1; }
  [[nodiscard]] std::span<const int> of_row(std::size_t row) const {
    return {columns.data() + first_of_row[row], first_of_row[row + 1] - first_of_row[row]};
  }
};

/// The smaller of a sample's neighbours along an axis, on the side of `sign`.
double nearer_neighbour(const Lattice& lattice, const std::vector<float>& value, std::size_t s,
                        int coordinate, int axis, float sign) {
  double best = static_cast<double>(kUnknown);
  const std::size_t step = lattice.stride(axis);
  // A neighbour of the other sign can only be a surface, whose distance is 0.
  if (coordinate > 0) best = static_cast<double>(std::max(0.0F, sign * value[s - step]));
  if (coordinate + 1 < lattice.size[static_cast<std::size_t>(axis)]) {
    best = std::min(best, static_cast<double>(std::max(0.0F, sign * value[s + step])));
  }
  return best;
}

/// Calls look_at(i, j, k, sample, row) for the samples to find of rows that are not settled.
/// @param order whose bits say along which axes to go down
template <class LookAt>
void sweep(const Lattice& lattice, const ToFind& to_find, Settled& settled, int order,
           const LookAt& look_at) {
  const std::array<bool, 3> down{(order & 1) != 0, (order & 2) != 0, (order & 4) != 0};
  for (int kk = 0; kk < lattice.size[2]; ++kk) {
    const int k = down[2] ? lattice.size[2] - 1 - kk : kk;
    for (int jj = 0; jj < lattice.size[1]; ++jj) {
      const int j = down[1] ? lattice.size[1] - 1 - jj : jj;
      const std::size_t start = lattice.offset(0, j, k);
      const std::size_t row = start / static_cast<std::size_t>(lattice.size[0]);
      if (settled.rows[row] != 0) continue;
      settled.rows[row] = 1;
      const std::span<const int> of_row = to_find.of_row(row);
      const auto visit = [&](int i) { look_at(i, j, k, start + static_cast<std::size_t>(i), row); };
      if (down[0]) {
        std::for_each(of_row.rbegin(), of_row.rend(), visit);
      } else {
        std::for_each(of_row.begin(), of_row.end(), visit);
      }
    }
  }
}

}  // namespace

void extend_distance(const Lattice& lattice, const SampleMask& region, double voxel_mm,
                     double inner_mm, double outer_mm, std::vector<float>& distance_mm) {
  // side: 0 for kept samples, +1 or -1 for those to find.
  std::vector<std::int8_t> side(distance_mm.size(), 0);
  std::vector<float> value(distance_mm);
  for (std::size_t s = 0; s < distance_mm.size(); ++s) {
    if (is_in_band(distance_mm[s], inner_mm, outer_mm)) continue;
    side[s] = distance_mm[s] < 0 ? -1 : 1;
    value[s] = side[s] < 0 ? -kUnknown : kUnknown;
  }
  const ToFind to_find(lattice, region, side);
  // What upwind differences give is at least that much more than the least neighbour, but for
  // rounding.
  const double least_rise = voxel_mm / std::sqrt(3.0) * (1 - 1e-6);
  // A sample that nothing changed around since it was looked at stays as it is, and is not looked
  // at again (locked points of Bak, McLaughlin and Renzi, SIAM J. Sci. Comput. 32, 2010).
  Settled settled{std::vector<std::uint8_t>(distance_mm.size(), 0),
                  std::vector<std::uint8_t>(to_find.row_count(), 0)};
  const auto look_at = [&](int i, int j, int k, std::size_t s, std::size_t row) {
    if (settled.samples[s] != 0) return;
    settled.samples[s] = 1;
    const auto sign = static_cast<float>(side[s]);
    const std::array<double, 3> near{nearer_neighbour(lattice, value, s, i, 0, sign),
                                     nearer_neighbour(lattice, value, s, j, 1, sign),
                                     nearer_neighbour(lattice, value, s, k, 2, sign)};
    const auto old = static_cast<double>(sign * value[s]);
    if (std::min({near[0], near[1], near[2]}) + least_rise >= old) return;
    const double found = std::max(solve_upwind(near, voxel_mm), side[s] < 0 ? inner_mm : outer_mm);
    if (!(found < old)) return;
    value[s] = sign * static_cast<float>(found);
    settled.unsettle_around(lattice, s, row);
  };
  // A distance goes on along straight lines: each lies in one octant, and the sweep of that octant
  // follows it to its end, so there is no second round.
  for (int order = 0; order < 8; ++order) sweep(lattice, to_find, settled, order, look_at);
  for (std::size_t s = 0; s < distance_mm.size(); ++s) {
    if (std::abs(value[s]) < kUnknown) distance_mm[s] = value[s];
  }
}

}  // namespace beatlas::pack
