#pragma once
/// A field kept in the ways that stand beside ours, asked for value and gradient at (x, t):
/// trilinear, linear in time.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Activate.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/Prune.h>

#include "pipeline/core/shapes.h"
#include "runtime/field/field_query.h"

namespace beatlas::bench {

using field::FieldSample;

/// Two stored phases around a time, linear between them.
struct Moment {
  std::size_t first = 0;
  std::size_t second = 0;
  double share = 0;
};

inline Moment moment_at(double t_s, double rr_s, std::size_t phases) {
  const double beats = t_s / rr_s;
  const double s = (beats - std::floor(beats)) * static_cast<double>(phases);
  Moment out;
  out.first = std::min(static_cast<std::size_t>(s), phases - 1);
  out.second = (out.first + 1) % phases;
  out.share = s - static_cast<double>(out.first);
  return out;
}

/// A lattice as the others use it: index from workspace, clamps.
struct Lattice {
  Index3 size{0, 0, 0};
  Vec3 origin_mm = Vec3::Zero();
  double voxel_mm = 1;
  double inner_mm = 0;
  double outer_mm = 0;
  double rr_s = 1;
};

inline Lattice lattice_of(const FieldCycle& cycle, double rr_s) {
  const Grid& grid = cycle.distance_mm.grid;
  return {grid.size,      grid.mm_from_index.translation(),
          cycle.voxel_mm, cycle.inner_mm,
          cycle.outer_mm, rr_s};
}

inline FieldSample blended(const Lattice& lattice, double a, const Vec3& gradient_a, double b,
                           const Vec3& gradient_b, double share) {
  FieldSample out;
  out.distance_mm = (1 - share) * a + share * b;
  out.gradient = ((1 - share) * gradient_a + share * gradient_b) / lattice.voxel_mm;
  out.in_band = out.distance_mm >= lattice.voxel_mm - lattice.inner_mm &&
                out.distance_mm <= lattice.outer_mm - lattice.voxel_mm;
  return out;
}

/// One float volume a phase.
class DenseField {
 public:
  DenseField(Lattice lattice, std::vector<std::vector<float>> phases)
      : lattice_(std::move(lattice)), phases_(std::move(phases)) {}

  [[nodiscard]] FieldSample sample(const Vec3& x, double t_s) const {
    const Vec3 at = (x - lattice_.origin_mm) / lattice_.voxel_mm;
    const Moment moment = moment_at(t_s, lattice_.rr_s, phases_.size());
    const Vec3 whole = at.array().floor();
    FieldSample outside;
    outside.distance_mm = lattice_.outer_mm;
    std::array<std::size_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double first = whole[static_cast<Eigen::Index>(axis)];
      if (!(first >= 0 && first + 1 < lattice_.size[axis])) return outside;
      cell[axis] = static_cast<std::size_t>(first);
    }
    const auto row = static_cast<std::size_t>(lattice_.size[0]);
    const std::size_t slice = row * static_cast<std::size_t>(lattice_.size[1]);
    const std::size_t corner = cell[0] + row * cell[1] + slice * cell[2];
    const Vec3f u = (at - whole).cast<float>();
    Vec3 gradient_a;
    Vec3 gradient_b;
    const double a = trilinear(&phases_[moment.first][corner], row, slice, u, gradient_a);
    const double b = trilinear(&phases_[moment.second][corner], row, slice, u, gradient_b);
    return blended(lattice_, a, gradient_a, b, gradient_b, moment.share);
  }

 private:
  static double trilinear(const float* v, std::size_t row, std::size_t slice, const Vec3f& u,
                          Vec3& gradient) {
    const auto mix = [](float a, float b, float w) { return a + w * (b - a); };
    const float x00 = v[1] - v[0];
    const float x10 = v[row + 1] - v[row];
    const float x01 = v[slice + 1] - v[slice];
    const float x11 = v[slice + row + 1] - v[slice + row];
    const float c00 = v[0] + u.x() * x00;
    const float c10 = v[row] + u.x() * x10;
    const float c01 = v[slice] + u.x() * x01;
    const float c11 = v[slice + row] + u.x() * x11;
    const float c0 = mix(c00, c10, u.y());
    const float c1 = mix(c01, c11, u.y());
    gradient = Vec3(mix(mix(x00, x10, u.y()), mix(x01, x11, u.y()), u.z()),
                    mix(c10 - c00, c11 - c01, u.z()), c1 - c0);
    return mix(c0, c1, u.z());
  }

  Lattice lattice_;
  std::vector<std::vector<float>> phases_;
};

/// One NanoVDB grid a phase, asked by NanoVDB's own sampler that keeps its last cell.
template <class Build>
class NanoField {
 public:
  using Handles = std::vector<nanovdb::GridHandle<>>;
  using Grid = nanovdb::NanoGrid<Build>;
  using Accessor = typename Grid::AccessorType;
  using Sampler = nanovdb::SampleFromVoxels<Accessor, 1, true>;

  NanoField(Lattice lattice, Handles handles)
      : lattice_(std::move(lattice)), handles_(std::move(handles)) {
    accessors_.reserve(handles_.size());
    for (const auto& handle : handles_) {
      accessors_.push_back(handle.template grid<Build>()->getAccessor());
      samplers_.emplace_back(accessors_.back());
    }
  }

  [[nodiscard]] FieldSample sample(const Vec3& x, double t_s) const {
    const Vec3 at = (x - lattice_.origin_mm) / lattice_.voxel_mm;
    const nanovdb::Vec3f index(static_cast<float>(at.x()), static_cast<float>(at.y()),
                               static_cast<float>(at.z()));
    const Moment moment = moment_at(t_s, lattice_.rr_s, handles_.size());
    const Sampler& first = samplers_[moment.first];
    const Sampler& second = samplers_[moment.second];
    const double a = first(index);
    const nanovdb::Vec3f gradient_a = first.gradient(index);
    const double b = second(index);
    const nanovdb::Vec3f gradient_b = second.gradient(index);
    return blended(lattice_, a, Vec3(gradient_a[0], gradient_a[1], gradient_a[2]), b,
                   Vec3(gradient_b[0], gradient_b[1], gradient_b[2]), moment.share);
  }

 private:
  Lattice lattice_;
  Handles handles_;
  std::vector<Accessor> accessors_;
  std::vector<Sampler> samplers_;
};

inline openvdb::FloatGrid::Ptr narrow_band(const FieldCycle& cycle, std::size_t phase) {
  const Index3& size = cycle.distance_mm.grid.size;
  auto grid = openvdb::FloatGrid::create(static_cast<float>(cycle.outer_mm));
  // Dense's last axis is the fastest one there; ours is x.
  const openvdb::CoordBBox box({0, 0, 0}, {size[0] - 1, size[1] - 1, size[2] - 1});
  const openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ> dense(
      box, cycle.distance_mm.phases[phase].data());
  openvdb::tools::copyFromDense(dense, *grid, 0.0F);
  openvdb::tools::deactivate(*grid, static_cast<float>(-cycle.inner_mm));
  openvdb::tools::prune(grid->tree());
  return grid;
}

template <class Build>
typename NanoField<Build>::Handles nano_grids(const FieldCycle& cycle) {
  typename NanoField<Build>::Handles out;
  for (std::size_t p = 0; p < cycle.distance_mm.phases.size(); ++p) {
    out.push_back(nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, Build>(
        *narrow_band(cycle, p)));
  }
  return out;
}

}  // namespace beatlas::bench
