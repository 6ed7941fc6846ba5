#include "tests/unit/runtime_field/test_fields.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace beatlas::testing {

Vec3 ellipsoid_nearest(const Vec3& axes, const Vec3& x) {
  const Vec3 y = x.cwiseAbs().cwiseMax(1e-9);  // on a plane of symmetry one of the two feet
  const Vec3 squares = axes.cwiseProduct(axes);
  // The foot is squares * y / (squares + m) for the largest root m of the surface's equation.
  double low = -squares.minCoeff();
  double high = axes.maxCoeff() * y.norm();
  for (int i = 0; i < 90; ++i) {
    const double m = 0.5 * (low + high);
    const Vec3 ratio = axes.cwiseProduct(y).cwiseQuotient(squares + Vec3::Constant(m));
    (ratio.squaredNorm() > 1 ? low : high) = m;
  }
  const Vec3 foot =
      squares.cwiseProduct(y).cwiseQuotient(squares + Vec3::Constant(0.5 * (low + high)));
  return {std::copysign(foot[0], x[0]), std::copysign(foot[1], x[1]), std::copysign(foot[2], x[2])};
}

double ellipsoid_distance(const Vec3& axes, const Vec3& x) {
  const double distance = (x - ellipsoid_nearest(axes, x)).norm();
  return x.cwiseQuotient(axes).squaredNorm() < 1 ? -distance : distance;
}

namespace {

// Solves (c[n-1] + 4 c[n] + c[n+1]) / 6 = f[n] by c <- c + f - B c; B's eigenvalues are 1/3..1.
void prefilter(std::vector<double>& samples, const std::vector<std::size_t>& previous,
               const std::vector<std::size_t>& next) {
  std::vector<double> c = samples;
  std::vector<double> update(c.size());
  for (int round = 0; round < 60; ++round) {
    for (std::size_t n = 0; n < c.size(); ++n) {
      update[n] = samples[n] + c[n] / 3 - (c[previous[n]] + c[next[n]]) / 6;
    }
    std::swap(c, update);
  }
  samples = c;
}

}  // namespace

std::shared_ptr<atlas::FieldPayload> dense_payload(const LatticeSpec& spec, const Distance& phi) {
  constexpr int kEdge = atlas::FieldPayload::kBlockEdge;
  const std::array<std::size_t, 4> size{static_cast<std::size_t>(spec.blocks[0] * kEdge),
                                        static_cast<std::size_t>(spec.blocks[1] * kEdge),
                                        static_cast<std::size_t>(spec.blocks[2] * kEdge),
                                        static_cast<std::size_t>(spec.phases)};
  const std::array<std::size_t, 4> stride{1, size[0], size[0] * size[1],
                                          size[0] * size[1] * size[2]};
  std::vector<double> values(stride[3] * size[3]);
  for (std::size_t s = 0; s < values.size(); ++s) {
    const Vec3 index(static_cast<double>(s % size[0]), static_cast<double>(s / stride[1] % size[1]),
                     static_cast<double>(s / stride[2] % size[2]));
    values[s] = phi(spec.origin_mm + spec.voxel_mm * index,
                    spec.rr_interval_s * static_cast<double>(s / stride[3]) / spec.phases);
  }
  for (std::size_t axis = 0; axis < 4; ++axis) {
    const std::size_t n = size[axis];
    std::vector<std::size_t> previous(n);
    std::vector<std::size_t> next(n);
    for (std::size_t i = 0; i < n; ++i) {
      if (axis == 3) {  // periodic
        previous[i] = (i + n - 1) % n;
        next[i] = (i + 1) % n;
      } else {  // mirrored
        previous[i] = i == 0 ? 1 : i - 1;
        next[i] = i + 1 == n ? n - 2 : i + 1;
      }
    }
    std::vector<double> line(n);
    for (std::size_t s = 0; s < values.size(); ++s) {
      if (s / stride[axis] % n != 0) continue;
      for (std::size_t i = 0; i < n; ++i) line[i] = values[s + i * stride[axis]];
      prefilter(line, previous, next);
      for (std::size_t i = 0; i < n; ++i) values[s + i * stride[axis]] = line[i];
    }
  }

  auto payload = std::make_shared<atlas::FieldPayload>();
  payload->origin_mm = spec.origin_mm;
  payload->voxel_mm = spec.voxel_mm;
  payload->block_count = spec.blocks;
  payload->phases = spec.phases;
  payload->step_mm = spec.step_mm;
  payload->inner_mm = spec.inner_mm;
  payload->outer_mm = spec.outer_mm;
  for (int bz = 0; bz < spec.blocks[2]; ++bz) {
    for (int by = 0; by < spec.blocks[1]; ++by) {
      for (int bx = 0; bx < spec.blocks[0]; ++bx) {
        payload->blocks.push_back(static_cast<std::int32_t>(payload->blocks.size()));
        for (int row = 0; row < kEdge * kEdge; ++row) {
          const auto first = static_cast<std::size_t>(bx * kEdge) +
                             static_cast<std::size_t>(by * kEdge + row % kEdge) * stride[1] +
                             static_cast<std::size_t>(bz * kEdge + row / kEdge) * stride[2];
          for (std::size_t p = 0; p < size[3]; ++p) {
            for (std::size_t x = 0; x < kEdge; ++x) {
              const double count =
                  std::clamp(values[first + x + p * stride[3]] / spec.step_mm, -32767.0, 32767.0);
              payload->coefficients.push_back(static_cast<std::int16_t>(std::lround(count)));
            }
          }
        }
      }
    }
  }
  return payload;
}

}  // namespace beatlas::testing
